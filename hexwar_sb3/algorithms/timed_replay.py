"""A replay of SB3 whose transitions last, and are discounted by, their own length of time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.buffers import DictReplayBuffer
from stable_baselines3.common.type_aliases import DictReplayBufferSamples, TensorDict
from stable_baselines3.common.vec_env import VecNormalize

from hexwar_sb3.algorithms.checkpoint_arrays import FLAGS, MOST_REWARD, check_box, check_flags
from hexwar_sb3.algorithms.td_targets import n_step_return
from hexwar_sb3.engine.fields import check_form, check_names, check_range, refuse
from hexwar_sb3.errors import ConfigError, TrainingError


class TimedReplayBuffer(DictReplayBuffer):
    """SB3's replay of Dict observations, with a discount of each transition: gamma^steps.

    `steps` is info["steps"]: how long the transition took, in the units of time that gamma discounts (1 if
    missing). SB3's DQN and QR-DQN take the discounts of a batch that has them.

    Args:
        buffer_size: transitions of all envs together.
        observation_space: a Dict of Boxes.
        action_space: of the env.
        device: of the batches.
        n_envs: envs at a time.
        gamma: discount of one unit of time.
        n_steps: rows of a transition, fewer at an episode's end and at the newest row.
    """

    def __init__(
        self,
        buffer_size: int,
        observation_space: spaces.Dict,
        action_space: spaces.Space[Any],
        device: torch.device | str = "auto",
        n_envs: int = 1,
        gamma: float = 0.99,
        n_steps: int = 1,
    ) -> None:
        super().__init__(buffer_size, observation_space, action_space, device, n_envs)
        self.gamma, self.n_steps = gamma, n_steps
        self.steps = np.ones((self.buffer_size, n_envs), np.float32)

    def add(  # type: ignore[override]  # as in SB3's
        self,
        obs: dict[str, NDArray[Any]],
        next_obs: dict[str, NDArray[Any]],
        action: NDArray[Any],
        reward: NDArray[Any],
        done: NDArray[Any],
        infos: list[dict[str, Any]],
    ) -> None:
        """Store one transition of every env.

        Raises:
            TrainingError: an info["steps"] is no length of time.
        """
        steps = np.array([info.get("steps", 1.0) for info in infos], np.float32)
        if not (np.isfinite(steps) & (steps >= 0.0)).all():
            raise TrainingError(f"info['steps'] must be finite and at least 0, got {steps.tolist()}")
        self.steps[self.pos] = steps
        super().add(obs, next_obs, action, reward, done, infos)

    def _get_samples(  # type: ignore[override]  # as in SB3's
        self, batch_inds: NDArray[np.int64], env: VecNormalize | None = None
    ) -> DictReplayBufferSamples:
        """Gather transitions of random envs over up to `n_steps` rows; an episode that was cut short is not done."""
        which = np.random.randint(0, self.n_envs, len(batch_inds))  # noqa: NPY002  # SB3's generator
        rows, inside = self._walk(batch_inds, which)
        at = batch_inds, which
        last = rows[np.arange(len(rows)), inside.sum(axis=1) - 1], which
        rewards, discounts = n_step_return(
            self.to_torch(self._normalize_reward(self.rewards[rows, which[:, None]], env)).unsqueeze(2),
            self.to_torch(self.gamma ** self.steps[rows, which[:, None]]),
            torch.as_tensor(inside, device=self.device),
        )
        return DictReplayBufferSamples(
            observations=self._tensors(self.observations, at, env),
            actions=self.to_torch(self.actions[at]),
            next_observations=self._tensors(self.next_observations, last, env),
            dones=self.to_torch((self.dones[last] * (1.0 - self.timeouts[last]))[:, None]),
            rewards=rewards,
            discounts=discounts,
        )

    def _walk(
        self, start: NDArray[np.int64], which: NDArray[np.int64]
    ) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Rows from `start` on [B, n], and whether each is still the same episode's and not older than the first."""
        rows = (start[:, None] + np.arange(self.n_steps)) % self.buffer_size
        goes_on = (self.dones[rows, which[:, None]][:, :-1] == 0) & (rows[:, 1:] != self.pos)
        inside = np.concatenate([np.ones((len(start), 1), np.bool_), goes_on], axis=1)
        return rows, np.logical_and.accumulate(inside, axis=1)

    def _tensors(
        self,
        stored: Mapping[str, NDArray[Any]],
        at: tuple[NDArray[np.int64], NDArray[np.int64]],
        env: VecNormalize | None,
    ) -> TensorDict:
        rows = {key: values[at] for key, values in stored.items()}
        return {key: self.to_torch(values) for key, values in self._normalize_obs(rows, env).items()}  # type: ignore[union-attr]

    def cut_short(self) -> None:
        """End the running episodes where they are: their last observation is valued."""
        if self.size():
            self.dones[self.pos - 1] = self.timeouts[self.pos - 1] = 1.0

    def snapshot(self) -> dict[str, NDArray[Any]]:
        """Everything that is stored, by name, without rows that were never written; views, not copies."""
        rows = self.size()
        return {**{name: array[:rows] for name, array in self._arrays().items()}, "pos": np.array(self.pos)}

    def restore(self, parts: Mapping[str, NDArray[Any]]) -> None:
        """Take over what `snapshot` gave.

        Raises:
            ConfigError: it is of another number of envs, or larger than this replay.
            CheckpointError: it is broken; the replay is as it was.
        """
        rows = self._check(parts)
        for name, array in self._arrays().items():
            array[:rows] = parts[name]
        self.full = rows == self.buffer_size
        self.pos = int(parts["pos"]) % rows if self.full else rows

    def _check(self, parts: Mapping[str, NDArray[Any]]) -> int:
        """Check what another replay gave; its number of rows."""
        own = self._arrays()
        check_names(parts, [*own, "pos"])
        rows, n_envs = (
            shape if len(shape := np.shape(parts["rewards"])) == 2 else refuse("rewards", shape, "two axes")
        )
        if n_envs != self.n_envs or rows > self.buffer_size:
            found, room = f"{rows} transitions of {n_envs} envs", f"{self.buffer_size} of {self.n_envs}"
            raise ConfigError(f"the stored replay holds {found}, this one has room for {room}")
        for name, array in own.items():
            check_form(name, parts[name], array.dtype, (rows, n_envs, *array.shape[2:]))
        for key, box in self.observation_space.items():
            for name in (f"obs_{key}", f"next_obs_{key}"):
                check_box(name, parts[name], box)
                if key in FLAGS:
                    check_flags(name, parts[name])
        check_range("rewards", parts["rewards"], -MOST_REWARD, MOST_REWARD)
        check_range("steps", parts["steps"], 0.0, MOST_REWARD)
        for name in ("dones", "timeouts"):
            check_flags(name, parts[name])
        if isinstance(self.action_space, spaces.Discrete):
            first = int(self.action_space.start)
            check_range("actions", parts["actions"], first, first + int(self.action_space.n) - 1)
        else:
            check_box("actions", parts["actions"], self.action_space)
        check_form("pos", parts["pos"], np.int64, ())
        check_range("pos", parts["pos"], 0, rows)
        return rows

    def _arrays(self) -> dict[str, NDArray[Any]]:
        names = ("actions", "rewards", "dones", "timeouts", "steps")
        return {
            **{f"obs_{key}": array for key, array in self.observations.items()},
            **{f"next_obs_{key}": array for key, array in self.next_observations.items()},
            **{name: getattr(self, name) for name in names},
        }
