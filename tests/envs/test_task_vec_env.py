"""The native VecEnv: determinism, infos, masks, resume."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecMonitor

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.envs.task_vec_env import TaskVecEnv
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps.spec import STANDARD

Pick = Callable[[NDArray[Any], int], NDArray[np.int64]]
Outcome = tuple[str, str, float, float, int]  # side, opponent, margin, return, points held

TICKS = 150  # Delta-t of these tests: half the work
MIXTURE = ["nearest", "random"]


def vec_env(n_envs: int, **settings: Any) -> VecMonitor:
    return make_vec_env("HexWarTask-v0", n_envs=n_envs, decision_ticks=TICKS, **{"seed": 0, **settings})


def native(env: VecMonitor) -> TaskVecEnv:
    return cast("TaskVecEnv", env.unwrapped)


def outcomes(env: VecMonitor, pick: Pick, episodes: int) -> list[Outcome]:
    """Outcomes in the order of the episodes; they end in lockstep, so slots keep that order."""
    obs, step = cast("dict[str, NDArray[Any]]", env.reset()), 0
    found: list[Outcome] = []
    length = load_world("plain").scenario.game_ticks // TICKS
    while len(found) < episodes:
        obs, _, dones, infos = env.step(pick(obs["action_mask"], step % length))  # type: ignore[assignment]
        step += 1
        for info in (info for info, done in zip(infos, dones, strict=True) if done):
            found.append(
                (
                    info["side"],
                    info["opponent"],
                    info["margin"],
                    float(info["episode"]["r"]),
                    info["points_held"],
                )
            )
    return found[:episodes]


def test_episodes_do_not_depend_on_the_number_of_games(pick: Pick) -> None:
    """Episode k is the same game alone and in a batch, sides and opponents included."""
    settings: dict[str, Any] = {"side": "both", "opponent": MIXTURE, "seed": 4}
    assert outcomes(vec_env(1, **settings), pick, 4) == outcomes(vec_env(4, **settings), pick, 4)


def test_the_seed_decides(pick: Pick) -> None:
    one, other = vec_env(2, opponent="MA1", seed=1), vec_env(2, opponent="MA1", seed=2)
    assert outcomes(one, pick, 4) != outcomes(other, pick, 4)
    other.seed(1)
    one.seed(1)
    assert outcomes(one, pick, 4) == outcomes(other, pick, 4)


def test_rewards_add_up_to_the_gain_of_the_margin(pick: Pick) -> None:
    """Eq. (3): the sum of the gains is the final margin minus the first one."""
    env = vec_env(2, opponent="random", reward="paper")
    env.reset()
    first = native(env).games.scores()[0]
    for _, _, margin, total, _ in outcomes(env, pick, 2):
        assert total == pytest.approx(margin - first)


def test_net_rewards_add_up_to_own_minus_enemy(pick: Pick) -> None:
    """Both camps start even; the margin that infos tell is eq. (1), in which green points count against both."""
    points = (0, 50, 80, 130)  # that may be green at the end
    for _, _, margin, total, _ in outcomes(vec_env(2, opponent="random", reward="net"), pick, 2):
        assert total in [margin + green for green in points]


def test_the_end_is_the_last_tick_and_keeps_its_observation(pick: Pick) -> None:
    env = vec_env(2, opponent="random")  # somebody is left to observe the end
    obs, ticks, dones = cast("dict[str, NDArray[Any]]", env.reset()), 0, np.zeros(2, np.bool_)
    while not dones.any():
        last = {key: value.copy() for key, value in obs.items()}
        obs, _, dones, infos = env.step(pick(obs["action_mask"], ticks))  # type: ignore[assignment]
        ticks += infos[0]["ticks"]

    assert ticks == load_world("plain").scenario.game_ticks
    assert infos[0]["TimeLimit.truncated"] is False
    terminal = infos[0]["terminal_observation"]
    assert terminal.keys() == obs.keys()
    assert not np.array_equal(terminal["obs"], obs["obs"][0])  # a new game has begun
    assert not np.array_equal(terminal["obs"], last["obs"][0])


def test_the_last_observation_outlives_one_step(pick: Pick) -> None:
    """SB3 stores the previous observation after the step."""
    env = vec_env(2)
    before = cast("dict[str, NDArray[Any]]", env.reset())
    copies = {key: value.copy() for key, value in before.items()}
    env.step(pick(before["action_mask"], 0))
    assert all(np.array_equal(before[key], copies[key]) for key in copies)


def test_masks_of_sb3_contrib_are_flat_and_come_through_the_monitor() -> None:
    env = vec_env(3)
    obs = cast("dict[str, NDArray[Any]]", env.reset())
    assert env.has_attr("action_masks")
    masks = np.stack(env.env_method("action_masks"))
    assert np.array_equal(masks, obs["action_mask"].reshape(3, -1) == 1)
    assert len(env.env_method("action_masks", indices=[1])) == 1


def test_stop_is_always_valid_and_alone_for_passengers() -> None:
    obs = cast("dict[str, NDArray[Any]]", vec_env(1).reset())
    mask, names = obs["action_mask"][0], load_world("plain").piece_names(0)
    assert (mask[:, 0] == 1).all()
    assert mask[names.index("soldier0")].sum() == 1


def test_illegal_actions_are_counted_never_raised() -> None:
    env = vec_env(1)
    mask = cast("dict[str, NDArray[Any]]", env.reset())["action_mask"]
    masked = np.argmin(mask, axis=-1)  # some masked row of every piece
    _, _, _, infos = env.step(masked)
    assert infos[0]["illegal_actions"] == mask.shape[1]


def test_state_is_there_only_on_request() -> None:
    assert "state" not in vec_env(1).observation_space.spaces  # type: ignore[attr-defined]
    obs = cast("dict[str, NDArray[Any]]", vec_env(1, privileged_state=True).reset())
    assert np.abs(obs["state"]).sum() > 0


def test_half_precision_is_the_same_observation() -> None:
    full = cast("dict[str, NDArray[Any]]", vec_env(1).reset())
    half = cast("dict[str, NDArray[Any]]", vec_env(1, dtype="float16").reset())
    assert half["obs"].dtype == np.float16
    assert np.allclose(full["obs"], half["obs"], atol=1e-2)


@pytest.mark.parametrize("scenario", STANDARD)
def test_every_observation_lies_in_its_space(pick: Pick, scenario: str) -> None:
    env = vec_env(1, decisions="event", privileged_state=True, scenario=scenario)
    obs, done, step = cast("dict[str, NDArray[Any]]", env.reset()), False, 0
    while not done:
        assert env.observation_space.contains({key: value[0] for key, value in obs.items()})
        obs, _, dones, _ = env.step(pick(obs["action_mask"], step))  # type: ignore[assignment]
        done, step = bool(dones[0]), step + 1


def test_a_restored_env_goes_on_as_before(pick: Pick) -> None:
    settings: dict[str, Any] = {"side": "both", "opponent": MIXTURE, "seed": 2}
    env, other = vec_env(2, **settings), vec_env(2, **settings)
    obs = cast("dict[str, NDArray[Any]]", env.reset())
    for step in range(5):
        obs, *_ = env.step(pick(obs["action_mask"], step))  # type: ignore[assignment]
    snapshot = native(env).snapshot()

    restored = native(other).restore(snapshot)

    assert all(np.array_equal(obs[key], restored[key]) for key in obs)
    for step in range(5, 20):
        obs, rewards, *_ = env.step(pick(obs["action_mask"], step))  # type: ignore[assignment]
        restored, others, *_ = other.step(pick(restored["action_mask"], step))  # type: ignore[assignment]
        assert np.array_equal(rewards, others)
        assert all(np.array_equal(obs[key], restored[key]) for key in obs)


def test_a_demo_bot_plays_the_learners_seat_and_its_tasks_are_told() -> None:
    """The tasks it names are valid, and the learner's own actions change nothing."""
    one = vec_env(1, demo="nearest", demo_share=1.0, opponent="random")
    other = vec_env(1, demo="nearest", demo_share=1.0, opponent="random")
    obs, _ = cast("dict[str, NDArray[Any]]", one.reset()), other.reset()
    zeros, moved = np.zeros(obs["action_mask"].shape[:2], np.int64), False
    for _ in range(4):
        mask = obs["action_mask"].copy()
        obs, reward, _, infos = one.step(zeros)  # type: ignore[assignment]
        _, other_reward, _, _ = other.step(zeros + 1)
        told = infos[0]["demo_actions"]
        assert np.take_along_axis(mask[0], told[:, None], -1).all()
        moved = moved or told.any()
        assert reward == other_reward
    assert moved


@pytest.mark.parametrize("part", ["rules", "scenario", "bots"])
def test_games_that_were_saved_elsewhere_are_refused(part: str) -> None:
    env = native(vec_env(1))
    snapshot = env.snapshot()
    snapshot["origin"] = np.array(
        [f"{part} 0123" if name.startswith(part) else name for name in snapshot["origin"].tolist()]
    )
    with pytest.raises(ConfigError, match=f"saved with {part} 0123, this env has {part} "):
        env.restore(snapshot)
