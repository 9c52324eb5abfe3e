"""What stops the clock by itself, told from one view of a camp to the next."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import asdict, dataclass

from hexwar_sb3.engine.view import OwnPiece, SideView

FORGOTTEN_TICKS = 75  # an enemy that was out of sight for so long is news when it comes back


@dataclass(frozen=True)
class Stops:
    """What stops the clock; each can be switched off."""

    first_sight: bool = True  # an enemy came into sight that was never seen, or not for 75 ticks
    own_loss: bool = True  # an own piece lost blood
    idle: bool = True  # an own piece has done all that it was told

    def as_dict(self) -> dict[str, bool]:
        """The switches by name."""
        return asdict(self)


class Watcher:
    """Looks at one view of a camp after the other, and says what is new.

    Args:
        view: the first one.
        planned: names of pieces that have something to do yet.
    """

    def __init__(self, view: SideView, planned: Collection[str]) -> None:
        self.view, self.idle = view, _idle(view, planned)

    def look(self, view: SideView, planned: Collection[str], stops: Stops) -> list[str]:
        """Sentences for all that is new and should stop the clock."""
        before, was_idle = self.view, self.idle
        self.view, self.idle = view, _idle(view, planned)
        found = list[str]()
        if stops.first_sight:
            found += _sightings(before, view)
        if stops.own_loss:
            found += _losses(before, view)
        if stops.idle:
            names = (piece for piece in view.own if piece.name in self.idle - was_idle)
            found += [f"{piece.name} has done what it was told, in {piece.cell}" for piece in names]
        return found


def _sightings(before: SideView, now: SideView) -> Iterator[str]:
    known = {enemy.name for enemy in before.seen}
    gone = now.tick - before.tick
    known |= {enemy.name for enemy in before.lost if enemy.unseen_ticks + gone <= FORGOTTEN_TICKS}
    for enemy in now.seen:
        if enemy.name not in known:
            yield f"{enemy.name} came into sight in {enemy.cell}"


def _losses(before: SideView, now: SideView) -> Iterator[str]:
    for piece in now.own:
        lost = before.piece(piece.name).blood - piece.blood
        if lost > 0 and piece.alive:
            yield f"{piece.name} lost {lost}, {piece.blood} left"
        elif lost > 0:
            yield f"{piece.name} was destroyed"


def _idle(view: SideView, planned: Collection[str]) -> frozenset[str]:
    """Names of the pieces that have nothing to do."""
    return frozenset(piece.name for piece in view.own if is_idle(piece) and piece.name not in planned)


def is_idle(piece: OwnPiece) -> bool:
    """It lives, stands on the map with nothing under way, and its gun is cool."""
    return piece.alive and piece.aboard is None and piece.doing == "settled" and piece.cool_left == 0
