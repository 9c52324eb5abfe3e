"""`HexWarFlat-v0`: turns of single pieces, kept directions, stock DQN; the paper's baseline (Fig. 7)."""

from __future__ import annotations

from typing import Any, cast

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env as check_gymnasium
from numpy.typing import NDArray
from stable_baselines3 import DQN
from stable_baselines3.common.env_checker import check_env as check_sb3
from stable_baselines3.common.env_util import make_vec_env as make_stock_vec_env
from stable_baselines3.common.vec_env import VecMonitor

from hexwar_sb3.envs.flat_env import FlatEnv
from hexwar_sb3.envs.flat_games import FlatGames
from hexwar_sb3.envs.flat_vec_env import FlatVecEnv
from hexwar_sb3.envs.registration import FLAT_ENV, make_vec_env
from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.evaluation.matches import play_match
from hexwar_sb3.maps.cells import NO_CELL
from hexwar_sb3.maps.geometry import NE, W
from hexwar_sb3.play.match import play_games
from hexwar_sb3.tasks.features import feature_index
from hexwar_sb3.tasks.records import MAX_TASKS, TaskKind
from hexwar_sb3.tasks.route import N_ANSWERS

SHORT = 300  # Delta-t: a game in six decisions
PACE = 75  # in which pieces meet and die
STOP = 0
Outcome = tuple[float, ...]  # win, margin, return, turns


def vec_env(n_envs: int, **settings: Any) -> VecMonitor:
    own = {"decision_ticks": SHORT, "opponent": "random", "seed": 0}
    return make_vec_env(FLAT_ENV, n_envs, **{**own, **settings})


def native(env: VecMonitor) -> FlatVecEnv:
    return cast("FlatVecEnv", env.unwrapped)


def single(**settings: Any) -> FlatEnv:
    env = FlatEnv(**{"decision_ticks": SHORT, "opponent": "random", **settings})
    env.reset(seed=0)
    return env


def pick(masks: NDArray[np.bool_], obs: NDArray[Any]) -> NDArray[np.int64]:
    """A legal action of every row that depends on what it sees alone, [n]."""
    numbers = (1000 * np.abs(obs).sum(axis=1)).astype(int)
    legal = [np.flatnonzero(mask) for mask in masks]
    return np.array([ways[number % len(ways)] for ways, number in zip(legal, numbers, strict=True)])


def decide(env: FlatEnv, slot: int, action: int) -> list[dict[str, Any]]:
    """Play one decision in which one piece acts and the others stop; the infos of its turns."""
    infos: list[dict[str, Any]] = []
    while not infos or infos[-1]["ticks"] == 0:
        acts = env.games.acting[0] == slot
        infos.append(env.step(np.int64(action if acts else STOP))[-1])
    return infos


def first_task(games: FlatGames, slot: int) -> int:
    """The first task of a piece for which it has to go somewhere."""
    kinds, valid = games.sight.rows[0, slot].kind, games.sight.obs["action_mask"][0, slot] != 0
    return int(np.flatnonzero(valid & (kinds != TaskKind.STOP) & (kinds != TaskKind.RECOVER))[0])


def go(games: FlatGames, slot: int, direction: int) -> int:
    """The action: the first task, and a direction to keep."""
    return first_task(games, slot) * N_ANSWERS + 1 + direction


def slot_of(env: FlatEnv, name: str) -> int:
    return env.games.arena.world.piece_names(0).index(name)


def cell_of(env: FlatEnv, slot: int) -> int:
    return int(env.games.arena.state.pieces.cell[0, slot])


def ray(env: FlatEnv, cell: int, direction: int) -> list[int]:
    """Cells from a cell to the edge of the map in a direction."""
    cells = [cell]
    while cells[-1] != NO_CELL:
        cells.append(int(env.games.arena.world.cells[cells[-1]].neighbour[direction]))
    return cells[:-1]


def test_gymnasium_finds_nothing_wrong() -> None:
    check_gymnasium(gymnasium.make(FLAT_ENV, decision_ticks=SHORT).unwrapped, skip_render_check=True)


def test_stable_baselines3_finds_nothing_wrong() -> None:
    check_sb3(FlatEnv(decision_ticks=SHORT))


def test_stable_baselines3_makes_it_by_its_id_and_gets_a_picture() -> None:
    env = make_stock_vec_env(FLAT_ENV, n_envs=1, env_kwargs={"decision_ticks": SHORT})
    env.reset()
    picture = env.render()
    assert picture is not None
    assert picture.ndim == 3
    with pytest.raises(UnknownNameError, match="unknown render_mode 'ansi'"):
        FlatEnv(render_mode="ansi")


def test_living_pieces_have_their_turns_by_slot_and_dead_ones_none() -> None:
    env = single()
    games, dead = env.games, slot_of(env, "tank1")
    n_own = games.picked.shape[1]

    turns = []
    for _ in range(n_own):
        turns.append(int(games.acting[0]))
        env.step(np.int64(STOP))
    assert turns == list(range(n_own))

    games.arena.state.pieces.blood[0, dead] = 0
    decide(env, slot=0, action=STOP)  # to the next decision, which sees it
    turns = []
    for _ in range(n_own - 1):
        turns.append(int(games.acting[0]))
        env.step(np.int64(STOP))
    assert turns == [slot for slot in range(n_own) if slot != dead]
    assert games.acting[0] == 0


def test_time_and_reward_come_with_the_last_turn_alone() -> None:
    """Eq. (3): the rewards add up to the gain of the score; MA1 takes the points meanwhile."""
    env = single(decision_ticks=PACE, opponent="MA1", reward="net")
    totals = []
    for seed in range(2):
        obs, total, over = env.reset(seed=seed)[0], 0.0, False
        first = env.games.scores()[0]
        while not over:
            tick, acting = int(env.games.arena.state.games.tick[0]), int(env.games.acting[0])
            alive = np.flatnonzero(env.games.sight.obs["alive"][0])
            obs, reward, over, truncated, info = env.step(pick(env.action_masks()[None], obs[None])[0])
            passed = int(env.games.arena.state.games.tick[0]) - tick
            assert info["ticks"] == passed
            assert passed == (PACE if acting == alive[-1] else 0)
            assert passed or reward == 0.0
            assert not truncated
            total += reward
        assert total == env.games.scores()[0] - first
        totals.append(total)
    assert any(totals)
    assert {"win", "points_held", "side", "opponent"} <= info.keys()


def test_a_direction_is_kept_through_cells_and_other_pieces_turns() -> None:
    env = single(decision_ticks=PACE)
    slot = slot_of(env, "aerocraft0")
    way = ray(env, cell_of(env, slot), NE)
    hop = int(env.games.arena.world.rules[0].base_hop[env.games.arena.state.pieces.kind[0, slot]])

    decide(env, slot, go(env.games, slot, NE))

    assert cell_of(env, slot) == way[PACE // hop]


def test_a_kept_direction_ends_where_there_is_no_way_and_is_illegal_there() -> None:
    env = single()
    slot = slot_of(env, "aerocraft0")
    edge = ray(env, cell_of(env, slot), W)[-1]
    action = go(env.games, slot, W)

    infos = decide(env, slot, action)
    assert cell_of(env, slot) == edge
    assert sum(info["illegal_actions"] for info in infos) == 0

    infos = decide(env, slot, go(env.games, slot, W))
    assert cell_of(env, slot) == edge
    assert [info["illegal_actions"] for info in infos] == [int(k == slot) for k in range(len(infos))]


def test_the_next_decision_ends_a_direction() -> None:
    """Answer 0 is to stay and perform."""
    env = single(decision_ticks=PACE)
    slot = slot_of(env, "aerocraft0")
    decide(env, slot, go(env.games, slot, NE))
    decide(env, slot, first_task(env.games, slot) * N_ANSWERS)
    stays = cell_of(env, slot)
    decide(env, slot, first_task(env.games, slot) * N_ANSWERS)
    assert cell_of(env, slot) == stays


@pytest.mark.parametrize("action", [(MAX_TASKS - 1) * N_ANSWERS + 1, MAX_TASKS * N_ANSWERS, -1])
def test_an_invalid_task_stands_for_stop_and_is_counted(action: int) -> None:
    env = single(decision_ticks=PACE)
    slot = slot_of(env, "aerocraft0")
    start = cell_of(env, slot)
    infos = decide(env, slot, action)
    assert infos[slot]["illegal_actions"] == 1
    assert env.games.arena.missions.kind[0, slot] == TaskKind.STOP
    assert cell_of(env, slot) == start


def test_legal_actions_by_the_mask_are_those_that_are_not_counted() -> None:
    env = single()
    rng = np.random.default_rng(0)
    for _ in range(20):
        action = rng.integers(MAX_TASKS * N_ANSWERS)
        action = action if rng.random() < 0.5 else rng.choice(np.flatnonzero(env.action_masks()))
        legal = env.action_masks()[action]
        assert env.step(action)[-1]["illegal_actions"] == int(not legal)


def test_the_observation_is_the_acting_pieces_own() -> None:
    """Its o, which tells its slot, then its task rows; rows of masked tasks are 0."""
    env = single()
    sight, n_own = env.games.sight, env.games.picked.shape[1]
    slots = feature_index("obs", n_own, n_own, len(env.games.arena.world.scenario.points))["self: slot"]
    for slot in range(n_own):
        obs, width = env.games.observe()[0], sight.obs["obs"].shape[-1]
        assert obs[slots].argmax() == slot
        rows = obs[width:].reshape(MAX_TASKS, -1)
        assert np.array_equal(rows, sight.obs["tasks"][0, slot])
        assert not rows[sight.obs["action_mask"][0, slot] == 0].any()
        env.step(np.int64(STOP))


def test_a_wiped_out_camp_waits_for_the_end_within_its_last_turn() -> None:
    env = single()
    for _ in range(env.games.picked.shape[1] - 1):
        env.step(np.int64(STOP))
    env.games.arena.state.pieces.blood[0, env.games.arena.world.side(0)] = 0
    _, _, over, _, info = env.step(np.int64(STOP))
    assert over
    assert info["ticks"] == env.games.arena.world.scenario.game_ticks


def test_the_single_env_is_the_vec_env_of_one_game() -> None:
    env, batch = single(), vec_env(1, seed=0)
    obs, batch_obs = env.games.observe()[0], cast("NDArray[Any]", batch.reset())
    over = False
    while not over:
        assert np.array_equal(obs, batch_obs[0])
        action = pick(env.action_masks()[None], obs[None])
        obs, reward, over, truncated, info = env.step(action[0])
        batch_obs, rewards, dones, infos = batch.step(action)  # type: ignore[assignment]
        assert (reward, over, truncated) == (rewards[0], dones[0], False)
        assert info.items() <= infos[0].items()
    assert np.array_equal(obs, infos[0]["terminal_observation"])
    assert infos[0]["TimeLimit.truncated"] is False
    assert not np.array_equal(obs, batch_obs[0])  # a new game has begun


def outcomes(env: VecMonitor, episodes: int) -> dict[int, Outcome]:
    """Outcomes of the first episodes by their numbers; games end at different steps."""
    obs, found = cast("NDArray[Any]", env.reset()), dict[int, Outcome]()
    while not set(range(episodes)) <= found.keys():
        numbers = native(env).games.episodes.copy()
        obs, _, dones, infos = env.step(pick(native(env).action_masks(), obs))  # type: ignore[assignment]
        for b in np.flatnonzero(dones):
            info, record = infos[b], infos[b]["episode"]
            found[int(numbers[b])] = info["win"], info["margin"], record["r"], record["l"]
    return {number: found[number] for number in range(episodes)}


def test_episodes_do_not_depend_on_the_number_of_games() -> None:
    settings: dict[str, Any] = {"side": "both", "opponent": ["nearest", "random"], "seed": 4}
    settings["decision_ticks"] = PACE
    alone = outcomes(vec_env(1, **settings), 4)
    assert alone == outcomes(vec_env(3, **settings), 4)
    assert len({turns for *_, turns in alone.values()}) > 1  # as many as pieces lived


def test_a_restored_env_goes_on_as_before() -> None:
    settings: dict[str, Any] = {"side": "both", "seed": 2}
    env, other = vec_env(2, **settings), vec_env(2, **settings)
    obs = cast("NDArray[Any]", env.reset())
    for _ in range(10):  # into the second decision
        obs, *_ = env.step(pick(native(env).action_masks(), obs))  # type: ignore[assignment]

    restored = native(other).restore(native(env).snapshot())

    assert np.array_equal(obs, restored)
    for _ in range(20):
        obs, rewards, *_ = env.step(pick(native(env).action_masks(), obs))  # type: ignore[assignment]
        restored, others, *_ = other.step(pick(native(other).action_masks(), restored))  # type: ignore[assignment]
        assert np.array_equal(rewards, others)
        assert np.array_equal(obs, restored)


def test_a_demonstration_is_the_bots_own_game_named_by_legal_turns() -> None:
    env = vec_env(2, opponent="nearest", demo="MA2", demo_share=1.0, decision_ticks=PACE, seed=5)
    env.reset()
    turns, moves, margins = 0, 0, dict[int, float]()
    while len(margins) < 2:
        masks = native(env).action_masks()
        _, _, dones, infos = env.step(np.zeros(2, np.int64))
        for b in set(range(2)) - margins.keys():
            task, answer = divmod(int(infos[b]["demo_actions"]), N_ANSWERS)
            assert masks[b].reshape(MAX_TASKS, N_ANSWERS)[task].any()
            turns, moves = turns + 1, moves + (answer > 0)
        margins |= {int(b): infos[b]["margin"] for b in np.flatnonzero(dones) if b not in margins}

    assert [margins[0], margins[1]] == play_games("MA2", "nearest", 2, seed=5).margin.tolist()
    assert 0.2 < moves / turns < 0.8


@pytest.mark.parametrize("name", ["lower", "privileged_state"])
def test_settings_that_make_no_sense_here_are_refused(name: str) -> None:
    with pytest.raises(ConfigError, match=f"the flat env has no {name}: "):
        FlatEnv(**{name: "heuristic"})


@pytest.mark.parametrize("actions", [np.zeros((1, 7), int), np.zeros(2, int), np.zeros(1)])
def test_actions_of_another_shape_are_refused(actions: Any) -> None:
    batch = vec_env(1)
    batch.reset()
    with pytest.raises(ConfigError, match=r"actions must be whole numbers of shape \(1,\)"):
        batch.step(actions)


def test_half_precision_is_the_same_observation() -> None:
    full, half = (cast("NDArray[Any]", vec_env(1, dtype=dtype).reset()) for dtype in ("float32", "float16"))
    assert half.dtype == np.float16
    assert np.allclose(full, half, atol=1e-2)


def test_stock_dqn_learns_and_plays_matches() -> None:
    """SB3 unchanged: its model is a player, and an opponent."""
    env = vec_env(2)
    model = DQN(
        "MlpPolicy", env, buffer_size=300, learning_starts=50, batch_size=8, train_freq=4, seed=0,
        policy_kwargs={"net_arch": [8]},
    )  # fmt: skip
    before = model.q_net.state_dict()["q_net.0.weight"].clone()
    model.learn(200)
    assert (model.q_net.state_dict()["q_net.0.weight"] != before).any()

    result = play_match(model, "random", games=2, decision_ticks=SHORT)
    assert result.red_name == "DQN"
    assert result.red.scores.shape == (2,)

    rival = single(side="blue", opponent=model)
    assert decide(rival, slot=0, action=STOP)[-1]["ticks"] == SHORT
