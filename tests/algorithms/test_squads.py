"""Squad orders: together, for a while, only where they can, and as before after a resume."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.algorithms.checkpoint import load_checkpoint, save_checkpoint
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.algorithms.squads import LAST_START, LENGTHS, SquadOrders, squads_of
from hexwar_sb3.envs.joint_action import JointActionEnv
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import CheckpointError, ConfigError
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.tasks.features import feature_index
from hexwar_sb3.tasks.records import TaskKind
from tests.envs.matrix_games import TwoStepGame

TANK, CHARIOT, SOLDIER, AEROCRAFT = PieceType
LINE_UP = (TANK, TANK, CHARIOT, CHARIOT, SOLDIER, SOLDIER, AEROCRAFT)
HOLD = feature_index("row", 1, 1, 1)["task: kind"].start + TaskKind.HOLD


def task_env(n_envs: int = 4, seed: int = 0) -> Any:
    return make_vec_env("HexWarTask-v0", n_envs=n_envs, seed=seed, opponent="MA1")


def small_model(env: Any, **options: Any) -> QMIX:
    options = {"buffer_size": 2_000, "learning_starts": 50, "batch_size": 16, "seed": 0, **options}
    return QMIX("TaskPolicy", env, **options)


def test_squads_are_the_vehicles_by_type_and_everybody() -> None:
    found = {tuple(np.flatnonzero(squad).tolist()) for squad in squads_of(LINE_UP)}
    assert found == {(0, 1), (2, 3), (0, 1, 2, 3), (0,), (2,), (0, 2), tuple(range(7))}
    assert squads_of((SOLDIER,)).tolist() == [[True]]


def test_an_ordered_squad_holds_one_spot_for_its_time_and_nobody_else_does_anything_else() -> None:
    env = task_env(64)
    obs = env.reset()
    orders, rng = SquadOrders(64, 7), np.random.default_rng(0)
    led_games = 0
    for decision in range(LAST_START + LENGTHS[1]):
        tasks = np.zeros((64, 7), np.int64)
        led = orders.lead(tasks, obs, 1.0, rng)
        active = (orders.first <= decision) & (decision < orders.end)
        assert (led == tasks)[~active].all()
        assert (led == tasks)[~orders.members].all()
        for b in np.flatnonzero(active):
            followers = np.flatnonzero(led[b] != 0)
            rows = obs["tasks"][b, followers, led[b, followers]]
            assert (rows[:, HOLD] == 1).all()
            assert (obs["action_mask"][b, followers, led[b, followers]] == 1).all()
            led_games += followers.size > 0
        obs, _, dones, _ = env.step(led)
        orders.end_games(dones)
        if dones.any():
            break
    assert led_games > 64
    lasts = orders.end - orders.first
    assert (lasts.min(), lasts.max()) == LENGTHS


def test_the_share_is_that_of_the_games() -> None:
    env = task_env(64)
    obs, orders, rng = env.reset(), SquadOrders(64, 7), np.random.default_rng(0)
    ordered = 0
    for _ in range(20):
        orders.end_games(np.ones(64, bool))
        orders.lead(np.zeros((64, 7), np.int64), obs, 0.3, rng)
        ordered += int((orders.end > orders.first).sum())
    assert 0.26 < ordered / 1280 < 0.34


def test_the_share_falls_over_the_games_of_the_training() -> None:
    model = small_model(task_env(), squad_initial_share=0.4, squad_final_share=0.2, squad_episodes=100)
    assert model.squad_share == 0.4
    model._episode_num = 50
    assert model.squad_share == pytest.approx(0.3)
    model._episode_num = 1_000
    assert model.squad_share == pytest.approx(0.2)


def test_without_orders_a_training_draws_as_before() -> None:
    one, other = (small_model(task_env()) for _ in range(2))
    other.squads.lead = None  # type: ignore[assignment,method-assign]  # never asked
    for model in (one, other):
        model.learn(200)
    assert one.rng.bit_generator.state == other.rng.bit_generator.state


def test_a_resumed_training_goes_on_with_its_orders(tmp_path: Path) -> None:
    options = {"squad_initial_share": 1.0, "squad_final_share": 0.5, "squad_episodes": 20}
    whole = small_model(task_env(), **options)
    whole.learn(160)
    save_checkpoint(whole, tmp_path / "checkpoint.npz")
    resumed = load_checkpoint(tmp_path / "checkpoint.npz", task_env(seed=5))
    for model in (whole, resumed):
        model.learn(160, reset_num_timesteps=False)
    for name, array in whole.squads.snapshot().items():
        assert np.array_equal(array, resumed.squads.snapshot()[name])
    for one, other in zip(whole.policy.parameters(), resumed.policy.parameters(), strict=True):
        assert (one == other).all()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("spot", np.full(4, -1)),
        ("end", np.full(4, 2**62)),
        ("first", np.zeros(3, np.int64)),
        ("members", np.zeros((4, 7))),
    ],
)
def test_broken_orders_are_refused(name: str, value: Any) -> None:
    orders = SquadOrders(4, 7)
    with pytest.raises(CheckpointError, match=name):
        orders.restore({**orders.snapshot(), name: value})


def test_orders_are_for_the_task_env() -> None:
    with pytest.raises(ConfigError, match="squad orders are for the task env"):
        QMIX("TaskPolicy", JointActionEnv(TwoStepGame()), squad_initial_share=0.1)
