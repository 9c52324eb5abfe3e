"""Any cooperative PettingZoo parallel env as one env with joint actions, which QMIX takes unchanged."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from hexwar_sb3.errors import ConfigError, UnknownNameError

Obs = dict[str, NDArray[Any]]
TEAM_REWARDS = ("mean", "sum")


class JointActionEnv(gymnasium.Env[Obs, NDArray[np.int64]]):
    """One decision for all agents of a team, seen as task sets: a task is an action, its row one-hot.

    Agents may differ in actions and observations; shorter ones are padded, and a one-hot of the agent is
    added to what it sees. Masks are read from an observation of {"observation", "action_mask"} or from
    infos["action_mask"]. An agent that left is dead: only action 0 is valid for it, and ignored.

    Args:
        env: with Discrete actions.
        team_reward: "mean" of the agents' rewards (for envs that give the team's reward to each), or "sum".
        privileged_state: add env.state(), where it has one, for the mixer.

    Raises:
        ConfigError: not a ParallelEnv, or an action space is not Discrete.
    """

    def __init__(
        self, env: ParallelEnv[Any, Any, Any], team_reward: str = "mean", privileged_state: bool = True
    ) -> None:
        if team_reward not in TEAM_REWARDS:
            raise UnknownNameError("team_reward", team_reward, TEAM_REWARDS)
        if not isinstance(env, ParallelEnv):
            raise ConfigError(f"JointActionEnv takes a PettingZoo ParallelEnv, got {type(env).__name__}")
        self.env, self._sum = env, team_reward == "sum"
        self.names = list(env.possible_agents)
        self.actions = {name: _discrete(env.action_space(name)) for name in self.names}
        self._widths = {name: _width(env.observation_space(name)) for name in self.names}
        self._with_state = privileged_state and type(env.unwrapped).state is not ParallelEnv.state
        self._observed: dict[Any, Any] = {}
        n, k = len(self.names), max(int(space.n) for space in self.actions.values())
        self._rows = np.broadcast_to(np.eye(k, dtype=np.float32), (n, k, k))
        self._spaces = self._make_spaces(n, k)
        self.action_space = spaces.MultiDiscrete([k] * n)
        self.observation_space = spaces.Dict(list(self._spaces.items()))  # type: ignore[assignment]  # Gymnasium mixes types

    def _make_spaces(self, n: int, k: int) -> dict[str, spaces.Box[Any]]:
        parts: dict[str, spaces.Box[Any]] = {
            "obs": spaces.Box(-np.inf, np.inf, (n, max(self._widths.values()) + n)),
            "tasks": spaces.Box(0.0, 1.0, (n, k, k)),
            "action_mask": spaces.Box(0, 1, (n, k), np.int8),
            "alive": spaces.Box(0.0, 1.0, (n,)),
        }
        if self._with_state:
            self.env.reset()
            parts["state"] = spaces.Box(-np.inf, np.inf, np.ravel(self.env.state()).shape)
        return parts

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Obs, dict[str, Any]]:
        """Start an episode."""
        super().reset(seed=seed)
        self._observed, infos = self.env.reset(seed=seed, options=options)
        return self._observe(infos, set(self.env.agents)), {}

    def step(self, action: NDArray[np.int64]) -> tuple[Obs, float, bool, bool, dict[str, Any]]:
        """Let every living agent act [N]; the episode ends when all of them have."""
        acting = [(i, name) for i, name in enumerate(self.names) if name in self.env.agents]
        joint = {name: int(self.actions[name].start + action[i]) for i, name in acting}
        observed, rewards, terminated, truncated, infos = self.env.step(joint)
        self._observed |= observed
        reward = sum(map(float, rewards.values())) / (1 if self._sum else len(rewards))
        over = not self.env.agents or all(terminated[name] or truncated[name] for name in joint)
        cut = over and any(truncated[name] and not terminated[name] for name in joint)
        # PettingZoo empties `agents` at a time limit, yet its last observation is valued: nobody died of it.
        living = {name for name in joint if not terminated[name]} if cut else set(self.env.agents)
        return self._observe(infos, living), reward, over and not cut, cut, {}

    def _observe(self, infos: dict[Any, dict[str, Any]], living: set[Any]) -> Obs:
        parts = {key: np.zeros(box.shape, box.dtype) for key, box in self._spaces.items()}
        parts["tasks"] = self._rows
        for i, name in enumerate(self.names):
            alive = name in living
            parts["alive"][i] = alive
            parts["obs"][i] = self._features(i, name)
            parts["action_mask"][i, : self.actions[name].n] = (
                self._mask(name, infos.get(name, {})) if alive else 0
            )
            parts["action_mask"][i, 0] |= not alive
        if self._with_state:
            parts["state"] = np.ravel(self.env.state()).astype(np.float32)
        return parts

    def _features(self, i: int, name: Any) -> NDArray[np.float32]:
        seen = self._observed[name]
        flat = np.ravel(seen["observation"] if isinstance(seen, dict) else seen)
        row = np.zeros(self._spaces["obs"].shape[1], np.float32)
        row[: flat.size], row[i - len(self.names)] = flat, 1.0
        return row

    def _mask(self, name: Any, info: dict[str, Any]) -> NDArray[Any]:
        seen = self._observed[name]
        mask = seen.get("action_mask") if isinstance(seen, dict) else info.get("action_mask")
        return np.ones(self.actions[name].n, np.int8) if mask is None else np.asarray(mask)

    def close(self) -> None:
        """Close the env inside."""
        self.env.close()


def _discrete(space: spaces.Space[Any]) -> spaces.Discrete:
    if not isinstance(space, spaces.Discrete):
        raise ConfigError(f"JointActionEnv needs Discrete actions, got {space}")
    return space


def _width(space: spaces.Space[Any]) -> int:
    """Numbers in an agent's observation, its mask apart."""
    inner = space["observation"] if isinstance(space, spaces.Dict) else space
    return int(np.prod(inner.shape or (1,)))
