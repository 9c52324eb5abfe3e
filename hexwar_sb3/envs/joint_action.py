"""Any cooperative game as one env with joint actions, which QMIX takes unchanged."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from hexwar_sb3.checks import check_choice
from hexwar_sb3.envs.cooperative import as_parallel
from hexwar_sb3.errors import ConfigError, shortened
from hexwar_sb3.players.fit import check_actions

Obs = dict[str, NDArray[Any]]
TEAM_REWARDS = ("mean", "sum")
_ARRAYS = (spaces.Box, spaces.Discrete, spaces.MultiBinary, spaces.MultiDiscrete)


class JointActionEnv(gymnasium.Env[Obs, NDArray[np.int64]]):
    """One decision for all agents of a team, seen as task sets: a task is an action, its row one-hot.

    Agents may differ in actions and observations; shorter ones are padded, and a one-hot of the agent is
    added to what it sees. Masks are read from an observation of {"observation", "action_mask"} or from
    infos["action_mask"]. An agent that left, or has not come yet, is dead: only action 0 is valid for it, and
    ignored; what it saw last stays, or is 0. info["rewards"] has each agent's own reward [N], 0 of who is dead.

    Args:
        env: a PettingZoo env, parallel or AEC; a Gymnasium env with a Tuple of actions and of observations; or a game as
            SMAC has them (`as_parallel`). With Discrete actions, and observations that are one array, or a Dict of one and
            its mask.
        team_reward: "mean" of the agents' rewards (for envs that give the team's reward to each), or "sum".
        privileged_state: add env.state(), where it has one, for the mixer.
        last_action: add a one-hot of what an agent did last to what it sees, for agents with a memory.

    Raises:
        ConfigError: none of these, or an agent's actions or observations are of another kind.
    """

    def __init__(
        self,
        env: object,
        team_reward: str = "mean",
        privileged_state: bool = True,
        last_action: bool = False,
    ) -> None:
        check_choice("team_reward", team_reward, TEAM_REWARDS)
        self.env, self._sum = as_parallel(env), team_reward == "sum"
        self.names = list(getattr(self.env, "possible_agents", ()))
        if not self.names:
            raise ConfigError("JointActionEnv needs an env that names its possible_agents beforehand")
        self.actions = {name: _discrete(self.env.action_space(name)) for name in self.names}
        self._widths = {
            name: _width(name, self.env.observation_space(name), int(self.actions[name].n))
            for name in self.names
        }
        self._state_shape = _state_shape(self.env) if privileged_state else None
        self._observed: dict[Any, Any] = {}
        n, k = len(self.names), max(int(space.n) for space in self.actions.values())
        self._rows = np.broadcast_to(np.eye(k, dtype=np.float32), (n, k, k))
        self._last = np.zeros((n, k if last_action else 0), np.float32)  # one-hot of each agent's last action
        self._spaces = self._make_spaces(n, k)
        self.action_space = spaces.MultiDiscrete([k] * n)
        self.observation_space = spaces.Dict(list(self._spaces.items()))  # type: ignore[assignment]  # Gymnasium mixes types

    def _make_spaces(self, n: int, k: int) -> dict[str, spaces.Box[Any]]:
        parts: dict[str, spaces.Box[Any]] = {
            "obs": spaces.Box(-np.inf, np.inf, (n, max(self._widths.values()) + self._last.shape[1] + n)),
            "tasks": spaces.Box(0.0, 1.0, (n, k, k)),
            "action_mask": spaces.Box(0, 1, (n, k), np.int8),
            "alive": spaces.Box(0.0, 1.0, (n,)),
        }
        if self._state_shape is not None:
            parts["state"] = spaces.Box(-np.inf, np.inf, self._state_shape)
        return parts

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Obs, dict[str, Any]]:
        """Start an episode."""
        super().reset(seed=seed)
        observed, infos = self.env.reset(seed=seed, options=options)
        self._observed = dict(observed)
        self._last[:] = 0.0
        return self._observe(infos, set(self.env.agents)), {}

    def step(self, action: NDArray[np.int64]) -> tuple[Obs, float, bool, bool, dict[str, Any]]:
        """Let every living agent act [N]; the episode ends when all of them have.

        Raises:
            ConfigError: they are no whole numbers, an agent has no such action, or no episode is under way.
        """
        picked = check_actions(action, (len(self.names),), axes="")
        joint = self._joint(picked)
        if self._last.size:
            self._last[:] = self._rows[0, picked]
        observed, rewards, terminated, truncated, infos = self.env.step(joint)
        self._observed |= observed
        own = np.array([float(rewards.get(name, 0.0)) for name in self.names], np.float32)
        reward = sum(map(float, rewards.values())) / (1 if self._sum else len(rewards))
        ended = {name for name in joint if terminated[name] or truncated[name]}
        over = set(self.env.agents) <= ended  # others may have come
        cut = over and any(truncated[name] and not terminated[name] for name in joint)
        # PettingZoo empties `agents` at a time limit, yet its last observation is valued: nobody died of it.
        living = {name for name in joint if not terminated[name]} if cut else set(self.env.agents)
        return self._observe(infos, living), reward, over and not cut, cut, {"rewards": own}

    def _joint(self, action: NDArray[np.int64]) -> dict[Any, int]:
        """Actions of the living agents, as the env inside names them."""
        acting = [(i, name) for i, name in enumerate(self.names) if name in getattr(self.env, "agents", ())]
        if not acting:
            raise ConfigError("no episode is under way: reset the env before a step")
        for i, name in acting:
            if not 0 <= action[i] < self.actions[name].n:
                raise ConfigError(
                    f"agent {name!r} has the actions 0..{self.actions[name].n - 1}, got {action[i]}"
                )
        return {name: int(self.actions[name].start + action[i]) for i, name in acting}

    def _observe(self, infos: dict[Any, dict[str, Any]] | None, living: set[Any]) -> Obs:
        parts = {key: np.zeros(box.shape, box.dtype) for key, box in self._spaces.items()}
        parts["tasks"] = self._rows
        for i, name in enumerate(self.names):
            alive = name in living
            parts["alive"][i] = alive
            parts["obs"][i] = self._features(i, name)
            parts["action_mask"][i, : self.actions[name].n] = (
                self._mask(name, (infos or {}).get(name) or {}) if alive else 0
            )
            parts["action_mask"][i, 0] |= not alive
        if self._state_shape is not None:
            parts["state"] = np.ravel(self.env.state()).astype(np.float32)
        return parts

    def _features(self, i: int, name: Any) -> NDArray[np.float32]:
        row = np.zeros(self._spaces["obs"].shape[1], np.float32)
        row[i - len(self.names)] = 1.0
        seen = self._observed.get(name)
        if seen is not None:
            flat = np.ravel(seen["observation"] if isinstance(seen, dict) else seen)
            if flat.size != self._widths[name]:
                raise ConfigError(
                    f"agent {name!r} observes {flat.size} numbers, its space has {self._widths[name]}"
                )
            row[: flat.size] = flat
        row[-len(self.names) - self._last.shape[1] : -len(self.names)] = self._last[i]
        return row

    def _mask(self, name: Any, info: dict[str, Any]) -> NDArray[Any]:
        seen, n = self._observed.get(name), int(self.actions[name].n)
        mask = seen.get("action_mask") if isinstance(seen, dict) else info.get("action_mask")
        if mask is None:
            return np.ones(n, np.int8)
        if np.shape(mask) != (n,):
            raise ConfigError(
                f"the action_mask of agent {name!r} has the shape {np.shape(mask)}, expected {(n,)}"
            )
        return np.asarray(mask)

    def close(self) -> None:
        """Close the env inside."""
        self.env.close()


def _discrete(space: spaces.Space[Any]) -> spaces.Discrete:
    if not isinstance(space, spaces.Discrete):
        raise ConfigError(f"JointActionEnv needs Discrete actions, got {space}")
    return space


def _width(name: Any, space: spaces.Space[Any], n_actions: int) -> int:
    """Numbers in an agent's observation, its mask apart."""
    inner = space.spaces.get("observation") if isinstance(space, spaces.Dict) else space
    if not isinstance(inner, _ARRAYS):
        raise ConfigError(
            f"JointActionEnv needs observations that are one array, or a Dict of 'observation' and 'action_mask';"
            f" agent {name!r} has {shortened(str(space))}"
        )
    mask = space.spaces.get("action_mask") if isinstance(space, spaces.Dict) else None
    if mask is not None and mask.shape != (n_actions,):
        raise ConfigError(
            f"the action_mask of agent {name!r} has the shape {mask.shape}, expected {(n_actions,)}"
        )
    return int(np.prod(inner.shape or (1,)))


def _state_shape(env: ParallelEnv[Any, Any, Any]) -> tuple[int, ...] | None:
    """Shape of env.state() as one row; None where it has none, as many that wrap another kind of env."""
    if type(env.unwrapped).state is ParallelEnv.state:
        return None
    env.reset()
    try:
        state = env.state()
    except (NotImplementedError, AttributeError):
        return None
    flat = np.ravel(state)
    if flat.dtype.kind not in "biuf":
        raise ConfigError(
            f"env.state() is no array of numbers but {type(state).__name__}: take privileged_state=False"
        )
    return flat.shape
