"""Orders: one frozen class an action (rule book, section 4), with a text form both ways.

`str(Shoot("tank1", "blue:chariot0", "GUN"))` is `"tank1 shoot blue:chariot0 GUN"`, and
`Order.parse` reads it back. A piece of the own camp is "tank0", any other "blue:tank0"; a cell
is its four-digit name.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields
from typing import ClassVar

from hexwar_sb3.errors import OrderError
from hexwar_sb3.rules.enums import Action, Weapon


@dataclass(frozen=True, slots=True)
class Chances:
    """What a shot may do, by the camp's own knowledge: probabilities of each result.

    nothing: no effect; suppressed: suppressed without loss; losses[n]: n + 1 losses or more
    exactly (capped at the target's blood). They sum to 1.
    """

    level: int  # attack level after the height correction, 1..10
    modifiers: int  # added to the correction roll
    nothing: float
    suppressed: float
    losses: tuple[float, ...]

    @property
    def expected_losses(self) -> float:
        """Mean number of vehicles or squads lost."""
        return sum((n + 1) * chance for n, chance in enumerate(self.losses))


@dataclass(frozen=True, slots=True)
class BurstChances:
    """Where a mortar round may come down, by what the camp sees now; they sum to 1."""

    hit: float
    off_target: float  # in the aimed cell, but off target
    scatter: float  # one or more cells away


@dataclass(frozen=True)
class Order:
    """An order to one piece for the current tick."""

    piece: str
    action: ClassVar[Action] = Action.NULL

    def words(self) -> tuple[str, ...]:
        """The parameters as text, in the order of the fields."""
        return ()

    def __str__(self) -> str:
        return " ".join((self.piece, verb(self.action), *self.words()))

    @staticmethod
    def parse(text: str) -> Order:
        """Read an order from its text form.

        Raises:
            OrderError: the text is no order; says what was expected.
        """
        words = text.split()
        if len(words) < 2:
            raise OrderError(f"order {text!r}: expected a piece and an action, like 'tank0 move 1134'")
        piece, action, *rest = words
        if action not in _BY_VERB:
            raise OrderError(f"order {text!r}: unknown action {action!r}{did_you_mean(action, _BY_VERB)}")
        return _BY_VERB[action].from_words(piece, rest)

    @classmethod
    def from_words(cls, piece: str, words: Sequence[str]) -> Order:
        """Build the order from its parameters as text."""
        names = [entry.name for entry in fields(cls) if entry.name not in {"piece", "chances"}]
        if len(words) != len(names):
            found = f"{len(words)} parameters" if words else "none"
            expected = " ".join(names) or "no parameters"
            raise OrderError(f"{piece} {verb(cls.action)}: expected {expected}, found {found}")
        return cls(piece, *words)


def verb(action: Action) -> str:
    """Word of an action in the text form: "guide-shoot"."""
    return action.name.lower().replace("_", "-")


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Hint with the nearest known name, or nothing."""
    close = difflib.get_close_matches(name, list(known), n=1)
    return f"; did you mean {close[0]!r}?" if close else ""


@dataclass(frozen=True)
class Null(Order):
    """Do nothing new; also takes back an order that was given for this tick."""


@dataclass(frozen=True)
class Move(Order):
    """Walk a path: cell names, or directions W SW SE E NE NW, one a hop. All hops are one order."""

    path: tuple[str, ...]
    action: ClassVar[Action] = Action.MOVE

    def __init__(self, piece: str, path: str | Sequence[str]) -> None:
        steps = path.split() if isinstance(path, str) else path
        object.__setattr__(self, "piece", piece)
        object.__setattr__(self, "path", tuple(steps))

    def words(self) -> tuple[str, ...]:
        """The parameters as text, in the order of the fields."""
        return self.path

    @classmethod
    def from_words(cls, piece: str, words: Sequence[str]) -> Move:
        """Every word is a step of the path."""
        return cls(piece, words)


@dataclass(frozen=True)
class Stop(Order):
    """Stop the move under way: turn back, or finish the hop, then stand."""

    action: ClassVar[Action] = Action.STOP


@dataclass(frozen=True)
class Hide(Order):
    """Take cover where the piece stands."""

    action: ClassVar[Action] = Action.HIDE


@dataclass(frozen=True)
class Occupy(Order):
    """Take the control point in which the piece stands."""

    action: ClassVar[Action] = Action.OCCUPY


@dataclass(frozen=True)
class Shoot(Order):
    """Direct fire with one weapon at an enemy that the piece itself sees."""

    target: str
    weapon: str
    chances: Chances | None = field(default=None, compare=False, repr=False)
    action: ClassVar[Action] = Action.SHOOT

    def __post_init__(self) -> None:
        object.__setattr__(self, "weapon", weapon_name(self.weapon))

    def words(self) -> tuple[str, ...]:
        """The parameters as text, in the order of the fields."""
        return self.target, self.weapon


@dataclass(frozen=True)
class GuideShoot(Order):
    """Guide a heavy missile of an own chariot to a vehicle that the piece sees."""

    target: str
    chariot: str
    chances: Chances | None = field(default=None, compare=False, repr=False)
    action: ClassVar[Action] = Action.GUIDE_SHOOT

    def words(self) -> tuple[str, ...]:
        """The parameters as text, in the order of the fields."""
        return self.target, self.chariot


@dataclass(frozen=True)
class IndirectShoot(Order):
    """Mortar round of a chariot at a cell."""

    cell: str
    chances: BurstChances | None = field(default=None, compare=False, repr=False)
    action: ClassVar[Action] = Action.INDIRECT_SHOOT

    def words(self) -> tuple[str, ...]:
        """The parameters as text, in the order of the fields."""
        return (self.cell,)


@dataclass(frozen=True)
class GetOn(Order):
    """A soldier boards a chariot in its cell."""

    chariot: str
    action: ClassVar[Action] = Action.GET_ON

    def words(self) -> tuple[str, ...]:
        """The parameters as text, in the order of the fields."""
        return (self.chariot,)


@dataclass(frozen=True)
class GetOff(Order):
    """A chariot sets its passenger down."""

    passenger: str
    action: ClassVar[Action] = Action.GET_OFF

    def words(self) -> tuple[str, ...]:
        """The parameters as text, in the order of the fields."""
        return (self.passenger,)


@dataclass(frozen=True)
class Decompress(Order):
    """Come out of suppression before it ends by itself."""

    action: ClassVar[Action] = Action.DECOMPRESS


ORDERS: dict[Action, type[Order]] = {
    order.action: order
    for order in (Null, Move, Stop, Hide, Occupy, Shoot, GuideShoot, IndirectShoot, GetOn, GetOff, Decompress)
}
_BY_VERB = {verb(action): order for action, order in ORDERS.items()}


def weapon_name(weapon: str) -> str:
    """Canonical name of a weapon: "GUN".

    Raises:
        OrderError: no such weapon.
    """
    name = str(weapon).upper()
    if name not in Weapon.__members__:
        raise OrderError(f"unknown weapon {weapon!r}{did_you_mean(name, Weapon.__members__)}")
    return name
