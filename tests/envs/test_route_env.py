"""HexWarRoute-v0: contracts, the reward of eq. (5), how routes begin and end, and who plays the rest."""

from __future__ import annotations

import io
from typing import Any, cast

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env as check_gymnasium
from numpy.typing import NDArray
from stable_baselines3.common.env_checker import check_env as check_sb3
from stable_baselines3.common.env_util import make_vec_env as make_stock_vec_env

from hexwar_sb3.algorithms.beside import executor
from hexwar_sb3.envs.registration import ROUTE_ENV, make_vec_env
from hexwar_sb3.envs.route_env import RouteEnv
from hexwar_sb3.envs.route_games import RouteGames
from hexwar_sb3.envs.route_settings import route_settings
from hexwar_sb3.envs.route_vec_env import RouteVecEnv
from hexwar_sb3.errors import ConfigError, HexWarError, UnknownNameError
from hexwar_sb3.players.frozen_lower import FORMAT, SIZES, FrozenLower
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.tasks.features import PER_DETOUR, PER_HOP, feature_index
from hexwar_sb3.tasks.records import ENDED, TaskKind
from hexwar_sb3.tasks.route import STAY

PLACES = feature_index("route", 1, 1, 1)
TYPES, HERE, WAY = PLACES["piece: type"], PLACES["goal: here"].start, PLACES["goal: way"].start
DETOURS = [PLACES[f"neighbour {d}: detour"].start for d in range(6)]
EASES = [PLACES[f"neighbour {d}: ease"].start for d in range(6)]
BASE_TICKS = np.array([20, 20, 144, 8])  # of a hop on open ground, by type (rule book, section 1)
GAMMA, BETA = 0.99, 0.05  # defaults
LONG_WALKS: dict[str, Any] = {"wander": 1.0, "keep_task": 1.0}  # to random cells, and nobody changes its mind

Obs = dict[str, NDArray[Any]]


def make(n_envs: int = 2, seed: int = 0, **settings: Any) -> RouteVecEnv:
    return RouteVecEnv(n_envs, route_settings(settings), seed)


def heuristic(obs: Obs) -> NDArray[np.int64]:
    """The smallest detour, the first of equals; stay in the right place: obs [n, Dl] or [Dl]."""
    states, masks = np.atleast_2d(obs["obs"]), np.atleast_2d(obs["action_mask"])
    detours = np.where(masks[:, 1:] != 0, states[:, DETOURS], np.inf)
    return np.where(states[:, HERE] == 1, STAY, 1 + detours.argmin(axis=1))


def pick(obs: Obs, step: int) -> NDArray[np.int64]:
    """Valid answers that depend on observation and step alone; mostly the heuristic's."""
    masks = obs["action_mask"]
    order = np.argsort(1 - masks, axis=-1, kind="stable")
    wanted = np.take_along_axis(order, ((5 * step + 1) % masks.sum(axis=-1))[:, None], axis=-1)[:, 0]
    return wanted if step % 4 == 3 else heuristic(obs)


class Step:
    """What one game showed in one step of `played`."""

    def __init__(
        self, before: Obs, answer: int, after: Obs, reward: float, done: bool, info: dict[str, Any]
    ) -> None:
        self.state, self.answer, self.after = before["obs"], answer, after["obs"]
        self.reward, self.done, self.info = reward, done, info
        self.kind = int(self.state[TYPES].argmax())

    @property
    def finished(self) -> bool:
        return bool(self.info.get("finished", False))

    @property
    def hops(self) -> float:
        """Base hops of the hop that was chosen."""
        return 1.0 / float(self.state[EASES[self.answer - 1]])

    @property
    def detour(self) -> float:
        """Base hops that it loses."""
        return float(self.state[DETOURS[self.answer - 1]]) / PER_DETOUR


def played(env: RouteVecEnv, steps: int, *, wild: bool = False) -> list[list[Step]]:
    """Steps of every game: the heuristic's answers, or now and then others (`wild`)."""
    found: list[list[Step]] = [[] for _ in range(env.num_envs)]
    obs = env.reset()
    for step in range(steps):
        before = {key: value.copy() for key, value in obs.items()}
        answers = pick(before, step) if wild else heuristic(before)
        after, rewards, dones, infos = env.step(answers)
        obs = cast("Obs", after)
        for b in range(env.num_envs):
            one = {key: value[b] for key, value in before.items()}
            end = infos[b].get("terminal_observation", {key: value[b].copy() for key, value in obs.items()})
            found[b].append(Step(one, int(answers[b]), end, float(rewards[b]), bool(dones[b]), infos[b]))
    return found


def flat(games: list[list[Step]]) -> list[Step]:
    return [step for game in games for step in game]


def lower(seed: int = 0) -> FrozenLower:
    rng = np.random.default_rng(seed)
    return FrozenLower(
        {
            name: rng.normal(size=[SIZES[a] for a in axes]).astype(np.float32)
            for name, axes in FORMAT.layers.items()
        }
    )


def equal(one: Any, other: Any) -> bool:
    return all(np.array_equal(one[key], other[key]) for key in one)


# Contracts


def test_gymnasium_finds_nothing_wrong() -> None:
    check_gymnasium(gymnasium.make(ROUTE_ENV).unwrapped, skip_render_check=True)


def test_stable_baselines3_finds_nothing_wrong() -> None:
    check_sb3(RouteEnv())


def test_stable_baselines3_makes_it_by_its_id() -> None:
    """SB3 asks for a picture of every env that it makes itself."""
    env = make_stock_vec_env(ROUTE_ENV, n_envs=2, seed=0)
    obs = cast("Obs", env.reset())
    for _ in range(20):
        after, _, _, _ = env.step(heuristic(obs))
        obs = cast("Obs", after)
    assert obs["obs"].shape == (2, SIZES["state"])


def test_an_unknown_render_mode_is_named() -> None:
    with pytest.raises(UnknownNameError, match="unknown render_mode 'ansi'"):
        RouteEnv(render_mode="ansi")


def test_the_single_env_is_the_vec_env_of_one_game() -> None:
    """The single one shows a route's last observation, and the next route's first at reset."""
    env, batch = RouteEnv(keep_task=0.5), make(1, seed=3, keep_task=0.5)
    obs, _ = env.reset(seed=3)
    many, ends = batch.reset(), 0
    for step in range(80):
        assert equal(obs, {key: value[0] for key, value in many.items()})
        assert (env.action_masks() == batch.action_masks()[0]).all()
        answer = pick(many, step)
        obs, reward, terminated, truncated, info = env.step(answer[0])
        after, rewards, dones, infos = batch.step(answer)
        many = cast("Obs", after)
        assert (reward, terminated or truncated) == (rewards[0], dones[0])
        assert info["ticks"] == infos[0]["ticks"]
        if dones[0]:
            ends += 1
            assert truncated == infos[0]["TimeLimit.truncated"] != terminated
            assert equal(obs, infos[0]["terminal_observation"])
            obs, _ = env.reset()
    assert ends > 3


def test_the_seed_decides() -> None:
    one, same, other = (flat(played(make(seed=seed), 20)) for seed in (1, 1, 2))
    assert [step.reward for step in one] == [step.reward for step in same]
    assert [step.reward for step in one] != [step.reward for step in other]


def test_a_reset_in_the_middle_of_a_route_begins_a_new_game() -> None:
    env = RouteEnv()
    env.reset(seed=0)
    env.step(np.int64(1))
    first = int(env.venv.fields[0].tasks.episodes[0])
    env.reset()
    assert int(env.venv.fields[0].tasks.episodes[0]) > first


@pytest.mark.parametrize("answers", [np.zeros(3, int), np.zeros((2, 1), int), np.zeros(2), None])
def test_answers_of_another_shape_are_refused(answers: Any) -> None:
    env = make(2)
    env.reset()
    with pytest.raises(ConfigError, match=r"actions must be whole numbers of shape \(2,\)"):
        env.step(answers)


# The reward, eq. (5)


def test_a_step_costs_beta_a_base_hop_and_the_end_of_a_task_brings_1() -> None:
    """r_L = r_task + alpha r_Sigma - beta; with alpha = 0, and beta by the type's hop on open ground."""
    steps = flat(played(make(3, alpha=0.0, beta=0.2, shaping=0.0), 60, wild=True))
    for step in steps:
        assert step.reward == pytest.approx(step.finished - 0.2 * step.info["steps"], abs=1e-5)
        assert step.reward == pytest.approx(step.info["lower_reward"], abs=1e-6)
        if not step.done:
            assert step.info["steps"] == pytest.approx(step.info["ticks"] / BASE_TICKS[step.kind])
    assert any(step.finished for step in steps)
    assert any(step.info["steps"] > 1 for step in steps)


def test_a_hop_lasts_as_long_as_it_takes_that_type_even_if_its_route_is_cut() -> None:
    """What is left of a hop under way is counted; only waiting for something else makes it longer."""
    steps = [step for step in flat(played(make(4), 80, wild=True)) if step.answer != STAY]
    lengths = np.array([step.info["steps"] / step.hops for step in steps])
    assert (np.isclose(lengths, 1.0)).mean() > 0.9


def test_beta_may_be_charged_by_the_hop() -> None:
    """To the letter of eq. (5)."""
    steps = flat(played(make(3, alpha=0.0, beta_per="hop"), 40, wild=True))
    for step in steps:
        assert step.info["steps"] == 1.0
        assert step.reward == pytest.approx(step.finished - BETA)


def test_finishing_takes_no_time() -> None:
    for step in flat(played(make(3), 60)):
        if step.finished:
            assert step.info["steps"] == 0.0
            assert step.info["lower_reward"] == 1.0


@pytest.mark.parametrize("limit", [10.0, float("inf")])
def test_alpha_weighs_the_gain_of_the_camp(limit: float) -> None:
    """r_Sigma is the gain of own minus enemy points in that step, cut off at `gain_limit`."""
    env = make(1, seed=2, alpha=0.5, beta=0.0, opponent="MA2", shaping=0.0, gain_limit=limit)
    games, obs, gains = env.fields[0], env.reset(), 0
    for step in range(250):
        before = games.tasks.scores()[0]
        after, rewards, dones, _ = env.step(pick(obs, step))
        obs = cast("Obs", after)
        if not dones[0]:
            gain = games.tasks.scores()[0] - before
            assert rewards[0] == pytest.approx(0.5 * max(-limit, min(limit, gain)))
            gains += gain != 0
    assert gains > 3


def fixed_walks(steps: list[Step]) -> list[Step]:
    """Hops towards a cell that stays where it is, without waiting."""
    hold = PLACES["piece: task kind"].start + TaskKind.HOLD
    return [
        step for step in steps
        if not step.done and step.answer != STAY and step.state[hold] == 1 and step.state[WAY] < 1.9
        and np.isclose(step.info["steps"], step.hops)
    ]  # fmt: skip


def worth(hops: float) -> float:
    """What a fastest way of some base hops is worth: its end brings 1, each hop costs beta."""
    return float(GAMMA**hops - BETA * sum(GAMMA**k for k in range(round(hops))))


def test_with_the_potential_a_hop_on_a_fastest_way_brings_about_0() -> None:
    """What is left to learn is what a hop loses."""
    steps = fixed_walks(flat(played(make(4, alpha=0.0, **LONG_WALKS), 80)))
    assert len(steps) > 100
    assert max(abs(step.reward) for step in steps if step.hops == 1) < 1e-4
    assert np.mean([abs(step.reward) < 0.02 for step in steps]) > 0.95


def test_with_the_potential_a_detour_costs_about_beta_a_base_hop() -> None:
    """Exactly: gamma^n P(way + detour - n) - P(way) - beta n, with P the worth of a fastest way."""
    steps = fixed_walks(flat(played(make(4, alpha=0.0, **LONG_WALKS), 120, wild=True)))
    detours = [step for step in steps if 0 < step.detour < 9]
    assert len(detours) > 20
    for step in detours:
        way = round(float(step.state[WAY]) / PER_HOP)
        after, n = way + round(step.detour) - round(step.hops), step.hops
        assert step.reward == pytest.approx(GAMMA**n * worth(after) - worth(way) - BETA * n, abs=1e-3)
        assert -1.4 * BETA * step.detour < step.reward < -0.3 * BETA * step.detour


def test_the_potential_changes_no_return_of_a_finished_route_but_by_where_it_starts() -> None:
    """Ng, Harada, Russell 1999: the discounted sum of what it adds is minus the worth of the first state."""
    for game in played(make(3, **LONG_WALKS), 80, wild=True):
        added, hops, first = 0.0, 0.0, game[0]
        for step in game:
            added += GAMMA**hops * (step.reward - step.info["lower_reward"])
            hops += step.info["steps"]
            if step.finished:
                way = round(float(first.state[WAY]) / PER_HOP)
                assert added == pytest.approx(-worth(way), abs=1e-3)
            if step.done:
                added, hops, first = 0.0, 0.0, game[min(game.index(step) + 1, len(game) - 1)]


@pytest.mark.parametrize("setting", [{"shaping": 0.0}, {"ways": False}, {"beta_per": "hop"}])
def test_there_is_no_potential_without_ways_time_or_its_discount(setting: dict[str, Any]) -> None:
    for step in flat(played(make(2, **setting), 25)):
        assert step.reward == pytest.approx(step.info["lower_reward"], abs=1e-6)


def test_without_ways_the_state_has_none() -> None:
    env = make(2, ways=False)
    assert not env.reset()["obs"][:, [WAY, *DETOURS]].any()


# How routes begin and end


def test_a_route_is_over_exactly_when_it_is_finished_or_cut_short() -> None:
    """Finished: it stays in the right place. Cut: another task, an ended one, the piece's loss, the game's end."""
    games = RouteGames(4, route_settings({"keep_task": 0.5, "opponent": "MA2"}), "plain", seed=1)
    games.begin(games.all)
    seen: dict[str, int] = {}
    for step in range(300):
        games.look()
        before = games.arena.missions[games.all, games.focus.piece].copy()
        obs = {"obs": games.state.copy(), "action_mask": games.mask.copy()}
        answers = pick(obs, step)
        hop = games.play(answers)
        for b in range(4):
            why = why_over(games, b, obs, int(answers[b]), before[b])
            assert (why == "finished") == hop.finished[b]
            assert (why not in {"finished", "goes on"}) == hop.cut[b], why
            seen[why] = seen.get(why, 0) + 1
        games.next_route(games.all[hop.over])
    assert min(seen[why] for why in ("finished", "other task", "lost", "end of the game", "goes on")) > 1, (
        seen
    )


def why_over(games: RouteGames, b: int, obs: Obs, answer: int, before: Any) -> str:
    """How a route stands after a step, from the state of the game alone."""
    if answer == STAY and obs["obs"][b, HERE] == 1:
        return "finished"
    piece, mission = (
        rows[b, games.focus.piece[b]] for rows in (games.arena.state.pieces, games.arena.missions)
    )
    if games.arena.state.games[b].over:
        return "end of the game"
    if piece.blood == 0:
        return "lost"
    if any(mission[name] != before[name] for name in ("kind", "target", "cell")):
        return "other task"
    return "ended" if mission.state == ENDED else "goes on"


def test_a_finished_route_is_terminated_and_any_other_truncated() -> None:
    env = RouteEnv(keep_task=0.9)
    obs, _ = env.reset(seed=1)
    ends = {True: 0, False: 0}
    for _ in range(300):
        at_goal = obs["obs"][HERE] == 1
        obs, _, terminated, truncated, info = env.step(heuristic(obs)[0])
        assert terminated == at_goal == info.get("finished", False)
        if terminated or truncated:
            assert terminated != truncated
            ends[terminated] += 1
            obs, _ = env.reset()
    assert min(ends.values()) > 3


def test_the_loss_of_the_piece_cuts_its_route() -> None:
    """A loss costs the camp; were it an end, it would save the rest of the way."""
    games = RouteGames(1, route_settings(LONG_WALKS), "plain", seed=0)
    games.begin(games.all)
    games.look()
    games.arena.state.pieces[0, games.focus.piece[0]].blood = 0

    hop = games.play(heuristic({"obs": games.state, "action_mask": games.mask}))

    assert hop.cut.tolist() == [True]
    assert hop.finished.tolist() == [False]


def test_the_end_of_the_game_cuts_its_route_and_another_game_begins() -> None:
    games = RouteGames(1, route_settings(LONG_WALKS), "plain", seed=0)
    games.begin(games.all)
    games.look()
    game = games.arena.state.games[0]
    game.end_tick = game.tick + 1

    hop = games.play(heuristic({"obs": games.state, "action_mask": games.mask}))
    assert hop.cut.tolist() == [True]
    assert hop.ticks.tolist() == [1]

    games.next_route(games.all)
    assert games.tasks.episodes.tolist() == [1]


def test_what_a_cut_route_shows_last_is_where_its_hop_leads() -> None:
    """The state of its own goal, from the cell that it is about to enter: the value of the rest is bootstrapped."""
    checked = 0
    for step in flat(played(make(4, keep_task=0.0, alpha=0.0), 60)):
        if (
            step.done
            and not step.finished
            and step.answer != STAY
            and np.isclose(step.info["steps"], step.hops)
        ):
            kinds = PLACES["piece: type"], PLACES["piece: task kind"]
            if (
                all((step.state[place] == step.after[place]).all() for place in kinds)
                and step.state[WAY] < 1.9
            ):
                way = step.state[WAY] / PER_HOP + step.detour - step.hops
                if np.isclose(step.after[WAY] / PER_HOP, way, atol=0.05):
                    gain = GAMMA**step.hops * worth(way) - worth(way - step.detour + step.hops)
                    assert step.reward == pytest.approx(gain - BETA * step.hops, abs=1e-3)
                    checked += 1
    assert checked > 10


def test_the_next_route_is_that_of_the_next_piece_of_the_same_game() -> None:
    games = RouteGames(1, route_settings({"keep_task": 0.0}), "plain", seed=0)
    games.begin(games.all)
    pieces, ticks = [int(games.focus.piece[0])], []
    while len(pieces) < 5:
        games.look()
        if games.play(heuristic({"obs": games.state, "action_mask": games.mask})).over[0]:
            games.next_route(games.all)
            pieces.append(int(games.focus.piece[0]))
            ticks.append(int(games.arena.state.games[0].tick))

    assert games.tasks.episodes.tolist() == [0]
    assert ticks == sorted(ticks)
    assert len(set(pieces[:3])) == 3


def test_all_types_of_pieces_get_routes() -> None:
    """Soldiers too, who have to be set down first."""
    steps = flat(played(make(8), 150))
    shares = np.bincount([step.kind for step in steps], minlength=len(PieceType)) / len(steps)
    assert (shares > 0.01).all(), shares


def test_both_camps_get_routes() -> None:
    env = make(2)
    env.reset()
    assert env.fields[0].tasks.camps.tolist() == [0, 1]
    sides = {int(piece) // 7 for piece in env.fields[0].focus.piece}
    assert sides == {0, 1}


def test_walks_to_random_cells_lead_far_and_tasks_alone_to_few_places() -> None:
    goals: dict[float, set[tuple[float, ...]]] = {}
    for wander in (0.0, 1.0):
        games = RouteGames(4, route_settings({"wander": wander, "side": "red"}), "plain", seed=0)
        games.begin(games.all)
        goals[wander] = set()
        for _ in range(60):
            games.look()
            goals[wander] |= {(int(g),) for g in games.arena.missions.goal[games.all, games.focus.piece]}
            hop = games.play(heuristic({"obs": games.state, "action_mask": games.mask}))
            games.next_route(games.all[hop.over])
    assert len(goals[1.0]) > len(goals[0.0])


def test_every_tick_of_the_games_is_in_some_info() -> None:
    """Of the way, and of the time until the next piece asks: phases are counted in ticks."""
    env = RouteVecEnv(2, route_settings({"opponent": "MA2"}), seed=1)
    obs, fields = env.reset(), env.fields[0]
    counted = fields.arena.state.games.tick.astype(np.int64)
    for step in range(400):
        episodes, before = fields.tasks.episodes.copy(), fields.arena.state.games.tick.copy()
        obs, _, _, infos = env.step(pick(obs, step))  # type: ignore[assignment]
        counted += [info["ticks"] for info in infos]
        for b in np.flatnonzero(fields.tasks.episodes != episodes):
            assert infos[b]["ticks"] >= 1800 - before[b]
    ticks = fields.arena.state.games.tick
    games = [[int(e) for e in range(fields.tasks.episodes.max() + 1) if e % 2 == b] for b in range(2)]

    assert fields.tasks.episodes.max() > 2
    assert counted.sum() == sum(1800 for played in games for _ in played) - (1800 - ticks).sum()


def test_an_invalid_answer_stands_for_staying() -> None:
    one, other = make(2), make(2)
    obs, _ = one.reset(), other.reset()
    masked = 1 + obs["action_mask"][:, 1:].argmin(axis=1)
    invalid = np.where(obs["action_mask"][np.arange(2), masked] == 0, masked, STAY)
    assert obs["action_mask"][:, STAY].tolist() == [0, 0]
    after, rewards, *_ = one.step(invalid)
    same, others, *_ = other.step(np.zeros(2, np.int64))
    assert equal(after, same)
    assert rewards.tolist() == others.tolist()


# Several scenarios, snapshots


def test_several_scenarios_share_the_games() -> None:
    """Each plays as it does alone."""
    env, alone = make(5, scenario=["plain", "hills"]), make(2, scenario="plain")
    assert [games.n_games for games in env.fields] == [2, 3]
    assert [games.arena.world.scenario.name for games in env.fields] == ["plain", "hills"]
    both, part = played(env, 25, wild=True), played(alone, 25, wild=True)
    for b in range(2):
        assert [step.reward for step in both[b]] == [step.reward for step in part[b]]
        assert all((x.state == y.state).all() for x, y in zip(both[b], part[b], strict=True))


def test_more_scenarios_than_games_are_refused() -> None:
    with pytest.raises(ConfigError, match="n_envs"):
        make(1, scenario=["plain", "hills"])


def test_a_restored_env_goes_on_the_same() -> None:
    settings: dict[str, Any] = {
        "scenario": ["plain", "hills"],
        "opponent": ["MA1", "nearest"],
        "lower": lower(),
    }
    env, other = make(4, seed=5, **settings), make(4, **settings)
    obs = env.reset()
    for step in range(30):
        obs = cast("Obs", env.step(pick(obs, step))[0])
    file = io.BytesIO()
    np.savez(file, **env.snapshot())  # type: ignore[arg-type]
    file.seek(0)

    restored = other.restore(dict(np.load(file)))

    assert equal(obs, restored)
    for step in range(30, 90):
        obs, rewards, dones, _ = cast("Any", env.step(pick(obs, step)))
        restored, others, other_dones, _ = cast("Any", other.step(pick(restored, step)))
        assert equal(obs, restored)
        assert rewards.tolist() == others.tolist()
        assert dones.tolist() == other_dones.tolist()


def test_the_monitor_keeps_whether_routes_were_finished() -> None:
    env = make_vec_env(ROUTE_ENV, n_envs=2, seed=0)
    obs, records = cast("Obs", env.reset()), []
    for _ in range(80):
        after, _, dones, infos = env.step(heuristic(obs))
        obs = cast("Obs", after)
        records += [infos[b]["episode"]["finished"] for b in np.flatnonzero(dones)]
    assert any(records)
    assert np.stack(env.env_method("action_masks")).shape == (2, 7)


# Who gives the tasks, and who leads the others


class Taskmaster:
    """Policy of the task level: everybody the same row of its set."""

    def __init__(self, row: int) -> None:
        self.row, self.calls = row, 0

    def act(self, obs: Any) -> NDArray[np.int64]:
        self.calls += 1
        return np.full(obs["alive"].shape, self.row)


def test_tasks_are_those_of_the_upper_level() -> None:
    """Row 1 of every set, and nothing else: no wandering, no keeping."""
    upper = Taskmaster(1)
    games = RouteGames(2, route_settings({"upper": upper, "wander": 0.0, "keep_task": 0.0}), "plain", seed=0)
    games.begin(games.all)
    assert upper.calls > 0
    for b in range(2):
        mission = games.arena.missions[b, games.focus.piece[b]]
        slot = int(games.focus.piece[b]) % 7
        row = games.tasks.sight.rows[b, slot, 1]
        assert (mission.kind, mission.target, mission.cell) == (row.kind, row.target, row.cell)


def test_a_new_game_begins_with_the_tasks_of_the_upper_level_too() -> None:
    games = RouteGames(
        2, route_settings({"upper": Taskmaster(1), "wander": 0.0, "keep_task": 0.0}), "plain", seed=0
    )
    games.begin(games.all)
    while games.tasks.episodes.max() < 5:
        games.look()
        games.next_route(
            games.all[games.play(heuristic({"obs": games.state, "action_mask": games.mask})).over]
        )
        for b in np.flatnonzero(games.arena.state.games.tick == 0):
            mission = games.arena.missions[b, games.focus.piece[b]]
            row = games.tasks.sight.rows[b, int(games.focus.piece[b]) % 7, 1]
            assert (mission.kind, mission.target, mission.cell) == (row.kind, row.target, row.cell)


def test_kept_tasks_are_kept_whatever_the_upper_level_says() -> None:
    games = RouteGames(
        2, route_settings({"upper": Taskmaster(1), "wander": 0.0, "keep_task": 1.0}), "plain", seed=0
    )
    games.begin(games.all)
    before = games.arena.missions[["kind", "target", "cell"]].copy()
    games.set_upper(Taskmaster(3))
    games.decide(games.all)
    focal = games.all, games.focus.piece
    assert (games.arena.missions[["kind", "target", "cell"]][focal] == before[focal]).all()


def test_another_upper_level_takes_over_at_the_next_decision() -> None:
    first, second = Taskmaster(1), Taskmaster(3)
    env = make(2, upper=first, keep_task=0.0, wander=0.0)
    obs = env.reset()
    env.set_upper(second)
    calls = first.calls
    for _ in range(30):
        obs = cast("Obs", env.step(heuristic(obs))[0])
    assert first.calls == calls
    assert second.calls > 0
    env.set_upper("random")
    calls = second.calls
    for _ in range(30):
        obs = cast("Obs", env.step(heuristic(obs))[0])
    assert second.calls == calls


@pytest.mark.parametrize("bot", ["MA1", "nearest"])
def test_a_bot_cannot_be_the_upper_level(bot: str) -> None:
    """It gives orders, no tasks."""
    with pytest.raises(
        ConfigError, match=f'upper is "random" or a policy that picks tasks; {bot} gives orders'
    ):
        make(1, upper=bot)
    with pytest.raises(ConfigError, match="gives orders by itself"):
        make(1).set_upper(bot)


def test_the_other_pieces_are_led_by_the_lower_level_of_the_settings() -> None:
    """Another one leads them elsewhere; that of the focal piece is outside."""
    cells = []
    for who in ("heuristic", lower(1)):
        env = make(1, lower=who)
        obs = env.reset()
        for _ in range(15):
            obs = cast("Obs", env.step(heuristic(obs))[0])
        cells.append(env.fields[0].arena.state.pieces.cell[0].tolist())
    assert cells[0] != cells[1]


def test_another_lower_level_takes_over() -> None:
    """Set before the first game it is the same as in the settings."""
    network = lower(1)
    told, made = make(2), make(2, lower=network)
    told.set_lower(network)
    one, other = flat(played(told, 30)), flat(played(made, 30))
    assert [step.reward for step in one] == [step.reward for step in other]
    told.set_lower("heuristic")
    one, other = flat(played(told, 30)), flat(played(made, 30))
    assert [step.reward for step in one] != [step.reward for step in other]


def test_a_callable_cannot_lead_the_other_pieces() -> None:
    with pytest.raises(ConfigError, match="by the heuristic or a network, no callable"):
        make(1, lower=lambda states, _: np.zeros(len(states), np.int64))


def test_a_callable_cannot_take_over_the_other_pieces() -> None:
    with pytest.raises(ConfigError, match="by the heuristic or a network, no callable"):
        make(1).set_lower(lambda states, _: np.zeros(len(states), np.int64))


def test_a_policy_may_be_the_opponent() -> None:
    """It is asked at its decisions, as in the task env."""
    rival = Taskmaster(1)
    env = make(2, side="red", opponent=rival, **LONG_WALKS)
    obs = env.reset()
    start = env.fields[0].arena.state.pieces.cell[:, 7:].copy()
    for _ in range(30):
        obs = cast("Obs", env.step(heuristic(obs))[0])
    assert rival.calls > 1
    assert (env.fields[0].arena.state.pieces.cell[:, 7:] != start).any()


def test_a_callable_may_lead_the_opponents_pieces() -> None:
    """That a piece is led from outside changes nothing for it."""

    class Rival(Taskmaster):
        asked = 0

        def reset(self) -> None: ...

        def lower(self, states: NDArray[np.float32], masks: NDArray[np.int8]) -> NDArray[np.int64]:
            self.asked += len(states)
            return heuristic({"obs": states, "action_mask": masks})

    rival = Rival(1)
    env = make(2, side="red", opponent=rival, **LONG_WALKS)
    obs = env.reset()
    for _ in range(30):
        obs = cast("Obs", env.step(heuristic(obs))[0])
    assert rival.asked > 1


# Settings


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"alpha": -0.1}, r"alpha must be finite and at least 0 by eq\. \(5\), got -0\.1"),
        ({"alpha": float("inf")}, "alpha must be finite"),
        ({"alpha": float("nan")}, "alpha must be finite"),
        ({"beta": 1.0}, r"beta must be in \[0, 1\) by eq\. \(5\), got 1\.0"),
        ({"beta": -0.1}, r"beta must be in \[0, 1\)"),
        ({"beta": float("nan")}, r"beta must be in \[0, 1\)"),
        ({"keep_task": 1.5}, r"keep_task must be in 0\.\.1, got 1\.5"),
        ({"wander": -0.1}, r"wander must be in 0\.\.1, got -0\.1"),
        ({"shaping": 1.01}, r"shaping must be in 0\.\.1, got 1\.01"),
        ({"decision_ticks": 0}, "decision_ticks"),
        ({"decision_ticks": 7.5}, "decision_ticks"),
        ({"scenario": []}, "name at least one scenario"),
        ({"side": "green"}, "unknown side 'green'"),
        ({"reward": "score"}, "unknown reward 'score'"),
        ({"beta_per": "tick"}, "unknown beta_per 'tick'"),
        ({"shapping": 0.9}, "did you mean 'shaping'"),
    ],
)
def test_a_bad_setting_is_named(setting: dict[str, Any], message: str) -> None:
    with pytest.raises(HexWarError, match=message):
        route_settings(setting)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"scenario": "plane"}, "did you mean 'plain'"),
        ({"opponent": "MA"}, "unknown player 'MA'"),
        ({"upper": "nobody"}, "unknown player 'nobody'"),
        ({"lower": "nobody"}, "unknown lower 'nobody'"),
    ],
)
def test_an_unknown_name_is_refused(setting: dict[str, Any], message: str) -> None:
    with pytest.raises(UnknownNameError, match=message):
        make_vec_env(ROUTE_ENV, **setting, seed=0)


def test_an_upper_level_that_sends_nobody_anywhere_is_not_waited_for_without_end() -> None:
    """A net that has just begun to learn says stop to all; with no walks of its own the env would wait for ever."""
    env = RouteVecEnv(2, route_settings({"upper": Taskmaster(0), "wander": 0.0, "keep_task": 0.0}), seed=1)
    obs: Obs = env.reset()
    for _ in range(60):
        obs, *_ = env.step(heuristic(obs))  # type: ignore[assignment]

    assert env.fields[0].tasks.episodes.max() > 1


def test_two_threads_play_the_same_games_as_one() -> None:
    envs = [make(6, scenario=("plain", "hills", "paddy"), opponent="MA1") for _ in range(2)]
    envs[1].beside = executor(2)
    one, two = (env.reset() for env in envs)

    for step in range(30):
        np.testing.assert_equal(two, one)
        answers = pick(one, step)
        told, also_told = (env.step(answers) for env in envs)
        np.testing.assert_equal(also_told[1:], told[1:])
        one, two = cast("Obs", told[0]), cast("Obs", also_told[0])


def test_what_fails_in_either_thread_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    env = make(2, scenario=("plain", "hills"))
    env.beside = executor(2)
    observation = env.reset()
    for games in env.fields:
        with monkeypatch.context() as patched:
            patched.setattr(games, "play", lambda _: 1 / 0)
            with pytest.raises(ZeroDivisionError):
                env.step(pick(observation, 0))
