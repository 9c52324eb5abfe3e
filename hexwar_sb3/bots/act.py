"""What a scripted player does at an event: it thinks when it is time to, then fires."""

from __future__ import annotations

from hexwar_sb3.kernels import Row, Rows, kernel


@kernel
def bot_act(
    bot: int, camp: int, game: Row, pieces: Rows, memory: Rows, paths: Rows, rounds: Rows, orders: Rows,
    plans: Rows, brains: Rows, rules: Row, cells: Rows, los: Rows, eta: Rows, atlas: Row,
) -> None:  # fmt: skip
    """Let a bot look at its game at an event tick: it may choose plans and give direct orders."""


@kernel
def next_thought(brain: Row, tick: int) -> int:
    """First tick after `tick` at which the bot wants to act though nothing happens."""
    return (tick // 75 + 1) * 75
