"""Cooperative games of several kinds as PettingZoo parallel envs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Protocol, TypeAlias, runtime_checkable

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import AECEnv, ParallelEnv
from pettingzoo.utils.conversions import aec_to_parallel_wrapper

from hexwar_sb3.errors import ConfigError

Seen: TypeAlias = dict[str, Any]
Infos: TypeAlias = dict[str, dict[str, Any]]
Step: TypeAlias = tuple[Seen, dict[str, float], dict[str, bool], dict[str, bool], Infos]
KINDS = (
    "a PettingZoo env (parallel, or AEC with is_parallelizable), a Gymnasium env with a Tuple of actions and of"
    " observations, or a game as SMAC has them, with get_avail_actions()"
)


@runtime_checkable
class TeamGame(Protocol):
    """A game as SMAC has them: one team, whose agents' actions, observations and masks are lists."""

    def get_env_info(self) -> Mapping[str, Any]:
        """Sizes: n_agents, n_actions, obs_shape, state_shape."""

    def reset(self) -> object:
        """Start an episode."""

    def step(self, actions: Sequence[int]) -> tuple[float, bool, Mapping[str, Any]]:
        """Let all agents act: reward, whether the episode is over, info; info["episode_limit"]: it is out of time."""

    def get_obs(self) -> Sequence[Any]:
        """What each agent sees."""

    def get_state(self) -> NDArray[Any]:
        """The whole state."""

    def get_avail_actions(self) -> Sequence[Sequence[int]]:
        """1 for each action that each agent may take."""


def as_parallel(env: object) -> ParallelEnv[Any, Any, Any]:
    """A cooperative game as a PettingZoo parallel env.

    Args:
        env: a parallel env; an AEC env whose agents act in turn and whose metadata say `is_parallelizable`; a Gymnasium
            env whose actions and observations are tuples, one for each agent; a game as SMAC has them (`TeamGame`).

    Raises:
        ConfigError: it is none of these.
    """
    if isinstance(env, ParallelEnv):
        return env
    if isinstance(env, AECEnv):
        if not env.metadata.get("is_parallelizable"):
            raise ConfigError(
                "an AEC env must say metadata['is_parallelizable']: its agents act in turn, then time goes on"
            )
        return aec_to_parallel_wrapper(env)
    if isinstance(env, gymnasium.Env) and isinstance(env.action_space, spaces.Tuple):
        return TupleGame(env)
    if isinstance(env, TeamGame):
        return ListGame(env)
    raise ConfigError(f"JointActionEnv takes {KINDS}; got {type(env).__name__}")


class _TeamOfAll(ParallelEnv[str, Any, int]):  # type: ignore[misc]  # PettingZoo ships no types
    """Agents that come and go together, by number."""

    metadata: ClassVar[dict[str, Any]] = {"name": "team_v0", "render_modes": []}

    def __init__(
        self, observations: Sequence[spaces.Space[Any]], actions: Sequence[spaces.Space[Any]]
    ) -> None:
        self.possible_agents = [f"agent{k}" for k in range(len(actions))]
        self.observation_spaces = dict(zip(self.possible_agents, observations, strict=True))
        self.action_spaces = dict(zip(self.possible_agents, actions, strict=True))
        self.agents: list[str] = []

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """What an agent sees."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """What an agent may do."""
        return self.action_spaces[agent]

    def _begun(self, seen: Sequence[Any], masks: object) -> tuple[Seen, Infos]:
        self.agents = list(self.possible_agents)
        return self._named(seen), self._infos(masks)

    def _stepped(self, seen: Sequence[Any], rewards: object, ended: bool, cut: bool, masks: object) -> Step:
        each = np.broadcast_to(np.asarray(rewards, np.float64), len(self.possible_agents)).tolist()
        ends, cuts = (dict.fromkeys(self.possible_agents, flag) for flag in (ended, cut and not ended))
        if ended or cut:
            self.agents = []
        return self._named(seen), self._named(each), ends, cuts, self._infos(masks)

    def _named(self, values: Sequence[Any]) -> dict[str, Any]:
        return dict(zip(self.possible_agents, values, strict=True))

    def _infos(self, masks: Any) -> Infos:
        if masks is None:
            return {name: {} for name in self.possible_agents}
        return {name: {"action_mask": np.asarray(mask)} for name, mask in self._named(masks).items()}


class TupleGame(_TeamOfAll):
    """A Gymnasium env with a Tuple of actions and of observations, such as those of lbforaging and rware.

    A reward or an end may be one for all, or one for each agent; the episode ends with the last agent's. Masks are
    info["action_mask"], one for each agent, where it is there.

    Args:
        env: such an env.

    Raises:
        ConfigError: its observations are no tuple of as many.
    """

    def __init__(self, env: gymnasium.Env[Any, Any]) -> None:
        actions, observations = env.action_space, env.observation_space
        if not isinstance(actions, spaces.Tuple) or not isinstance(observations, spaces.Tuple):
            raise ConfigError(f"a Tuple of actions needs a Tuple of observations, got {observations}")
        if len(actions) != len(observations):
            raise ConfigError(f"{len(actions)} agents act, {len(observations)} see")
        super().__init__(observations.spaces, actions.spaces)
        self.env = env

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Seen, Infos]:
        """Start an episode."""
        seen, info = self.env.reset(seed=seed, options=options)
        return self._begun(seen, info.get("action_mask"))

    def step(self, actions: dict[str, int]) -> Step:
        """Let all agents act."""
        seen, rewards, ended, cut, info = self.env.step([actions[name] for name in self.possible_agents])
        return self._stepped(seen, rewards, bool(np.all(ended)), bool(np.all(cut)), info.get("action_mask"))

    def render(self) -> Any:
        """What the env draws."""
        return self.env.render()

    def close(self) -> None:
        """Close the env."""
        self.env.close()


class ListGame(_TeamOfAll):
    """A game as SMAC has them. An episode that is out of time, by info["episode_limit"], is truncated.

    Args:
        game: such a game; it seeds itself.
    """

    def __init__(self, game: TeamGame) -> None:
        info = game.get_env_info()
        n = int(info["n_agents"])
        seen = spaces.Box(-np.inf, np.inf, (int(np.prod(info["obs_shape"])),))
        super().__init__([seen] * n, [spaces.Discrete(int(info["n_actions"]))] * n)
        self.game = game

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Seen, Infos]:
        """Start an episode."""
        self.game.reset()
        return self._begun(self.game.get_obs(), self.game.get_avail_actions())

    def step(self, actions: dict[str, int]) -> Step:
        """Let all agents act; each gets the team's reward."""
        reward, over, info = self.game.step([actions[name] for name in self.possible_agents])
        cut = bool(over and info.get("episode_limit"))
        seen, masks = self.game.get_obs(), self.game.get_avail_actions()
        return self._stepped(seen, reward, bool(over) and not cut, cut, masks)

    def state(self) -> NDArray[np.float32]:
        """The whole state."""
        return np.asarray(self.game.get_state(), np.float32)

    def close(self) -> None:
        """Close the game, where it can be closed."""
        getattr(self.game, "close", lambda: None)()
