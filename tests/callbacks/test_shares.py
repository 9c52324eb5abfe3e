"""Shares of the episodes that begin in a special way."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from hexwar_sb3.callbacks.shares import ShareOfGames


class Told:
    """An env that notes what it is told."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, float]] = []

    def env_method(self, method: str, share: float) -> None:
        self.calls.append((method, share))


def test_a_share_follows_the_finished_games_and_is_told_when_it_changes() -> None:
    env = Told()
    model = SimpleNamespace(_episode_num=0, get_env=lambda: env, logger=None)
    callback = ShareOfGames("set_warm_start", lambda games: 1.0 if games < 2 else 0.25)
    callback.init_callback(cast("Any", model))

    for games in (0, 1, 2, 3, 3):
        model._episode_num = games
        callback.on_rollout_start()

    assert env.calls == [("set_warm_start", 1.0), ("set_warm_start", 0.25)]
