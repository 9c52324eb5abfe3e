"""What the tests of the envs share: cheap stand-ins, and legal scenarios of all sorts."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hexwar_sb3.maps.geometry import playable_mask
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.map_file import MAX_ALTITUDE_M, MAX_GRADE_M
from hexwar_sb3.maps.scenario import (
    MAX_CONTROL_POINTS,
    MAX_GAME_TICKS,
    MAX_POINT_VALUE,
    MAX_SIDE_PIECES,
    ControlPoint,
    PieceStart,
    Scenario,
)
from hexwar_sb3.rules.enums import Camp, PieceType

Masks = NDArray[Any]


def pick_valid(mask: Masks, step: int) -> NDArray[np.int64]:
    """A valid task for every piece that depends on its own mask and the step alone, [..., N]."""
    valid = mask.sum(-1)
    wanted = (7 * step + 3 * np.arange(mask.shape[-2])) % valid
    order = np.argsort(1 - mask, axis=-1, kind="stable")  # valid rows first
    return np.take_along_axis(order, wanted[..., None], -1)[..., 0]


@pytest.fixture
def pick() -> Callable[[Masks, int], NDArray[np.int64]]:
    return pick_valid


SIDES = ((3, 3), (3, 4), (99, 3), (3, 99), (8, 7), (21, 13), (14, 30))  # width, height
TICKS = (1, 2, 76, 1800, MAX_GAME_TICKS)
KINDS = (  # of the pieces of a camp
    tuple(PieceType),
    (PieceType.AEROCRAFT,),
    (PieceType.TANK, PieceType.AEROCRAFT),
    (PieceType.SOLDIER, PieceType.CHARIOT),
)
STACK = 4  # ground pieces of a camp in a cell


def odd_scenario(seed: int) -> Scenario:
    """A scenario that is legal, and otherwise as the dice fall."""
    rng = np.random.default_rng(seed)
    hexmap = _odd_map(rng)
    dry = np.flatnonzero(hexmap.passable & ~hexmap.slushy)
    camps = [_odd_camp(rng, camp, hexmap, dry[camp::2]) for camp in (Camp.RED, Camp.BLUE)]
    return Scenario(
        name=f"odd{seed}",
        hexmap=hexmap,
        pieces=(*camps[0], *camps[1]),
        points=_odd_points(rng, hexmap),
        game_ticks=int(rng.choice(TICKS)),
        net_score=bool(rng.integers(2)),
    )


def _odd_map(rng: np.random.Generator) -> HexMap:
    width, height = SIDES[rng.integers(len(SIDES))]
    grade_m = int(rng.choice([1, 10, MAX_GRADE_M]))
    steps = int(rng.choice([0, 2, MAX_ALTITUDE_M // grade_m]))
    playable = playable_mask(width, height)

    def some(share: float) -> NDArray[np.bool_]:
        return playable & (rng.random(playable.shape) < share)

    passable = some(rng.choice([0.7, 1.0]))
    passable[0, 0] = passable[0, 1] = True
    slushy = some(0.1)
    slushy[0, :2] = False
    return HexMap(
        name="odd",
        grade_m=grade_m,
        elev_m=np.where(playable, grade_m * rng.integers(0, steps + 1, playable.shape), 0).astype(np.int16),
        passable=passable,
        paved=some(0.2),
        concealed=some(0.3),
        slushy=slushy,
        controllable=passable & some(0.8),
    )


def _odd_camp(
    rng: np.random.Generator, camp: Camp, hexmap: HexMap, dry: NDArray[np.int64]
) -> list[PieceStart]:
    kinds = KINDS[rng.integers(len(KINDS))]
    places = rng.permutation(np.repeat(dry, STACK))
    pieces: list[PieceStart] = []
    for n in range(rng.choice([1, 2, 7, MAX_SIDE_PIECES])):
        kind = kinds[rng.integers(len(kinds))] if n < len(places) else PieceType.AEROCRAFT
        flies = kind == PieceType.AEROCRAFT
        cell = int(rng.choice(np.flatnonzero(hexmap.playable)) if flies else places[n])
        pieces.append(PieceStart(camp=camp, name=f"{kind.name.lower()}{n}", kind=kind, cell=cell))
    return _with_riders(pieces)


def _with_riders(pieces: list[PieceStart]) -> list[PieceStart]:
    """Let a soldier that follows a chariot belong to it and ride in it."""
    riders = list(pieces)
    for k, (chariot, soldier) in enumerate(pairwise(pieces)):
        if (chariot.kind, soldier.kind) == (PieceType.CHARIOT, PieceType.SOLDIER):
            riders[k + 1] = PieceStart(
                camp=soldier.camp,
                name=soldier.name,
                kind=soldier.kind,
                cell=chariot.cell,
                home=chariot.name,
                aboard=True,
            )
    return riders


def _odd_points(rng: np.random.Generator, hexmap: HexMap) -> tuple[ControlPoint, ...]:
    cells = np.flatnonzero(hexmap.controllable & hexmap.passable)
    chosen = rng.permutation(cells)[: rng.choice([0, 1, MAX_CONTROL_POINTS])]
    values = rng.choice([1, 80, MAX_POINT_VALUE], len(chosen))
    return tuple(
        ControlPoint(name=f"point{k}", cell=int(cell), value=int(value))
        for k, (cell, value) in enumerate(zip(chosen, values, strict=True))
    )


@pytest.fixture
def odd() -> Callable[[int], Scenario]:
    return odd_scenario
