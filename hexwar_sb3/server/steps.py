"""Steps of a plan: orders as text, and waypoints, `tank0 go 1234` (formats/play.md)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from hexwar_sb3.engine.legal import Advisor
from hexwar_sb3.engine.orders import Null, Order
from hexwar_sb3.errors import OrderError

GO = "go"
MOST_STEPS = 32  # of a piece's plan


@dataclass(frozen=True)
class Go:
    """Walk to a cell by the engine's fastest way."""

    piece: str
    cell: str

    def __str__(self) -> str:
        return f"{self.piece} {GO} {self.cell}"


Step: TypeAlias = Order | Go


def read_steps(piece: str, texts: tuple[str, ...], advisor: Advisor) -> tuple[Step, ...]:
    """The steps of a plan for a piece, each of them one that could be given at some time.

    Raises:
        OrderError, UnknownNameError: one is no order, is for another piece, or names what does not exist.
    """
    if not 1 <= len(texts) <= MOST_STEPS:
        raise OrderError(f"the plan of {piece} has {len(texts)} steps; expected 1 to {MOST_STEPS}")
    return tuple(_read(piece, text, advisor) for text in texts)


def _read(piece: str, text: str, advisor: Advisor) -> Step:
    words = text.split()
    step = _read_go(words, advisor) if words[1:2] == [GO] else Order.parse(text)
    if step.piece != piece:
        raise OrderError(f"{text!r} is for {step.piece}; expected a step of {piece}")
    if isinstance(step, Null):
        raise OrderError(f"{text!r} does nothing; expected an order or {piece} {GO} 1134")
    if isinstance(step, Order):
        advisor.judge(step)  # raises where it names what does not exist
    return step


def _read_go(words: list[str], advisor: Advisor) -> Go:
    if len(words) != 3:
        raise OrderError(f"{' '.join(words)!r}: expected one cell after {GO!r}, like {words[0]} {GO} 1134")
    return Go(words[0], advisor.roster.cell_name(advisor.roster.cell(words[2])))
