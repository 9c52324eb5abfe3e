"""What a piece can do, from where it is or from a cell that is only thought of, by its camp's knowledge alone."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import Any

import numpy as np

from hexwar_sb3.engine.chances import NOT_LEGAL, burst_chances
from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.legal import Advisor
from hexwar_sb3.engine.orders import (
    BurstChances,
    Decompress,
    GetOff,
    GetOn,
    GuideShoot,
    Hide,
    IndirectShoot,
    Move,
    Occupy,
    Order,
    Shoot,
    Stop,
)
from hexwar_sb3.engine.pieces import has_path, is_busy
from hexwar_sb3.engine.records import NEVER, NO_PIECE
from hexwar_sb3.engine.roster import enemy_of, parse_camp
from hexwar_sb3.engine.sight import sees
from hexwar_sb3.errors import OrderError
from hexwar_sb3.kernels import Row
from hexwar_sb3.maps.geometry import DIRECTION_NAMES, cells_apart
from hexwar_sb3.rules.compiled import NO_POOL
from hexwar_sb3.rules.enums import Camp, PieceType, Weapon
from hexwar_sb3.rules.indices import CellIndex, PieceIndex
from hexwar_sb3.server.imagine import imagined, remembered
from hexwar_sb3.server.ways import find_way

Json = dict[str, Any]
DIGITS = 4  # of a chance
_NEVER_ITS_OWN = frozenset({Code.WRONG_TYPE, Code.NOT_ARMED, Code.NOT_GROUND})
"""Codes of what a piece of its kind can do at no time."""


def look_at(game: Game, camp: str, piece: str, at: int | None) -> Json:
    """What a piece can be ordered: the answer to `look`.

    Args:
        game: as it stands.
        camp: whose piece it is.
        piece: its name.
        at: cell in which it is thought of as standing; None: where it is.

    Raises:
        OrderError, UnknownNameError: no such piece or cell.
    """
    side, i = own_piece(game, camp, piece)
    if at is None:
        advisor = game.advisor(side)
    else:
        advisor = imagined(i, checked_cell(game, at), side, game.state, game.world)
    orders = advisor.orders_by_name(i)
    fire = [order for order in orders if isinstance(order, Shoot | GuideShoot)]
    return {
        "piece": piece,
        "at": int(advisor.pieces[i].cell),
        "planned": at is not None,
        "orders": [str(order) for order in orders if order not in fire and order.action],
        "shots": [_shot(order, game, advisor) for order in fire],
        "mortar": _mortar(i, advisor),
        "impossible": list(_impossible(i, advisor)),
    }


def own_piece(game: Game, camp: str, piece: str) -> tuple[Camp, PieceIndex]:
    """A camp and the index of its piece.

    Raises:
        OrderError, UnknownNameError: it has no such piece.
    """
    side = parse_camp(camp)
    return side, game.roster.own_index(side, piece)


def checked_cell(game: Game, cell: int) -> CellIndex:
    """A cell by its number.

    Raises:
        OrderError: the map has none, or nobody may be there.
    """
    playable = game.world.cells.playable
    if not (0 <= cell < playable.size and playable[cell]):
        raise OrderError(f"cell {cell}: expected a playable cell of the map, 0..{playable.size - 1}")
    return CellIndex(cell)


def _shot(order: Shoot | GuideShoot, game: Game, advisor: Advisor) -> Json:
    chances = order.chances
    assert chances is not None  # noqa: S101  # as `orders_by_name` gives it
    j = game.roster.index_in(enemy_of(advisor.camp), order.target)
    known = game.state.memory[0, advisor.camp, j]
    told = (chances.nothing, chances.suppressed, *chances.losses)
    return {
        "order": str(order),
        "target": game.roster.names[j],
        "level": chances.level,
        "chances": [round(chance, DIGITS) for chance in told],
        "points": round(chances.expected_losses * int(advisor.rules.value[advisor.pieces[j].kind]), 2),
        "ago": 0 if known.seen else game.tick - int(known.tick),
    }


def _mortar(i: PieceIndex, advisor: Advisor) -> list[Json]:
    """Cells of legal mortar fire, those with equal chances together."""
    if not _has_mortar(i, advisor):
        return []
    classes = advisor.mortar_classes(i)
    groups: dict[tuple[int, BurstChances], list[int]] = defaultdict(list)
    for cell in np.flatnonzero(classes != NOT_LEGAL).tolist():
        apart = int(cells_apart(advisor.cells, CellIndex(int(advisor.pieces[i].cell)), CellIndex(cell)))
        groups[int(classes[cell]), burst_chances(int(classes[cell]), apart, advisor.rules)].append(cell)
    return [_group(number, chances, cells) for (number, chances), cells in groups.items()]


def _group(number: int, chances: BurstChances, cells: list[int]) -> Json:
    names = ("hit", "off_target", "scatter")
    return {
        "class": number,
        **{name: round(getattr(chances, name), DIGITS) for name in names},
        "cells": cells,
    }


def _has_mortar(i: PieceIndex, advisor: Advisor) -> bool:
    return bool(advisor.rules.pool[advisor.pieces[i].kind, Weapon.MORTAR] != NO_POOL)


def _impossible(i: PieceIndex, advisor: Advisor) -> Iterator[list[str]]:
    """`[order, sentence]` of what a piece of this kind can do, but this one cannot now."""
    for order in _examples(i, advisor):
        code, why = advisor.judge(order)
        if why is not None and code not in _NEVER_ITS_OWN:
            yield [str(order), why]


def _examples(i: PieceIndex, advisor: Advisor) -> Iterator[Order]:
    """Orders that a person may want to give: one or some of each action."""
    piece, roster = advisor.roster.short(i), advisor.roster
    yield from (Stop(piece), Hide(piece), Occupy(piece), Decompress(piece))
    yield from _moves(i, advisor)
    for enemy in _enemies(advisor):
        yield from (Shoot(piece, enemy, weapon.name) for weapon in _weapons(i, advisor))
        yield from (GuideShoot(piece, enemy, chariot) for chariot in _chariots(advisor))
    if _has_mortar(i, advisor):
        yield IndirectShoot(piece, roster.cell_name(_mortar_example(i, advisor)))
    yield from (GetOn(piece, chariot) for chariot in _chariots(advisor, int(advisor.pieces[i].cell)))
    if advisor.pieces[i].passenger != NO_PIECE:
        yield GetOff(piece, roster.short(int(advisor.pieces[i].passenger)))


def _moves(i: PieceIndex, advisor: Advisor) -> list[Order]:
    """A move of one hop, if none is possible: one that is refused for more than its direction."""
    moves = [Move(advisor.roster.short(i), [direction]) for direction in DIRECTION_NAMES]
    codes = [advisor.judge(move)[0] for move in moves]
    if Code.OK in codes:
        return []
    return [next((move for move, code in zip(moves, codes, strict=True) if code != Code.NO_HOP), moves[0])]


def _enemies(advisor: Advisor) -> list[str]:
    """Enemies that are known to be somewhere."""
    indices = advisor.roster.pieces_of(enemy_of(advisor.camp))
    return [advisor.roster.names[j] for j in indices if advisor.pieces[j].blood > 0]


def _weapons(i: PieceIndex, advisor: Advisor) -> list[Weapon]:
    pools = advisor.rules.pool[advisor.pieces[i].kind]
    return [weapon for weapon in Weapon if pools[weapon] != NO_POOL and weapon != Weapon.MORTAR]


def _chariots(advisor: Advisor, cell: int | None = None) -> list[str]:
    """Own living chariots; with a cell those that are there."""
    own = [j for j in advisor.roster.pieces_of(advisor.camp) if advisor.pieces[j].blood > 0]
    return [
        advisor.roster.short(j)
        for j in own
        if advisor.pieces[j].kind == PieceType.CHARIOT and cell in (None, int(advisor.pieces[j].cell))
    ]


def _mortar_example(i: PieceIndex, advisor: Advisor) -> int:
    """A cell within reach of a mortar: what is refused there is refused everywhere."""
    here, least = CellIndex(int(advisor.pieces[i].cell)), int(advisor.rules.mortar_min_cells)
    cells = np.flatnonzero(advisor.cells.playable).tolist()
    return next(c for c in cells if int(cells_apart(advisor.cells, here, CellIndex(c))) == least)


def path_to(game: Game, camp: str, piece: str, to: int, start: int | None) -> Json:
    """The way to a cell: the answer to `path`.

    Args:
        game: as it stands.
        camp: whose piece it is.
        piece: its name.
        to: cell at the end.
        start: cell at its beginning; None: where the piece is.

    Raises:
        OrderError, UnknownNameError: no such piece or cell, or no way.
    """
    side, i = own_piece(game, camp, piece)
    row, goal = game.pieces[i], checked_cell(game, to)
    here = CellIndex(int(row.cell)) if start is None else checked_cell(game, start)
    way = find_way(i, here, goal, game.world)
    begins = game.tick if start is not None else _free_at(row, game.tick)
    ticks = (begins + np.cumsum(way.hop_ticks, dtype=int)).tolist()
    return {
        "piece": piece,
        "goal": to,
        "start": begins,
        "cells": [int(cell) for cell in way.cells],
        "ticks": ticks,
        "arrives": ticks[-1] if ticks else begins,
        "watched": list(_watched(i, way.cells, game, side)),
    }


def _free_at(row: Row, tick: int) -> int:
    """Tick at which an own piece can set out: after the hop under way, and what it is busy with."""
    if has_path(row):
        return tick if row.arrives_at == NEVER else int(row.arrives_at)
    if not is_busy(row):
        return tick
    ends = (row.hide_ends, row.board_ends, row.decompress_ends, row.stop_ends)
    return max(int(end) for end in ends if end != NEVER)


def _watched(i: PieceIndex, cells: tuple[CellIndex, ...], game: Game, camp: Camp) -> Iterator[list[object]]:
    """`[cell, enemies]`: known enemies that would see the piece in a cell of its way."""
    known, tables = remembered(camp, game.state, game.world), game.world.tables
    walker = known[i]
    walker.hidden, walker.carrier = 0, NO_PIECE
    enemies = [j for j in game.roster.pieces_of(enemy_of(camp)) if known[j].blood > 0]
    for cell in dict.fromkeys(cells):
        walker.cell = cell
        watching = [game.roster.names[j] for j in enemies if sees(known[j], walker, *tables)]
        if watching:
            yield [int(cell), watching]
