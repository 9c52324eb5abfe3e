"""The sizes of a task env, read from its spaces and checked once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium import spaces

from hexwar_sb3.errors import ConfigError

ACTING_KEYS = (
    "obs",
    "tasks",
    "action_mask",
    "alive",
)  # what a policy may see; "state" is for the mixer alone


SIZE_LIMITS = {
    "n_pieces": 1_024,
    "n_tasks": 4_096,
    "obs_dim": 65_536,
    "task_dim": 65_536,
    "state_dim": 1 << 20,
}
MOST_NUMBERS = 1 << 22  # of an observation


@dataclass(frozen=True)
class TaskShapes:
    """Sizes of a task env's observations (architecture.md, section 4)."""

    n_pieces: int  # N
    n_tasks: int  # K
    obs_dim: int  # Do
    task_dim: int  # Dt
    state_dim: int  # Ds; without a `state` key the mixer sees all pieces' obs instead

    @classmethod
    def of(cls, observation_space: spaces.Space[Any], action_space: spaces.Space[Any]) -> TaskShapes:
        """Read the sizes.

        Raises:
            ConfigError: the spaces are not those of a task env.
        """
        if not isinstance(observation_space, spaces.Dict) or not isinstance(
            action_space, spaces.MultiDiscrete
        ):
            raise ConfigError(
                f"a task env has Dict observations and MultiDiscrete actions, got {observation_space} and {action_space};"
                " JointActionEnv makes them of a PettingZoo parallel env"
            )
        missing = [key for key in ACTING_KEYS if key not in observation_space.spaces]
        if missing:
            raise ConfigError(
                f"the observation space lacks {missing}; it has {list(observation_space.spaces)}"
            )
        tasks = observation_space["tasks"].shape or ()
        if len(tasks) != 3:
            raise ConfigError(f"'tasks' must be [piece, task, feature], got the shape {tasks}")
        n_pieces, n_tasks, task_dim = tasks
        if action_space.nvec.tolist() != [n_tasks] * n_pieces:
            raise ConfigError(f"actions must be MultiDiscrete({[n_tasks] * n_pieces}), got {action_space}")
        obs_dim = (observation_space["obs"].shape or (0, 0))[-1]
        state = observation_space.spaces.get("state")
        state_dim = n_pieces * obs_dim if state is None else (state.shape or (0,))[0]
        axes = {"obs": (n_pieces, obs_dim), "action_mask": (n_pieces, n_tasks), "alive": (n_pieces,)}
        for key, expected in {**axes, **({} if state is None else {"state": (state_dim,)})}.items():
            if observation_space[key].shape != expected:
                raise ConfigError(
                    f"the shape of {key!r} must be {expected} beside tasks of {tasks}, got {observation_space[key].shape}"
                )
        shapes = cls(n_pieces, n_tasks, obs_dim, task_dim, state_dim)
        if problem := shapes.why_too_large():
            raise ConfigError(f"a task env has {problem}, got {shapes}")
        return shapes

    def why_too_large(self) -> str | None:
        """Say what it may have at most, if it is larger than any model can be."""
        for name, most in SIZE_LIMITS.items():
            if not 1 <= getattr(self, name) <= most:
                return f"{name} in 1..{most}"
        if self.n_pieces * (self.n_tasks * self.task_dim + self.obs_dim) > MOST_NUMBERS:
            return f"at most {MOST_NUMBERS} numbers in an observation"
        return None

    def acting_alike(self, other: TaskShapes) -> bool:
        """Whether a policy for the one can act in the other, whatever the mixer's state."""
        mine = (self.n_pieces, self.n_tasks, self.obs_dim, self.task_dim)
        return mine == (other.n_pieces, other.n_tasks, other.obs_dim, other.task_dim)

    def observation_space(self) -> spaces.Dict:
        """Make an acting observation space of these sizes (for a model that is loaded without an env)."""
        n, k = self.n_pieces, self.n_tasks
        return spaces.Dict(
            {
                "obs": spaces.Box(-np.inf, np.inf, (n, self.obs_dim)),
                "tasks": spaces.Box(-np.inf, np.inf, (n, k, self.task_dim)),
                "action_mask": spaces.Box(0, 1, (n, k), np.int8),
                "alive": spaces.Box(0.0, 1.0, (n,)),
            }
        )

    def action_space(self) -> spaces.MultiDiscrete:
        """Make the action space: a task of each piece."""
        return spaces.MultiDiscrete([self.n_tasks] * self.n_pieces)
