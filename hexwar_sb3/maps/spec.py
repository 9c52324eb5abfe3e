"""What maps and their starts are to be like: the built-in ones, and any of another size or line-up."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from hexwar_sb3.checks import check_whole
from hexwar_sb3.maps.geometry import MAX_SIDE_CELLS
from hexwar_sb3.maps.scenario import MAX_SIDE_PIECES

Place: TypeAlias = tuple[int, int]  # x, y

LEAST_WIDTH, LEAST_HEIGHT = 15, 11  # cells; less has no room for lakes, roads and two camps
STANDARD = (
    "hills",
    "paddy",
    "plain",
)  # seven against seven: bots were accepted on them, lower levels learn on them
SQUAD = {  # a squad's pieces in the order in which camps grow; cells from the squad's base, red's
    "tank0": (1, -6),
    "chariot0": (0, -4),
    "soldier0": (0, -4),
    "aerocraft0": (-1, 0),
    "tank1": (1, 4),
    "chariot1": (0, 2),
    "soldier1": (0, 2),
}
_KINDS = ("tank", "chariot", "soldier", "aerocraft")  # order of a camp's pieces
_SQUAD_ROWS, _SQUAD_COLUMNS = 12, 4  # cells between squads


@dataclass(frozen=True, kw_only=True)
class Start:
    """What a scenario on a map begins with."""

    pieces: tuple[int, int] = (7, 7)  # of red, of blue
    points: Mapping[str, tuple[Place, int]] = field(  # place, value in points
        default_factory=lambda: {"main": ((35, 34), 80), "secondary": ((35, 46), 50)}
    )
    base: Place = (9, 40)  # of red's first squad
    blue_base: Place | None = None  # None: the mirror image of red's
    game_ticks: int = 1800

    def __post_init__(self) -> None:
        """Check the numbers of pieces.

        Raises:
            ConfigError: a camp has none, or more than a scenario may have.
        """
        for count in self.pieces:
            check_whole("pieces", count, least=1, most=MAX_SIDE_PIECES)

    def camp(self, count: int, height: int) -> list[tuple[str, Place]]:
        """Names of a camp's pieces in their order, with their places from the camp's base.

        Squads stand above each other, in front of each other where the map is not high enough.
        """
        members = [_member(number, height) for number in range(count)]
        return sorted(members, key=lambda member: (_KINDS.index(_kind(member[0])), _number(member[0])))


def _member(number: int, height: int) -> tuple[str, Place]:
    """The piece by which a camp grows as its `number`-th."""
    squad, place = divmod(number, len(SQUAD))
    name, (x, y) = list(SQUAD.items())[place]
    of_kind = sum(_kind(other) == _kind(name) for other in SQUAD)
    column, row = divmod(squad, max(1, height // (_SQUAD_ROWS + 1)))
    down = (row + 1) // 2 * _SQUAD_ROWS * (1 if row % 2 else -1)
    return f"{_kind(name)}{squad * of_kind + _number(name)}", (x + column * _SQUAD_COLUMNS, y + down)


def _kind(name: str) -> str:
    return name.rstrip("0123456789")


def _number(name: str) -> int:
    return int(name[len(_kind(name)) :])


@dataclass(frozen=True, kw_only=True)
class MapSpec:
    """What a map is to be like; places are in its western half, where it is mirrored."""

    name: str
    seed: int
    width: int = 71
    height: int = 70
    mirror: bool = True  # west and east alike; else drawn each by itself
    relief_m: int  # highest altitude; the lowest is 0
    swell_cells: float  # wavelength of the large forms
    ridges: float  # 0: rolling ground, 1: ridges and valleys
    roughness: float  # share of the small forms
    concealed: float  # share of the playable cells
    slushy: float  # share of the playable cells
    field_cells: float = 0.0  # size of flooded fields between dykes; 0: marsh along the streams
    lowland: float = 1.0  # exponent of the heights: more than 1 makes flat low ground
    forest_cells: float = 9.0  # wavelength of the forests
    forest_height: float = 0.0  # how much more forest high ground has than low ground
    roads: tuple[tuple[Place, ...], ...]
    villages: tuple[Place, ...] = ()
    streams: tuple[tuple[Place, ...], ...]
    lakes: tuple[tuple[Place, tuple[int, int, int]], ...]  # centre, reach in each cube coordinate
    start: Start = Start()

    def resized(self, width: int, height: int) -> MapSpec:
        """The same on a map of another size: places move along, forms and forests keep their size.

        Raises:
            ConfigError: a side is out of its range.
        """
        check_whole("width", width, least=LEAST_WIDTH, most=MAX_SIDE_CELLS)
        check_whole("height", height, least=LEAST_HEIGHT, most=MAX_SIDE_CELLS)

        def moved(place: Place) -> Place:
            x, y = place
            return x * (width - 1) // (self.width - 1), y * (height - 1) // (self.height - 1)

        def shrunk(reach: int) -> int:
            return max(1, min(reach * width // self.width, reach * height // self.height))

        start, blue = self.start, self.start.blue_base
        points = {name: (moved(place), value) for name, (place, value) in start.points.items()}
        return replace(
            self,
            width=width,
            height=height,
            roads=tuple(tuple(map(moved, stops)) for stops in self.roads),
            streams=tuple(tuple(map(moved, stops)) for stops in self.streams),
            villages=tuple(map(moved, self.villages)),
            lakes=tuple((moved(at), (shrunk(a), shrunk(b), shrunk(c))) for at, (a, b, c) in self.lakes),
            start=replace(start, points=points, base=moved(start.base), blue_base=blue and moved(blue)),
        )


MAP_SPECS = {
    spec.name: spec
    for spec in (
        MapSpec(
            name="plain",
            seed=4,
            relief_m=60,
            swell_cells=20,
            ridges=0.2,
            roughness=0.35,
            concealed=0.15,
            slushy=0.08,
            roads=(((0, 38), (14, 38), (35, 34)),),
            villages=((18, 37),),
            streams=(((16, 0), (20, 69)),),
            lakes=(((22, 20), (3, 2, 3)), ((17, 58), (2, 2, 3))),
        ),
        MapSpec(
            name="hills",
            seed=5,
            relief_m=300,
            swell_cells=20,
            ridges=0.8,
            roughness=0.25,
            concealed=0.30,
            slushy=0.05,
            forest_height=0.5,
            roads=(((0, 32), (14, 33), (35, 34)), ((0, 48), (16, 48), (35, 46))),
            villages=((22, 33), (20, 48)),
            streams=(((22, 0), (24, 69)),),
            lakes=(((24, 16), (2, 2, 3)), ((25, 60), (2, 2, 2))),
        ),
        MapSpec(
            name="paddy",
            seed=4,
            relief_m=40,
            swell_cells=24,
            ridges=0.0,
            roughness=0.2,
            concealed=0.12,
            slushy=0.30,
            field_cells=5.5,
            lowland=2.0,
            forest_cells=6.0,
            roads=(((0, 40), (16, 42), (35, 46)),),
            villages=((16, 42), (27, 45)),
            streams=(((14, 0), (18, 69)),),
            lakes=(((24, 12), (3, 2, 3)), ((12, 60), (3, 2, 3))),
        ),
        MapSpec(  # three against three: a tank, a chariot and its soldier
            name="skirmish",
            seed=1,
            width=21,
            height=15,
            relief_m=30,
            swell_cells=12,
            ridges=0.2,
            roughness=0.3,
            concealed=0.15,
            slushy=0.05,
            forest_cells=5.0,
            roads=(((0, 7), (10, 6)),),
            streams=(((5, 0), (6, 14)),),
            lakes=(((7, 2), (1, 1, 1)),),
            start=Start(pieces=(3, 3), points={"main": ((10, 6), 80)}, base=(2, 9), game_ticks=600),
        ),
        MapSpec(  # the stronger camp comes for a point that the other one stands at
            name="assault",
            seed=3,
            width=61,
            height=50,
            mirror=False,
            relief_m=120,
            swell_cells=18,
            ridges=0.5,
            roughness=0.3,
            concealed=0.25,
            slushy=0.06,
            forest_height=0.3,
            roads=(((0, 24), (14, 26), (30, 24)),),
            villages=((18, 25),),
            streams=(((16, 0), (20, 49)),),
            lakes=(((20, 14), (2, 2, 3)),),
            start=Start(
                pieces=(9, 5),
                points={"main": ((42, 24), 80)},
                base=(7, 26),
                blue_base=(46, 26),
                game_ticks=1500,
            ),
        ),
        MapSpec(  # thirty against thirty
            name="battalion",
            seed=2,
            width=120,
            height=120,
            relief_m=150,
            swell_cells=28,
            ridges=0.4,
            roughness=0.3,
            concealed=0.2,
            slushy=0.08,
            forest_cells=12.0,
            roads=(((0, 40), (24, 42), (59, 46)), ((0, 78), (26, 80), (59, 76))),
            villages=((30, 42), (32, 79)),
            streams=(((34, 0), (30, 119)),),
            lakes=(((36, 24), (3, 3, 4)), ((28, 98), (3, 3, 3)), ((44, 61), (2, 3, 2))),
            start=Start(
                pieces=(30, 30),
                points={
                    "main": ((59, 59), 80),
                    "north": ((59, 39), 50),
                    "south": ((59, 79), 50),
                    "northmost": ((59, 21), 40),
                    "southmost": ((59, 97), 40),
                },
                base=(18, 60),
                game_ticks=2400,
            ),
        ),
    )
}
