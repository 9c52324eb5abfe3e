"""The family "drawn-unseen": squads that follow a timetable; it weighs nothing, and only measures."""

from __future__ import annotations

from hexwar_sb3.bots.drawn_records import STAGES
from hexwar_sb3.bots.duties import recovers, takes_orders
from hexwar_sb3.bots.missions import attack, board, give_mission
from hexwar_sb3.bots.records import AtlasRecord, BrainRecord
from hexwar_sb3.bots.registry import Duty, Event
from hexwar_sb3.bots.weigh import renew_trust
from hexwar_sb3.engine.pieces import on_map
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE, GameRecord, Memory, Pieces
from hexwar_sb3.kernels import kernel
from hexwar_sb3.maps.cells import Cells
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.compiled import RulesRecord
from hexwar_sb3.rules.enums import PieceType
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, PointIndex, SlotIndex, piece_range
from hexwar_sb3.tasks.known import can_hurt, end_piece, first_piece, is_known
from hexwar_sb3.tasks.records import Missions, TaskKind

RIDE_CELLS = 6  # a soldier boards for a way that is longer
MOST_VALUE_APART = 1000.0  # cells that a point of value weighs as much as, for those who pick their prey


@kernel
def think_unseen(
    camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions, brain: BrainRecord, rules: RulesRecord, cells: Cells,
    atlas: AtlasRecord,
) -> None:  # fmt: skip
    """One thought of a member of "drawn-unseen": turn pages, then give every piece what its page says."""
    renew_trust(camp, game, memory, brain, atlas.config)
    for s in range(brain.stage.size):
        turn_page(s, camp, game, brain, atlas)
    first = first_piece(camp, game)
    for i in piece_range(first, end_piece(camp, game)):
        if takes_orders(pieces[i], game):
            follow(i, SlotIndex(i - first), camp, game, pieces, memory, missions, brain, rules, cells, atlas)
            missions[i].hold_fire = game.tick < brain.drawn.quiet and missions[i].kind != TaskKind.ATTACK


@kernel
def turn_page(s: int, camp: CampIndex, game: GameRecord, brain: BrainRecord, atlas: AtlasRecord) -> None:
    """Begin the next stage of a squad's timetable, if this one is over."""
    drawn, n = brain.drawn, int(brain.stage[s])
    if n == STAGES - 1 or game.tick < drawn.start[s]:
        return
    event, since = drawn.ends_by[s, n], int(brain.since[s])
    over = game.tick >= drawn.until[s, n]
    if event == Event.TAKEN:
        over = over or game.point_owner[atlas.rank[drawn.where[s, n]]] == camp
    elif event == Event.CONTACT:
        over = over or game.contact_tick[camp] > since
    elif event == Event.LOSS:
        over = over or game.loss_tick[camp] > since
    if over:
        brain.stage[s] = n + 1
        brain.since[s] = game.tick


@kernel
def follow(
    i: PieceIndex, slot: SlotIndex, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, missions: Missions, brain: BrainRecord, rules: RulesRecord,
    cells: Cells, atlas: AtlasRecord,
) -> None:  # fmt: skip
    """Give piece i the task of its squad's stage."""
    drawn, piece = brain.drawn, pieces[i]
    style, s = drawn.style, int(drawn.squad[slot])
    n = int(brain.stage[s])
    duty = int(drawn.what[s, n])
    if game.tick < drawn.start[s]:
        duty = int(Duty.WAIT)
    if recovers(i, camp, game, pieces, memory, brain, rules, cells):
        give_mission(style, i, TaskKind.RECOVER, NO_CELL, game, missions)
        return
    if duty == Duty.CHASE or duty == Duty.PICK or duty == Duty.SHADOW:
        prey = known_prey(i, duty == Duty.PICK, camp, game, pieces, memory, brain, rules, cells)
        if prey != NO_PIECE:
            shadows = duty == Duty.SHADOW and piece.kind != PieceType.AEROCRAFT
            attack(style, i, TaskKind.SHADOW if shadows else TaskKind.ATTACK, prey, game, missions)
            return
    cell = place(duty, slot, camp, game, pieces, brain, cells, atlas)
    if cell == NO_CELL:
        cell = CellIndex(piece.cell)
    if rides(i, cell, pieces, brain, cells):
        board(style, i, PieceIndex(piece.home), game, missions)
    elif piece.passenger != NO_PIECE and piece.cell == cell:
        give_mission(style, i, TaskKind.DROP, cell, game, missions)
    else:
        hides = duty == Duty.KEEP or duty == Duty.AMBUSH or duty == Duty.WAIT
        hides = hides and piece.kind != PieceType.AEROCRAFT
        give_mission(style, i, TaskKind.HIDE if hides else TaskKind.HOLD, cell, game, missions)


@kernel
def place(
    duty: int,
    slot: SlotIndex,
    camp: CampIndex,
    game: GameRecord,
    pieces: Pieces,
    brain: BrainRecord,
    cells: Cells,
    atlas: AtlasRecord,
) -> CellIndex:
    """Cell of a duty that is none of attack; NO_CELL: where the piece is."""
    drawn = brain.drawn
    s = int(drawn.squad[slot])
    k = PointIndex(atlas.rank[drawn.where[s, int(brain.stage[s])]])
    if duty == Duty.WAIT or game.n_points == 0:
        return NO_CELL
    if duty == Duty.RAID:
        home = CellIndex(atlas.home[CampIndex(1 - camp)])
        return home if cells[home].passable else NO_CELL
    if duty == Duty.ESCORT:
        for i in piece_range(first_piece(camp, game), end_piece(camp, game)):
            if on_map(pieces[i]) and pieces[i].kind <= PieceType.CHARIOT:
                return CellIndex(pieces[i].cell)
        return NO_CELL
    if duty == Duty.AMBUSH:
        post = int(drawn.post[slot])
        return CellIndex(atlas.post[camp, k, post // atlas.post.shape[3], post % atlas.post.shape[3]])
    return CellIndex(game.point_cell[k])


@kernel
def rides(i: PieceIndex, cell: CellIndex, pieces: Pieces, brain: BrainRecord, cells: Cells) -> bool:
    """A soldier with a long way to go, whose free chariot stands beside it, and who is one that rides."""
    soldier = pieces[i]
    if brain.drawn.rides == 0 or soldier.kind != PieceType.SOLDIER or soldier.home < 0 or soldier.sees != 0:
        return False
    chariot = pieces[soldier.home]
    free = on_map(chariot) and chariot.passenger == NO_PIECE and not chariot.suppressed
    return free and chariot.cell == soldier.cell and cells_apart(cells, soldier.cell, cell) > RIDE_CELLS


@kernel
def known_prey(
    i: PieceIndex, picks: bool, camp: CampIndex, game: GameRecord, pieces: Pieces, memory: Memory, brain: BrainRecord, rules: RulesRecord, cells: Cells
) -> PieceIndex:  # fmt: skip
    """Known enemy that piece i can hurt: the nearest, or the one that is worth most; NO_PIECE."""
    best, prey = -1e9, NO_PIECE
    for j in piece_range(first_piece(CampIndex(1 - camp), game), end_piece(CampIndex(1 - camp), game)):
        known = memory[camp, j]
        if not is_known(known) or brain.trust[j] <= 0.0 or not can_hurt(pieces[i], pieces[j].kind, rules):
            continue
        score = -float(cells_apart(cells, pieces[i].cell, known.cell))
        if picks:
            score += MOST_VALUE_APART * rules.value[pieces[j].kind]
        if score > best:
            best, prey = score, j
    return prey
