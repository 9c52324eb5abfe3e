"""A tiny task env with masks, deaths, uneven decisions and a snapshot."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor

from hexwar_sb3.algorithms.qmix import QMIX

PIECES, TASKS, OBS, TASK, STATE = 3, 4, 5, 2, 6
LENGTH = 6  # decisions of a game

Obs = dict[str, NDArray[Any]]


class ToyEnv(gymnasium.Env[Obs, NDArray[np.int64]]):
    """Each valid task has a random worth; piece 2 dies half-way; a masked task fails the test."""

    def __init__(self, with_state: bool, seed: int) -> None:
        shapes = {"obs": (PIECES, OBS), "tasks": (PIECES, TASKS, TASK), "alive": (PIECES,)}
        parts: dict[str, spaces.Space[Any]] = {
            key: spaces.Box(-1.0, 1.0, shape) for key, shape in shapes.items()
        }
        parts["action_mask"] = spaces.Box(0, 1, (PIECES, TASKS), np.int8)
        if with_state:
            parts["state"] = spaces.Box(-1.0, 1.0, (STATE,))
        self.observation_space = spaces.Dict(parts)  # type: ignore[assignment]
        self.action_space = spaces.MultiDiscrete([TASKS] * PIECES)
        self.with_state, self.random, self.moment = with_state, np.random.default_rng(seed), 0
        self.seen: Obs = {}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Obs, dict[str, Any]]:
        super().reset(seed=seed)
        if seed is not None:
            self.random = np.random.default_rng(seed)
        self.moment = 0
        return self.observe(), {}

    def step(self, action: NDArray[np.int64]) -> tuple[Obs, float, bool, bool, dict[str, Any]]:
        assert np.take_along_axis(self.seen["action_mask"], action[:, None], axis=1).all()
        worth = np.take_along_axis(self.seen["tasks"][..., 0], action[:, None], axis=1)
        self.moment += 1
        ticks = 75 if self.moment % 2 else 150
        info = {"ticks": ticks, "rewards": worth[:, 0]}
        return self.observe(), float(worth.sum()), self.moment == LENGTH, False, info

    def observe(self) -> Obs:
        alive = np.array([1, 1, self.moment < LENGTH // 2], np.float32)
        mask = (self.random.random((PIECES, TASKS)) < 0.5) & (alive[:, None] > 0)
        mask[:, 0] = True
        tasks = self.random.random((PIECES, TASKS, TASK), np.float32) * mask[..., None]
        obs = self.random.random((PIECES, OBS), np.float32)
        self.seen = {"obs": obs, "tasks": tasks, "action_mask": mask.astype(np.int8), "alive": alive}
        if self.with_state:
            self.seen["state"] = self.random.random(STATE, np.float32)
        return dict(self.seen)


class ToyVecEnv(DummyVecEnv):
    """Games with `snapshot` and `restore`, as our native VecEnvs have them."""

    envs: list[ToyEnv]  # type: ignore[assignment]

    def snapshot(self) -> dict[str, NDArray[Any]]:
        """Everything that changes in play."""
        states = [env.random.bit_generator.state["state"] for env in self.envs]
        words = [
            [part >> 64 * k & (1 << 64) - 1 for part in state.values() for k in (0, 1)] for state in states
        ]
        seen = {f"seen_{key}": np.stack([env.seen[key] for env in self.envs]) for key in self.envs[0].seen}
        return {
            "moment": np.array([env.moment for env in self.envs]),
            "random": np.array(words, np.uint64),
            **seen,
        }

    def restore(self, parts: dict[str, NDArray[Any]]) -> None:
        """Go on from a snapshot."""
        for b, env in enumerate(self.envs):
            low, high, low_step, high_step = (int(word) for word in parts["random"][b])
            state = env.random.bit_generator.state
            env.random.bit_generator.state = {
                **state,
                "state": {"state": low | high << 64, "inc": low_step | high_step << 64},
            }
            env.moment = int(parts["moment"][b])
            env.seen = {key: parts[f"seen_{key}"][b] for key in env.seen or env.observation_space.spaces}  # type: ignore[attr-defined]


def toy_games(n_envs: int = 4, with_state: bool = True) -> VecMonitor:
    return VecMonitor(ToyVecEnv([partial(ToyEnv, with_state, seed) for seed in range(n_envs)]))


def toy_model(**options: Any) -> QMIX:
    small: dict[str, Any] = {
        "buffer_size": 400,
        "learning_starts": 20,
        "batch_size": 16,
        "seed": 0,
        "device": "cpu",
    }
    return QMIX("TaskPolicy", options.pop("env", None) or toy_games(), **{**small, **options})


@pytest.fixture
def make_env() -> Callable[..., VecMonitor]:
    """Maker of toy games: (n_envs, with_state)."""
    return toy_games


@pytest.fixture
def make_model() -> Callable[..., QMIX]:
    """Maker of a small model of toy games: (env, and any argument of QMIX)."""
    return toy_model
