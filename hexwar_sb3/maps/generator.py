"""Mirror-symmetric maps from a seed (rule book, section 1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from hexwar_sb3.maps.geometry import Bools
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.landscape import NEVER_HERE, Canvas, Field, highest
from hexwar_sb3.maps.scenario import ControlPoint, PieceStart, Scenario
from hexwar_sb3.rules.enums import Camp, PieceType

Place: TypeAlias = tuple[int, int]  # x, y
Altitudes: TypeAlias = npt.NDArray[np.int16]  # metres [y, x]

_LAST_FIELD = 1e-3  # weight that lets the last flooded field be a part of a parcel

WIDTH, HEIGHT = 71, 70
GRADE_M = 10
GAME_TICKS = 1800
POINTS = {"main": ((35, 34), 80), "secondary": ((35, 46), 50)}  # place, value in points
STARTS = {  # red's; blue's are the mirror images
    "tank0": (10, 34),
    "tank1": (10, 44),
    "chariot0": (9, 36),
    "chariot1": (9, 42),
    "soldier0": (9, 36),
    "soldier1": (9, 42),
    "aerocraft0": (8, 40),
}
HOMES = {"soldier0": "chariot0", "soldier1": "chariot1"}


@dataclass(frozen=True, kw_only=True)
class MapSpec:
    """What a map is to be like; places are in its western half."""

    name: str
    seed: int
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
    )
}


def generate(spec: MapSpec) -> HexMap:
    """The map of a spec; the same spec gives the same map."""
    canvas = Canvas(WIDTH, HEIGHT, np.random.default_rng(spec.seed))
    lakes = _lakes(canvas, spec)
    height = _relief(canvas, spec)
    streams = _streams(canvas, spec, height)
    height = _carved(canvas, height, streams | lakes)
    elev_m = _quantised(canvas, spec, height)
    roads = _roads(canvas, spec, elev_m, lakes)
    open_ground = canvas.playable & ~lakes & ~roads & ~_clearings(canvas)
    slushy = _slushy(canvas, spec, elev_m, streams & ~lakes, lakes, open_ground)
    concealed = _concealed(canvas, spec, elev_m, roads, open_ground & ~slushy)
    return HexMap(
        name=spec.name,
        grade_m=GRADE_M,
        elev_m=elev_m,
        passable=canvas.playable & ~lakes,
        paved=roads,
        concealed=concealed,
        slushy=slushy,
        controllable=canvas.both_sides([canvas.cell(*place) for place, _ in POINTS.values()]),
        seed=spec.seed,
    )


def standard_scenario(hexmap: HexMap) -> Scenario:
    """The default start of the rule book, seven pieces a side."""
    pieces = tuple(_piece(hexmap, camp, name) for camp in (Camp.RED, Camp.BLUE) for name in STARTS)
    points = tuple(
        ControlPoint(name=name, cell=y * hexmap.width + x, value=value)
        for name, ((x, y), value) in POINTS.items()
    )
    return Scenario(name=hexmap.name, hexmap=hexmap, pieces=pieces, points=points, game_ticks=GAME_TICKS)


def _piece(hexmap: HexMap, camp: Camp, name: str) -> PieceStart:
    x, y = STARTS[name]
    if camp == Camp.BLUE:
        x = hexmap.width - 1 - (y & 1) - x
    return PieceStart(
        camp=camp,
        name=name,
        kind=PieceType[name[:-1].upper()],
        cell=y * hexmap.width + x,
        home=HOMES.get(name),
        aboard=name in HOMES,
    )


def _clearings(canvas: Canvas) -> Bools:
    """Control points with their neighbours, and the start cells [y, x]."""
    marks = canvas.both_sides([canvas.cell(*place) for place in STARTS.values()])
    for place, _ in POINTS.values():
        marks |= canvas.disc(canvas.cell(*place), 1)
    return marks


def _lakes(canvas: Canvas, spec: MapSpec) -> Bools:
    marks = np.zeros(canvas.playable.shape, np.bool_)
    for place, reach in spec.lakes:
        marks |= canvas.symmetric(canvas.hexagon(canvas.cell(*place), reach))
    return marks


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
    cost[canvas.east > -4] = NEVER_HERE
    cells: list[int] = []
    for stops in spec.streams:
        cells += canvas.way_through([canvas.cell(*stop) for stop in stops], cost)
    return canvas.both_sides(cells)


def _carved(canvas: Canvas, height: Field, water: Bools) -> Field:
    """Heights with a valley along the water, and level ground around the control points."""
    valley = np.exp(-canvas.distance(water) / 2.5)
    height = height * (1 - 0.8 * valley)
    for place, _ in POINTS.values():
        cell = canvas.cell(*place)
        apart = canvas.distance(canvas.disc(cell, 1))
        level = height.flat[cell]
        height = height + (level - height) * np.exp(-((apart / 2) ** 2))
    return height


def _quantised(canvas: Canvas, spec: MapSpec, height: Field) -> Altitudes:
    """Altitudes in whole levels; every lake is level [y, x]."""
    levels = np.rint(height * spec.relief_m / GRADE_M)
    for place, reach in spec.lakes:
        patch = canvas.symmetric(canvas.hexagon(canvas.cell(*place), reach))
        levels[patch] = levels[patch].min()
    return np.where(canvas.playable, levels * GRADE_M, 0).astype(np.int16)


def _roads(canvas: Canvas, spec: MapSpec, elev_m: Altitudes, lakes: Bools) -> Bools:
    steep = _steepness(canvas, elev_m)
    cost = 1 + 0.6 * steep + 0.5 * abs(canvas.noise(6))
    cost[lakes | ~canvas.playable | (canvas.east > 0)] = NEVER_HERE
    cells: list[int] = []
    for stops in spec.roads:
        cells += canvas.way_through([canvas.cell(*stop) for stop in stops], cost)
    return canvas.both_sides(cells)


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


def _concealed(canvas: Canvas, spec: MapSpec, elev_m: Altitudes, roads: Bools, allowed: Bools) -> Bools:
    villages = np.zeros(roads.shape, np.bool_)
    for place in spec.villages:
        centre = canvas.nearest(canvas.cell(*place), roads)
        villages |= canvas.symmetric(canvas.disc(centre, 1)) & (roads | allowed)
    count = round(spec.concealed * canvas.playable.sum()) - int(villages.sum())
    score = canvas.noise(spec.forest_cells) + spec.forest_height * elev_m / spec.relief_m
    score += 0.3 * canvas.noise(3)
    return villages | highest(score, allowed & ~villages, count)
