"""Names of the pieces, control points and cells of one scenario, both ways."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

from hexwar_sb3.errors import ConfigError, OrderError, UnknownNameError
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.rules.indices import CellIndex, PieceIndex

SIDES = (Camp.RED, Camp.BLUE)


def parse_camp(name: str | Camp) -> Camp:
    """Camp of a side from its name: "red" or "blue".

    Raises:
        UnknownNameError: another name.
    """
    if isinstance(name, Camp) and name in SIDES:
        return name
    for camp in SIDES:
        if str(name).lower() == camp_name(camp):
            return camp
    raise UnknownNameError("camp", str(name), map(camp_name, SIDES))


def camp_name(camp: int) -> str:
    """Text form of a camp: "red"."""
    return Camp(camp).name.lower()


def enemy_of(camp: int) -> Camp:
    """The other side."""
    return Camp(Camp.BLUE - camp)


class Roster:
    """Index and name of every piece; red's pieces come first, as in the records."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.names = tuple(str(piece) for piece in scenario.pieces)  # "red:tank0"
        self.camps = tuple(piece.camp for piece in scenario.pieces)

    @cached_property
    def _index(self) -> dict[str, PieceIndex]:
        return {name: PieceIndex(i) for i, name in enumerate(self.names)}

    def index(self, name: str) -> PieceIndex:
        """Index of a piece by its full name, "blue:tank0".

        Raises:
            UnknownNameError: no such piece.
        """
        if name not in self._index:
            raise UnknownNameError("piece", name, self._index)
        return self._index[name]

    def index_in(self, camp: int, name: str) -> PieceIndex:
        """Index of a piece whose camp need not be named."""
        return self.index(name if ":" in name else f"{camp_name(camp)}:{name}")

    def own_index(self, camp: int, name: str) -> PieceIndex:
        """Index of a piece of this camp, "tank0" or "red:tank0".

        Raises:
            OrderError: a piece of the other camp.
        """
        i = self.index_in(camp, name)
        if self.camps[i] != camp:
            raise OrderError(f"{name} does not belong to {camp_name(camp)}")
        return i

    def pieces_of(self, camp: int) -> Sequence[PieceIndex]:
        """Indices of a camp's pieces."""
        n_red = self.camps.count(Camp.RED)
        span = range(n_red) if camp == Camp.RED else range(n_red, len(self.names))
        return [PieceIndex(i) for i in span]

    def short(self, i: int) -> str:
        """Name within its camp: "tank0"."""
        return self.scenario.pieces[i].name

    def spoken(self, i: int) -> str:
        """Name in a sentence: "red tank0"."""
        return self.names[i].replace(":", " ")

    def point_index(self, name: str) -> int:
        """Number of a control point by its name."""
        names = [point.name for point in self.scenario.points]
        if name not in names:
            raise UnknownNameError("control point", name, names)
        return names.index(name)

    def cell(self, name: str) -> CellIndex:
        """Cell by its four-digit name.

        Raises:
            OrderError: no playable cell of this map.
        """
        try:
            return self.scenario.hexmap.parse_cell(name)
        except ConfigError as error:
            raise OrderError(str(error)) from None

    def cell_name(self, cell: int) -> str:
        """Column then row, as a map names its cells."""
        return self.scenario.hexmap.cell_name(int(cell))
