"""`HexWarTask-v0` for many games at once: a native VecEnv of Stable-Baselines3."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.vec_env.base_vec_env import VecEnvStepReturn

from hexwar_sb3.checks import check_share
from hexwar_sb3.envs.native_vec_env import NativeVecEnv
from hexwar_sb3.envs.settings import TaskSettings
from hexwar_sb3.envs.task_games import Obs, TaskGames, action_space, observation_space
from hexwar_sb3.play.arena import Arena, Snapshot
from hexwar_sb3.players.frozen_lower import Lower


class TaskVecEnv(NativeVecEnv):
    """All games are stepped in one call; ended ones start anew.

    The arrays of an observation are reused by the step after the next: copy what must stay.
    The reward is the referee's margin, so it tells of hits on enemies that the camp does not see; the observations
    tell nothing of them.

    Args:
        n_envs: games.
        settings: the env's settings.
        seed: of the episodes; None draws one.
    """

    def __init__(self, n_envs: int, settings: TaskSettings, seed: int | None = None) -> None:
        self.games = TaskGames(n_envs, settings, seed)
        sight = self.games.sight
        super().__init__(n_envs, observation_space(sight), action_space(sight))

    def reset(self) -> Obs:
        """Start the next episode in every slot."""
        self.games.begin(self.games.all)
        return self.games.look(self.games.all)

    def step_wait(self) -> VecEnvStepReturn:
        """Play one decision of every game."""
        span = self.games.play(self._actions)
        self.games.turn()
        obs = self.games.look(self.games.all)
        infos = span.infos()
        for info, current in zip(infos, self.games.current_tasks(obs), strict=True):
            info["current_tasks"] = current
        for b, actions in span.demo.items():
            infos[b]["demo_actions"] = actions
        ended = self.games.all[span.over]
        for b in ended.tolist():
            infos[b] |= self.games.outcome(b)
            infos[b]["terminal_observation"] = {key: value[b].copy() for key, value in obs.items()}
            infos[b]["TimeLimit.truncated"] = False
        if ended.size:
            self.games.begin(ended)
            self.games.look(ended)
        return obs, span.reward, span.over, infos

    def action_masks(self) -> NDArray[np.bool_]:
        """Valid tasks of every game, pieces one after the other [n, N * K] (sb3-contrib)."""
        return self.games.sight.obs["action_mask"].reshape(self.num_envs, -1).astype(np.bool_)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Count episodes from 0 again under this seed, or a drawn one; takes effect at the next reset."""
        self.games.seed(seed)
        return [self.games.first_seed] * self.num_envs

    def seed_slots(self, seeds: Sequence[int]) -> None:
        """Give every slot the episodes of a seed of its own, from 0 on; takes effect at the next reset."""
        self.games.seed_slots(seeds)

    def positions(self) -> Iterator[tuple[Arena, int, int]]:
        """Where each game is to be found, and whose eyes see it: arena, number in it, camp of the learner."""
        yield from self.games.positions()

    def set_demo_share(self, share: float) -> None:
        """Share of the episodes, from the next ones on, in which somebody shows the learner how to play."""
        self.games.demo_share = check_share("demo_share", share)

    def set_warm_start(self, share: float) -> None:
        """Share of the episodes, from the next ones on, that begin near the hot spots."""
        self.games.warm_start = check_share("warm_start", share)

    @property
    def lower_level(self) -> Lower:
        """Who leads the learner's pieces."""
        return self.games.lower

    def set_lower(self, lower: object) -> None:
        """Another lower level for the learner's pieces: "heuristic", a folder, a network, or a callable."""
        self.games.set_lower(lower)

    def set_opponent(self, opponent: object) -> None:
        """Opponents of the next episodes: a player, a list of them, or a list of (player, weight)."""
        self.games.set_opponent(opponent)

    def snapshot(self) -> Snapshot:
        """Everything that changes in play, as arrays that `np.savez` takes."""
        return self.games.snapshot()

    def restore(self, snapshot: Snapshot) -> Obs:
        """Go on where `snapshot` was taken, in an env of the same settings; the observation there."""
        return self.games.restore(snapshot)
