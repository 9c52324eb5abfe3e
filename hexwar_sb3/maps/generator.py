"""Maps from a seed, and who starts where on them (rule book, section 1)."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps.geometry import Bools
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.landscape import NEVER_HERE, Canvas, Field, highest
from hexwar_sb3.maps.scenario import ControlPoint, PieceStart, Scenario
from hexwar_sb3.maps.spec import MapSpec, Place, Start
from hexwar_sb3.rules.enums import Camp, PieceType

Altitudes: TypeAlias = npt.NDArray[np.int16]  # metres [y, x]

_LAST_FIELD = 1e-3  # weight that lets the last flooded field be a part of a parcel

GRADE_M = 10
NEAR_AXIS = 2  # cells; control points that are nearer stand on it


def generate(spec: MapSpec) -> HexMap:
    """The map of a spec; the same spec gives the same map."""
    canvas = Canvas(spec.width, spec.height, np.random.default_rng(spec.seed), spec.mirror)
    points = _points(canvas, spec.start)
    clearings = _clearings(canvas, spec.start, points)
    patches = _lakes(canvas, spec, clearings | _stops(canvas, spec))
    lakes = np.logical_or.reduce([canvas.playable & False, *patches])
    height = _relief(canvas, spec)
    streams = _streams(canvas, spec, height)
    height = _carved(canvas, height, streams | lakes, points)
    elev_m = _quantised(canvas, spec, height, patches)
    roads = _roads(canvas, spec, elev_m, lakes)
    open_ground = canvas.playable & ~lakes & ~roads & ~clearings
    slushy = _slushy(canvas, spec, elev_m, streams & ~lakes, lakes, open_ground)
    concealed = _concealed(canvas, spec, elev_m, roads, clearings, open_ground & ~slushy)
    return HexMap(
        name=spec.name,
        grade_m=GRADE_M,
        elev_m=elev_m,
        passable=canvas.playable & ~lakes,
        paved=roads,
        concealed=concealed,
        slushy=slushy,
        controllable=canvas.marks(points),
        seed=spec.seed,
    )


def standard_scenario(hexmap: HexMap, start: Start | None = None) -> Scenario:
    """The start of the rule book, seven pieces a side, or another one.

    Raises:
        ConfigError: the map has no room for it.
    """
    start = start or Start()
    canvas = Canvas(hexmap.width, hexmap.height, np.random.default_rng(0), hexmap.is_symmetric())
    cells = _points(canvas, start)
    points = tuple(
        ControlPoint(name=name, cell=cell, value=value)
        for cell, (name, (_, value)) in zip(cells, start.points.items(), strict=True)
    )
    free = (hexmap.passable & ~hexmap.slushy).copy()
    pieces = tuple(piece for camp in (Camp.RED, Camp.BLUE) for piece in _pieces(canvas, start, camp, free))
    return Scenario(
        name=hexmap.name, hexmap=hexmap, pieces=pieces, points=points, game_ticks=start.game_ticks
    )


def _pieces(canvas: Canvas, start: Start, camp: Camp, free: Bools) -> list[PieceStart]:
    """A camp's pieces, each in the free cell nearest to its place; the cells that they stand in are free no more."""
    taken: dict[str, int] = {}
    pieces = []
    for name, place in _places(canvas, start, camp):
        kind = PieceType[name.rstrip("0123456789").upper()]
        home = f"chariot{name.removeprefix('soldier')}" if kind == PieceType.SOLDIER else None
        taken[name] = taken[home] if home else _stand(canvas, place, camp, free)
        pieces.append(
            PieceStart(camp=camp, name=name, kind=kind, cell=taken[name], home=home, aboard=home is not None)
        )
    return pieces


def _stand(canvas: Canvas, place: int, camp: Camp, free: Bools) -> int:
    """Take the free cell of a camp's half that is nearest to a place.

    Raises:
        ConfigError: there is none left.
    """
    half = free & (canvas.east < 0 if camp == Camp.RED else canvas.east > 0)
    if not half.any():
        raise ConfigError("the map has no free dry cells left for so many pieces")
    # Blue looks in the mirrored map, so that ties go to the mirror image.
    found = int(canvas.mirror[canvas.nearest(int(canvas.mirror[place]), canvas.image(half))])
    cell = found if camp == Camp.BLUE else canvas.nearest(place, half)
    free.flat[cell] = False
    return cell


def _places(canvas: Canvas, start: Start, camp: Camp) -> list[tuple[str, int]]:
    """Names and places of a camp's pieces, whatever is there."""
    members = start.camp(start.pieces[camp], canvas.height)
    base, side = start.base, 1
    if camp == Camp.BLUE and start.blue_base is not None:
        base, side = start.blue_base, -1
    cells = [canvas.cell(base[0] + side * x, base[1] + y) for _, (x, y) in members]
    if camp == Camp.BLUE and start.blue_base is None:
        cells = canvas.mirror[cells].tolist()
    return [(name, cell) for (name, _), cell in zip(members, cells, strict=True)]


def _points(canvas: Canvas, start: Start) -> list[int]:
    """Cells of the control points, apart from each other.

    On a map that is alike those off the axis come in pairs, the eastern one as the image of the one before.

    Raises:
        ConfigError: there is no room for them.
    """
    free, cells = canvas.playable.copy(), list[int]()
    for name, (place, _) in start.points.items():
        cell = canvas.cell(*place)
        east = canvas.east.flat[cell]
        west = canvas.east.flat[cells[-1]] if cells else 0
        if canvas.alike and west <= -NEAR_AXIS and abs(west + east) < NEAR_AXIS:
            cell = int(canvas.mirror[cells[-1]])
        else:
            room = free & (canvas.east == 0) if canvas.alike and east > -NEAR_AXIS else free
            if not room.any():
                raise ConfigError(f"no room for the control point {name!r}")
            cell = canvas.nearest(cell, room)
        cells.append(cell)
        free &= ~canvas.disc(cell, 1)
    return cells


def _clearings(canvas: Canvas, start: Start, points: list[int]) -> Bools:
    """Control points with their neighbours, and the start cells [y, x]."""
    marks = canvas.marks([cell for camp in (Camp.RED, Camp.BLUE) for _, cell in _places(canvas, start, camp)])
    for cell in points:
        marks |= canvas.disc(cell, 1)
    return marks


def _stops(canvas: Canvas, spec: MapSpec) -> Bools:
    """Where roads must come by, and their images [y, x]."""
    marks = canvas.marks([canvas.cell(*stop) for stops in spec.roads for stop in stops])
    return marks | canvas.image(marks)


def _lakes(canvas: Canvas, spec: MapSpec, dry: Bools) -> list[Bools]:
    """Each lake [y, x]: with its image, or with others near to where that would be.

    A lake that would reach a dry cell, or cut the land in two, is smaller, or left out.
    """
    wanted = [(canvas.cell(*place), reach) for place, reach in spec.lakes]
    if not canvas.alike:
        wanted += [(canvas.beside(int(canvas.mirror[cell])), reach) for cell, reach in wanted]
    lakes, land = [], canvas.playable
    for cell, (a, b, c) in wanted:
        for less in range(max(a, b, c)):
            lake = canvas.symmetric(
                canvas.hexagon(cell, (max(1, a - less), max(1, b - less), max(1, c - less)))
            )
            if not (lake & dry).any() and canvas.is_whole(land & ~lake):
                lakes.append(lake)
                land = land & ~lake
                break
    return lakes


def _relief(canvas: Canvas, spec: MapSpec) -> Field:
    """Heights about 0..1, before anything is dug [y, x]."""
    rolling = canvas.noise(spec.swell_cells) / 2
    ridge = 1 - 2 * abs(canvas.noise(spec.swell_cells))
    height = rolling * (1 - spec.ridges) + ridge / 2 * spec.ridges
    height += spec.roughness * canvas.noise(spec.swell_cells / 2.5) / 2
    low, high = np.quantile(height[canvas.playable], (0.01, 0.99))
    return np.clip((height - low) / (high - low), 0, 1) ** spec.lowland


def _streams(canvas: Canvas, spec: MapSpec, height: Field) -> Bools:
    cost = 0.1 + height**2 + 0.3 * abs(canvas.noise(5))
    return _ways(canvas, spec.streams, cost, apart=min(4.0, 4 * spec.width / 71))


def _ways(canvas: Canvas, ways: tuple[tuple[Place, ...], ...], cost: Field, apart: float) -> Bools:
    """Cheapest ways through western stops, and their images or, on a map that is not mirrored, ways through the stops' images.

    Args:
        canvas: to draw on.
        ways: stops of each.
        cost: of entering a cell [y, x].
        apart: cells from the axis that they keep.
    """
    west, east = (np.where(side > -apart, NEVER_HERE, cost) for side in (canvas.east, -canvas.east))
    stops = [[_kept_west(canvas, canvas.cell(*stop), apart) for stop in each] for each in ways]
    cells = [cell for each in stops for cell in canvas.way_through(each, west)]
    if not canvas.alike:
        cells += [cell for each in stops for cell in canvas.way_through(canvas.mirror[each].tolist(), east)]
    return canvas.marks(cells)


def _kept_west(canvas: Canvas, cell: int, apart: float) -> int:
    """A western stop that rounding took over the line, back on its side."""
    return cell - int(canvas.east.flat[cell] > -apart)


def _carved(canvas: Canvas, height: Field, water: Bools, points: list[int]) -> Field:
    """Heights with a valley along the water, and level ground around the control points."""
    valley = np.exp(-canvas.distance(water) / 2.5)
    height = height * (1 - 0.8 * valley)
    for cell in points:
        apart = canvas.distance(canvas.disc(cell, 1))
        level = height.flat[cell]
        height = height + (level - height) * np.exp(-((apart / 2) ** 2))
    return canvas.fold(height)


def _quantised(canvas: Canvas, spec: MapSpec, height: Field, lakes: list[Bools]) -> Altitudes:
    """Altitudes in whole levels; every lake is level [y, x]."""
    levels = np.rint(height * spec.relief_m / GRADE_M)
    for patch in lakes:
        levels[patch] = levels[patch].min()
    return np.where(canvas.playable, levels * GRADE_M, 0).astype(np.int16)


def _roads(canvas: Canvas, spec: MapSpec, elev_m: Altitudes, lakes: Bools) -> Bools:
    steep = _steepness(canvas, elev_m)
    cost = 1 + 0.6 * steep + 0.5 * abs(canvas.noise(6))
    cost[lakes | ~canvas.playable] = NEVER_HERE
    return _ways(canvas, spec.roads, cost, apart=0.0)


def _steepness(canvas: Canvas, elev_m: Altitudes) -> Field:
    """Levels to the steepest neighbour [y, x]."""
    levels = elev_m.ravel() / GRADE_M
    climb = np.where(canvas.neighbours < 0, 0, abs(levels[canvas.neighbours] - levels[:, None]))
    return climb.max(axis=1).reshape(elev_m.shape)


def _slushy(
    canvas: Canvas, spec: MapSpec, elev_m: Altitudes, streams: Bools, lakes: Bools, allowed: Bools
) -> Bools:
    count = round(spec.slushy * canvas.playable.sum())
    wet = 2 * np.exp(-canvas.distance(streams | lakes) / 3) - elev_m / spec.relief_m
    wet += 0.5 * canvas.noise(6)
    if spec.field_cells:
        means, dykes = canvas.parcels(spec.field_cells, wet)
        wet = means + _LAST_FIELD * wet
        allowed = allowed & (~dykes | streams)
    return highest(wet + 10 * streams, allowed, count)


def _concealed(
    canvas: Canvas, spec: MapSpec, elev_m: Altitudes, roads: Bools, clearings: Bools, allowed: Bools
) -> Bools:
    streets = roads & ~clearings
    villages = np.zeros(roads.shape, np.bool_)
    for place in spec.villages:
        cell = canvas.cell(*place)
        for each in (cell,) if canvas.alike else (cell, int(canvas.mirror[cell])):
            villages |= canvas.symmetric(canvas.disc(canvas.nearest(each, roads), 1)) & (streets | allowed)
    count = round(spec.concealed * canvas.playable.sum()) - int(villages.sum())
    score = canvas.noise(spec.forest_cells) + spec.forest_height * elev_m / spec.relief_m
    score += 0.3 * canvas.noise(3)
    return villages | highest(score, allowed & ~villages, count)
