"""`HexWarFlat-v0` for many games at once: a native VecEnv of Stable-Baselines3."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.vec_env.base_vec_env import VecEnvStepReturn

from hexwar_sb3.checks import check_share
from hexwar_sb3.envs.flat_games import FlatGames, flat_spaces
from hexwar_sb3.envs.native_vec_env import NativeVecEnv
from hexwar_sb3.envs.settings import TaskSettings
from hexwar_sb3.play.arena import Arena, Snapshot


class FlatVecEnv(NativeVecEnv):
    """All games are stepped in one call, each by one piece's turn; ended ones start anew. See `FlatEnv`.

    Args:
        n_envs: games.
        settings: the env's settings, from `flat_settings`.
        seed: of the episodes; None draws one.
    """

    def __init__(self, n_envs: int, settings: TaskSettings, seed: int | None = None) -> None:
        self.games = FlatGames(n_envs, settings, seed)
        super().__init__(n_envs, *flat_spaces(self.games))

    def reset(self) -> NDArray[Any]:
        """Start the next episode in every slot."""
        self.games.begin(self.games.all)
        return self.games.observe()

    def step_wait(self) -> VecEnvStepReturn:
        """Play one turn of every game."""
        span = self.games.play(self._actions)
        obs = self.games.observe()
        infos = span.infos()
        for b, action in span.demo.items():
            infos[b]["demo_actions"] = int(action)
        ended = self.games.all[span.over]
        for b in ended.tolist():
            infos[b] |= self.games.outcome(b)
            infos[b]["terminal_observation"] = obs[b].copy()
            infos[b]["TimeLimit.truncated"] = False
        if ended.size:
            self.games.begin(ended)
            obs = self.games.observe()
        return obs, span.reward, span.over, infos

    def action_masks(self) -> NDArray[np.bool_]:
        """Legal actions of every game's acting piece [n, K * 7] (sb3-contrib)."""
        return self.games.masks()

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

    def snapshot(self) -> Snapshot:
        """Everything that changes in play, as arrays that `np.savez` takes."""
        return self.games.snapshot()

    def restore(self, snapshot: Snapshot) -> NDArray[Any]:
        """Go on where `snapshot` was taken, in an env of the same settings; the observation there."""
        self.games.restore(snapshot)
        return self.games.observe()
