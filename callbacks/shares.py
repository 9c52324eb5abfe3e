"""Shares of the episodes that begin in a special way, as the training goes on."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

from stable_baselines3.common.callbacks import BaseCallback

from hexwar_sb3.algorithms.presets import Preset
from hexwar_sb3.algorithms.qmix import QMIX


class ShareOfGames(BaseCallback):
    """Tells the env a share of its next episodes, as a function of the finished games: resumed runs go on right.

    Args:
        method: of the env: "set_demo_share" or "set_warm_start".
        share_at: finished games -> share, 0..1.

    Example:
        >>> callback = ShareOfGames("set_warm_start", lambda games: max(0.0, 1 - games / 5000))
    """

    def __init__(self, method: str, share_at: Callable[[int], float]) -> None:
        super().__init__()
        self.method, self.share_at = method, share_at
        self._told: float | None = None

    def _on_rollout_start(self) -> None:
        share = self.share_at(cast("QMIX", self.model)._episode_num)  # noqa: SLF001  # SB3's count of episodes
        if share != self._told:
            self.training_env.env_method(self.method, share)
            self._told = share

    def _on_step(self) -> bool:
        return True


def shares_of(preset: Preset, games: int) -> list[BaseCallback]:
    """Build the callbacks of a preset: demonstrations first, warm starts while they help.

    Args:
        preset: shares and numbers of games.
        games: of the whole training.
    """
    half = max(1, games // 2)
    return [
        ShareOfGames(
            "set_demo_share", lambda played: preset.demo_share if played < preset.demo_games else 0.0
        ),
        ShareOfGames("set_warm_start", lambda played: preset.warm_start * max(0.0, 1.0 - played / half)),
    ]
