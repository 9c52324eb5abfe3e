"""Self-play for one learner: its env draws opponents from a pool of its own past."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecEnv

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.every import EverySteps
from hexwar_sb3.checks import check_share, check_whole
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.player import ModelPlayer, Player, with_weight


class SelfPlayCallback(EverySteps):
    """Adds a frozen copy of the learner to the pool every so many env steps.

    For any model whose env has `set_opponent`, the task env or a wrapper of it: QMIX, HierarchicalQMIX,
    sb3-contrib's MaskablePPO. Opponents of games that run stay as they are. The env's `priority` lets it meet
    those copies more often that beat it, and the others likewise (`Encounters`).

    Args:
        every: env steps between two copies.
        pool_size: copies that are played against: the first one, so that the start is not forgotten, and the latest.
        others: further opponents, as the env takes them: players, or (player, weight).
        share: of the weights, for the copies; without others they have all of it.
        folder: keeps the pool of a QMIX, so that a resumed training goes on with it; None keeps none.

    Example:
        >>> from pathlib import Path
        >>> from hexwar_sb3.algorithms import load_checkpoint, save_checkpoint
        >>> env = make_vec_env(side="both", seed=0)
        >>> pool = SelfPlayCallback(every=24, others=["MA1", "MA2"], share=0.5, folder=Path("pool"))
        >>> model = QMIX("TaskPolicy", env, seed=0).learn(48, callback=pool)
        >>> save_checkpoint(model, "checkpoint.npz")

        From a checkpoint, with the games that were running:

        >>> pool = SelfPlayCallback(every=24, others=["MA1", "MA2"], share=0.5, folder=Path("pool"))
        >>> pool.seat(env)
        >>> model = load_checkpoint("checkpoint.npz", env)
        >>> _ = model.learn(48, callback=pool, reset_num_timesteps=False)
    """

    def __init__(
        self,
        every: int,
        *,
        pool_size: int = 10,
        others: Sequence[object] = (),
        share: float = 0.5,
        folder: Path | None = None,
    ) -> None:
        super().__init__(every)
        self.pool_size = check_whole("pool_size", pool_size, least=1)
        self.others = [with_weight(one) for one in others]
        self.share = check_share("share", share) if others else 1.0
        if others and not 0.0 < sum(weight for _, weight in self.others) < float("inf"):
            raise ConfigError(f"the weights of others need a positive sum, got {self.others}")
        self.folder = folder
        self.pool: list[Player] = []

    def _on_training_start(self) -> None:
        super()._on_training_start()
        if self.folder is not None and not self.pool:
            if self._kept() and not self.now():
                raise ConfigError(f"{self.folder} holds the pool of another training; choose an empty folder")
            self.pool = [FrozenPolicy.load(path) for path in self._kept() if int(path.name) <= self.now()]
        if self.pool:
            self.meet()
        else:
            self.fire()

    def seat(self, env: VecEnv) -> None:
        """Give an env the opponents that lie in the folder, so that `load_checkpoint` finds those of its games.

        Raises:
            ConfigError: there are none.
        """
        pool = [] if self.folder is None else [FrozenPolicy.load(path) for path in self._kept()]
        if not pool:
            raise ConfigError(f"there is no pool in {self.folder}")
        env.env_method("set_opponent", self._weighed(pool))

    def _kept(self) -> list[Path]:
        """Folders of the copies, the oldest first."""
        return sorted(path for path in cast("Path", self.folder).glob("*") if path.name.isdecimal())

    def fire(self) -> None:
        """Add the learner as it is now, and let the next games be against the new pool."""
        copy = frozen_copy(self.model)
        self.pool.append(copy)
        if self.folder is not None:
            if not isinstance(copy, FrozenPolicy):
                raise ConfigError("folder keeps copies of QMIX and HierarchicalQMIX only; leave it out")
            copy.save(self.folder / f"{self.now():012d}")
        self.meet()
        self.logger.record("self_play/pool", len(self.pool))

    def meet(self) -> None:
        """Give the env the pool as it is now."""
        cast("VecEnv", self.model.get_env()).env_method("set_opponent", self.opponents())

    def opponents(self) -> list[tuple[Any, float]]:
        """The others and all copies with their weights; a copy that left the pool keeps its place, with weight 0."""
        return self._weighed(self.pool)

    def _weighed(self, pool: Sequence[Player]) -> list[tuple[Any, float]]:
        total = sum(weight for _, weight in self.others)
        others = [(player, (1 - self.share) * weight / total) for player, weight in self.others]
        latest = range(len(pool))[-self.pool_size :]
        playing = {0, *latest[1:]} if len(latest) > 1 else set(latest)
        weight = self.share / len(playing)
        return [*others, *((copy, weight if k in playing else 0.0) for k, copy in enumerate(pool))]


def frozen_copy(model: BaseAlgorithm) -> Player:
    """A player that stays as the model is now, whatever the model learns.

    Raises:
        ConfigError: it learns from normalised observations, and a player gets them as they are.
    """
    if isinstance(model, QMIX):
        return model.policy.freeze()
    normaliser = model.get_vec_normalize_env()
    if normaliser is not None and normaliser.norm_obs:
        raise ConfigError(
            "a copy of a model plays on observations as they are: leave VecNormalize's norm_obs out"
        )
    policy = type(model.policy)(**model.policy._get_constructor_parameters())  # noqa: SLF001  # as SB3 loads it
    policy.load_state_dict(model.policy.state_dict())
    policy.set_training_mode(False)
    env = cast("VecEnv", model.get_env())
    return ModelPlayer(policy, led_by=env.get_attr("lower_level")[0])
