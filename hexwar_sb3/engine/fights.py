"""Close combat: ground pieces of both camps in one cell (rule book, section 10)."""

from __future__ import annotations

from hexwar_sb3.engine.codes import Event
from hexwar_sb3.engine.dice import throw
from hexwar_sb3.engine.events import note
from hexwar_sb3.engine.fire import attack_level, resolve_shot
from hexwar_sb3.engine.pieces import (
    cancel_transitions,
    clear_path,
    count_in,
    has_path,
    stands_in,
    weapon_ammo,
)
from hexwar_sb3.engine.records import NEVER, NO_CELL, NO_PIECE, GameRecord, Log, Orders, PieceRecord, Pieces
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import Action, Camp, Dice, PieceType
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, piece_range


@kernel
def fights_in(piece: PieceRecord, cell: CellIndex) -> bool:
    """Takes part in the exchanges of a cell: stands there and is not on its way out."""
    return stands_in(piece, cell) and not has_path(piece)


@kernel
def best_close_weapon(shooter: PieceRecord, target: PieceRecord, rules: RulesRecord, cells: Cells) -> int:
    """Weapon of the highest level at no distance with a round left; -1: none."""
    best = -1
    best_level = 0
    for weapon in range(rules.level.shape[0]):
        if weapon_ammo(shooter, weapon, rules) == 0:
            continue
        level = attack_level(weapon, shooter, target, rules, cells)
        if level > best_level:
            best = weapon
            best_level = level
    return best


@kernel
def _goes_first(a: PieceIndex, b: PieceIndex, shooter: PieceRecord, game: GameRecord, pieces: Pieces) -> bool:
    """Is target a preferred to b: tank, chariot, soldier; then least blood; then the dice?"""
    if pieces[a].kind != pieces[b].kind:
        return pieces[a].kind < pieces[b].kind
    if pieces[a].blood != pieces[b].blood:
        return pieces[a].blood < pieces[b].blood
    dice_a = throw(game, game.tick, Dice.CLOSE_TIE, shooter, pieces[a], 0)
    dice_b = throw(game, game.tick, Dice.CLOSE_TIE, shooter, pieces[b], 0)
    return bool(dice_a < dice_b)


@kernel
def close_target(
    i: PieceIndex, cell: CellIndex, game: GameRecord, pieces: Pieces, rules: RulesRecord, cells: Cells
) -> PieceIndex:
    """Whom piece i fires at in the exchange; NO_PIECE where it can hurt nobody."""
    best = NO_PIECE
    for j in piece_range(pieces.size):
        if pieces[j].camp == pieces[i].camp or not fights_in(pieces[j], cell):
            continue
        if best_close_weapon(pieces[i], pieces[j], rules, cells) < 0:
            continue
        if best == NO_PIECE or _goes_first(j, best, pieces[i], game, pieces):
            best = j
    return best


@kernel
def fire_exchanges(game: GameRecord, pieces: Pieces, log: Log, rules: RulesRecord, cells: Cells) -> None:
    """Exchanges due in this step: everybody in the cell fires, from the same state."""
    for f in range(game.n_fights):
        if game.fight_cell[f] == NO_CELL or game.fight_next[f] > game.tick:
            continue
        cell = game.fight_cell[f]
        for i in piece_range(pieces.size):
            if fights_in(pieces[i], cell):
                t = close_target(i, cell, game, pieces, rules, cells)
                if t != NO_PIECE:
                    weapon = best_close_weapon(pieces[i], pieces[t], rules, cells)
                    resolve_shot(Event.CLOSE_SHOT, i, i, t, weapon, False, game, pieces, log, rules, cells)
                    pieces[i].spent_now[rules.pool[pieces[i].kind, weapon]] += 1
        game.fight_next[f] = game.tick + rules.fight_ticks


@kernel
def fire_exit_shots(
    game: GameRecord, pieces: Pieces, orders: Orders, log: Log, rules: RulesRecord, cells: Cells
) -> None:
    """Every enemy in the cell fires once at a piece that leaves a close combat."""
    for i in piece_range(pieces.size):
        if orders[i].kind != Action.MOVE or orders[i].code != 0:
            continue
        cell = pieces[i].cell
        if (
            pieces[i].kind == PieceType.AEROCRAFT
            or count_in(pieces, CampIndex(1 - pieces[i].camp), cell) == 0
        ):
            continue
        for j in piece_range(pieces.size):
            if pieces[j].camp == pieces[i].camp or not fights_in(pieces[j], cell):
                continue
            weapon = best_close_weapon(pieces[j], pieces[i], rules, cells)
            if weapon >= 0:
                resolve_shot(Event.EXIT_SHOT, j, j, i, weapon, True, game, pieces, log, rules, cells)
                pieces[j].spent_now[rules.pool[pieces[j].kind, weapon]] += 1


@kernel
def spend_close_rounds(pieces: Pieces) -> None:
    """Ammunition and cover that the exchanges and exit shots of this step cost."""
    for i in piece_range(pieces.size):
        piece = pieces[i]
        for pool in range(piece.spent_now.size):
            if piece.spent_now[pool] > 0:
                piece.ammo[pool] -= min(piece.ammo[pool], piece.spent_now[pool])
                piece.spent_now[pool] = 0
                piece.hidden = 0


@kernel
def open_fights(game: GameRecord, pieces: Pieces, log: Log) -> None:
    """First contact: start the clock of the cell, stop everybody in it."""
    for i in piece_range(pieces.size):
        cell = pieces[i].cell
        if (
            pieces[i].camp != Camp.RED
            or not stands_in(pieces[i], cell)
            or count_in(pieces, Camp.BLUE, cell) == 0
        ):
            continue
        if _fight_at(cell, game) < 0:
            f = _free_row(game)
            game.n_fights = max(game.n_fights, f + 1)
            game.fight_cell[f] = cell
            game.fight_next[f] = game.tick + 1
            _halt_all(cell, pieces)
            note(game, log, Event.FIRST_CONTACT, i, NO_PIECE, cell, 0)


@kernel
def _fight_at(cell: CellIndex, game: GameRecord) -> int:
    for f in range(game.n_fights):
        if game.fight_cell[f] == cell:
            return f
    return -1


@kernel
def _free_row(game: GameRecord) -> int:
    free = _fight_at(NO_CELL, game)
    return int(game.n_fights) if free < 0 else free


@kernel
def _halt_all(cell: CellIndex, pieces: Pieces) -> None:
    for i in piece_range(pieces.size):
        if not stands_in(pieces[i], cell):
            continue
        clear_path(pieces[i])
        pieces[i].stop_ends = NEVER
        pieces[i].stop_forced = 0
        cancel_transitions(i, pieces)
        pieces[i].changed_now = 1


@kernel
def close_fights(game: GameRecord, pieces: Pieces) -> None:
    """End the close combats of cells that no longer hold both camps."""
    for f in range(game.n_fights):
        cell = game.fight_cell[f]
        if cell == NO_CELL:
            continue
        if count_in(pieces, Camp.RED, cell) == 0 or count_in(pieces, Camp.BLUE, cell) == 0:
            game.fight_cell[f] = NO_CELL
            game.fight_next[f] = NEVER
    while game.n_fights > 0 and game.fight_cell[game.n_fights - 1] == NO_CELL:
        game.n_fights -= 1
