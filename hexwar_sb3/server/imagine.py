"""A state as a camp may think of it: a piece of its own in another cell, enemies where they were last seen."""

from __future__ import annotations

from hexwar_sb3.engine.legal import Advisor, known_pieces
from hexwar_sb3.engine.pieces import clear_boarding, clear_path
from hexwar_sb3.engine.records import NEVER, NO_CELL, NO_PIECE
from hexwar_sb3.engine.roster import enemy_of
from hexwar_sb3.engine.sight import look
from hexwar_sb3.engine.state import State
from hexwar_sb3.engine.world import World
from hexwar_sb3.kernels import Row, Rows
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.rules.indices import CellIndex, PieceIndex

_TIMERS = ("stop_ends", "hide_ends", "decompress_ends", "cool_ends", "mortar_ends", "keep_ends")


def remembered(camp: Camp, state: State, world: World) -> Rows:
    """The pieces [P] as the camp knows them: enemies that it does not see stand where it saw them last.

    Of those it knows cell, blood, and how they were; nothing else of their records is left.
    """
    _, pieces, memory, *_ = state.game(0)
    known = known_pieces(camp, pieces, memory)
    enemies = world.side(enemy_of(camp))
    for j in range(enemies.start, enemies.stop):
        fact = memory[camp, j]
        if not fact.seen and fact.cell != NO_CELL:
            _free(known[j])
            known[j].cell, known[j].blood = fact.cell, fact.blood
            known[j].hidden, known[j].suppressed = fact.hidden, fact.suppressed
    return known


def imagined(i: PieceIndex, cell: CellIndex, camp: Camp, state: State, world: World) -> Advisor:
    """Who judges orders of an own piece as if it stood in a cell, free and cool."""
    known = remembered(camp, state, world)
    _free(known[i])
    known[i].cell = cell
    for j in range(known.size):
        if known[j].camp != camp:
            look(i, PieceIndex(j), known, *world.tables)
    memory = state.memory[0].copy()
    memory.seen[camp] |= (known.blood > 0) & (memory.cell[camp] != NO_CELL)
    return Advisor(camp, state.games[0], known, memory, world)


def _free(piece: Row) -> None:
    """Let a piece stand, with nothing under way, off every carrier."""
    clear_path(piece)
    clear_boarding(piece)
    for timer in _TIMERS:
        piece[timer] = NEVER
    piece.carrier = NO_PIECE
    piece.suppressed = piece.hidden = piece.stop_forced = 0
