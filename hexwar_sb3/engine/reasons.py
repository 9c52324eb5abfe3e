"""Why an order was refused, as a sentence: who, what was found, what is needed.

Every number in a sentence comes from the state or the rules. The state that is passed in is the
camp's own knowledge (`known_pieces`), so a sentence tells nothing that the camp may not know.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.order_rows import GAP
from hexwar_sb3.engine.orders import Order, verb
from hexwar_sb3.engine.pieces import (
    count_in,
    hop_from,
    hop_progress,
    in_fight,
    in_motion,
    is_settled,
    on_map,
    target_class,
)
from hexwar_sb3.engine.records import BOARD_ON, NEVER, NO_PIECE
from hexwar_sb3.engine.roster import Roster, camp_name
from hexwar_sb3.kernels import Row, Rows
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.compiled import NO_POOL
from hexwar_sb3.rules.enums import Action, PieceType, Weapon
from hexwar_sb3.rules.indices import CellIndex

SENTENCES: dict[Code, str] = {
    Code.GAME_OVER: "the game is over since tick {tick}; no order is taken any more",
    Code.DEAD: "{piece} is destroyed; only a living piece takes orders",
    Code.ABOARD: "{piece} is aboard {carrier}; it takes orders again when it has got off",
    Code.BUSY: "{piece} is {doing} for {busy_ticks} more s; until then it can only occupy",
    Code.MOVING: "{piece} is {doing}; it must stand for {stop_ticks} s before it {does}",
    Code.SUPPRESSED: "{piece} is suppressed for {keep_ticks} more s; it must be free before it {does}",
    Code.CLOSE_COMBAT: "{piece} is in close combat; it can only move out to a cell free of enemies",
    Code.EMPTY_PATH: "{piece} got a path of 0 cells; a move needs at least 1",
    Code.PATH_TOO_LONG: "{piece} got a path of {path_cells} cells; a move has at most {path_limit}",
    Code.NO_HOP: "{piece} cannot go from {hop_from} to {hop_to}; each hop must lead to a neighbour that a {kind} can enter",
    Code.EXIT_BLOCKED: "{piece} is in close combat and {hop_to} holds an enemy; it must leave to a cell free of enemies",
    Code.NO_PATH: "{piece} has no path; only a moving piece can stop",
    Code.NOT_GROUND: "{piece} is an aerocraft; only a ground piece {does}",
    Code.ALREADY_HIDDEN: "{piece} is hidden already; only an unhidden piece hides",
    Code.NOT_CONTROL_POINT: "{piece} stands in {here}, which is no control point; it must stand in one to occupy it",
    Code.OWN_POINT: "{piece} stands in {here}, which {camp} holds already; only a point of another camp can be occupied",
    Code.BETWEEN_CELLS: "{piece} has done {hop_done} of {hop_need} s of its hop; it must be in the middle of a cell to {verb}",
    Code.NO_AMMO: "{armed} has 0 rounds for {weapon}; it needs 1",
    Code.NOT_ARMED: "{piece} is a {kind} and carries no {weapon}; it has {weapons}",
    Code.COOLING: "{piece} cools down for {cool_ticks} more s; it {does} only when it is cool",
    Code.TARGET_GONE: "{target} is not in sight of {piece}; a target must be alive and seen by {piece} itself",
    Code.NOT_ENEMY: "{target} is of the same camp as {piece}; a target must be an enemy",
    Code.TARGET_IN_FIGHT: "{target} is in close combat; nobody outside may fire at it directly",
    Code.OUT_OF_RANGE: "{aim} is at distance {apart} from {armed}; {weapon} reaches {reach}",
    Code.LEVEL_ZERO: "{aim} stands {uphill} levels above {armed} at {apart} cells; that leaves {weapon} no attack level, it needs 1",
    Code.WRONG_TYPE: "{wrong_type}",
    Code.WRONG_PARTNER: "{partner} does not fit: {piece} can {verb} only with {partners}",
    Code.PARTNER_BUSY: "{partner} is {partner_doing}; it must be settled, free and without an order of its own",
    Code.CARRIER_FULL: "{partner} carries a soldier already; it has room for 1",
    Code.CELL_FULL: "{here} holds {crowd} ground pieces of {camp}; to set one down it may hold at most {crowd_limit}",
    Code.NOT_SUPPRESSED: "{piece} is not suppressed; only a suppressed piece decompresses",
    Code.TOO_LATE_TO_DECOMPRESS: "{piece} is suppressed for {keep_ticks} more s; decompressing needs more than {decompress_above_ticks}",
    Code.CONFLICT: "another piece of {camp} claimed {partner} in the same tick and goes first; one piece a tick can",
    Code.BAD_CELL: "{aim} is no cell of the map; a round needs a cell to land in",
    Code.ORDER_UNKNOWN: "{piece} got an order of an unknown kind; there are {n_actions} kinds",
    Code.POINT_CONTESTED: "{piece} found an enemy in {here} or beside it; a point is occupied only when none is there",
}
"""One sentence a code; the words in braces are `_FACTS`."""

_SPECIAL: dict[tuple[Code, Action], str] = {
    (Code.MOVING, Action.MOVE): "{piece} is on its way already; it must stop before it moves anew",
    (Code.MOVING, Action.HIDE): "{piece} is on its way; it must have arrived before it hides",
    (
        Code.COOLING,
        Action.INDIRECT_SHOOT,
    ): "the mortar of {piece} cools down for {mortar_ticks} more s; it fires only when it is cool",
}

_DOES = {
    Action.MOVE: "moves",
    Action.HIDE: "hides",
    Action.OCCUPY: "occupies",
    Action.SHOOT: "shoots",
    Action.GUIDE_SHOOT: "guides",
    Action.INDIRECT_SHOOT: "fires its mortar",
    Action.GET_ON: "gets on",
    Action.GET_OFF: "lets its passenger off",
    Action.DECOMPRESS: "decompresses",
}

_ACTORS = {
    Action.GUIDE_SHOOT: "only a soldier or an aerocraft guides",
    Action.INDIRECT_SHOOT: "only a chariot has a mortar",
    Action.GET_ON: "only a soldier gets on",
    Action.GET_OFF: "only a chariot lets somebody off",
}


def explain(case: Case) -> str:
    """Sentence for a refused order."""
    code = Code(int(case.row.code))
    if code is Code.MOVING and not in_motion(case.me):  # the code says only "not settled"
        code = Code.BUSY
    return _SPECIAL.get((code, case.order.action), SENTENCES[code]).format_map(case)


@dataclass(frozen=True)
class Case:
    """One refused order; `case["piece"]` is the fact that the sentences call {piece}.

    order, row: the order in words and as a record with its code; i: the piece;
    game, pieces: the state as the camp knows it.
    """

    order: Order
    i: int
    row: Row
    game: Row
    pieces: Rows
    roster: Roster
    rules: Row
    cells: Rows

    def __getitem__(self, name: str) -> object:
        return _FACTS[name](self)

    @property
    def me(self) -> Row:
        """The piece that got the order."""
        return self.pieces[self.i]

    @property
    def shooter(self) -> int:
        """The piece whose weapon fires."""
        return int(self.row.partner) if self.order.action == Action.GUIDE_SHOOT else self.i

    @property
    def partner(self) -> int:
        """The other own piece that the order needs."""
        return int(self.row.partner if self.order.action == Action.GUIDE_SHOOT else self.row.target)

    @property
    def aim_cell(self) -> CellIndex:
        """The cell that is fired at."""
        by_cell = self.order.action == Action.INDIRECT_SHOOT
        return CellIndex(self.row.cell if by_cell else self.pieces[self.row.target].cell)

    def left(self, ends: int) -> int:
        """Ticks until an end tick."""
        return int(ends) - int(self.game.tick)

    def spoken(self, i: int) -> str:
        """Name of a piece in a sentence."""
        return self.roster.spoken(i)


def kind_name(kind: int) -> str:
    """Type of a piece in a sentence: "tank"."""
    return PieceType(int(kind)).name.lower()


def doing(piece: Row) -> str:
    """What keeps a piece from being settled, in one word."""
    if piece.hide_ends != NEVER:
        return "hiding"
    if piece.board_ends != NEVER:
        return "getting on" if piece.board_kind == BOARD_ON else "getting off"
    if piece.decompress_ends != NEVER:
        return "decompressing"
    if piece.path_pos < piece.path_len:
        return "moving"
    return "stopping" if piece.stop_ends != NEVER else "settled"


def busy_ticks(case: Case) -> int:
    """Ticks until the longest of the piece's transitions ends."""
    me = case.me
    ends = (me.hide_ends, me.board_ends, me.decompress_ends, me.stop_ends)
    return max(case.left(end) for end in ends if end != NEVER)


def partner_doing(piece: Row, game: Row) -> str:
    """What keeps a partner from taking part."""
    if piece.blood == 0:
        return "destroyed"
    if not on_map(piece):
        return "aboard"
    if in_fight(game, piece):
        return "in close combat"
    if piece.suppressed:
        return "suppressed"
    if not is_settled(piece):
        return doing(piece)
    return "cooling down" if piece.cool_ends != NEVER else "under orders"


def weapons(piece: Row, rules: Row) -> str:
    """The weapons that a piece carries."""
    return ", ".join(weapon.name for weapon in Weapon if rules.pool[piece.kind, weapon] != NO_POOL)


def aim(case: Case) -> str:
    """What is fired at: a piece, or a cell."""
    if case.order.action == Action.INDIRECT_SHOOT:
        return case.roster.cell_name(case.aim_cell)
    return case.spoken(case.row.target)


def uphill(case: Case) -> int:
    """Levels that the target stands above the shooter."""
    levels = case.cells.level
    return int(levels[case.aim_cell]) - int(levels[case.pieces[case.shooter].cell])


def reach(case: Case) -> str:
    """Distances at which the weapon has an attack level: "0 to 18 cells"."""
    rules = case.rules
    if case.order.action == Action.INDIRECT_SHOOT:
        return f"{rules.mortar_min_cells} to {rules.mortar_max_cells} cells"
    shooter, target = case.pieces[case.shooter], case.pieces[case.row.target]
    levels = rules.level[case.row.weapon, target_class(target.kind), int(shooter.blood)]
    reached = [apart for apart, level in enumerate(levels) if level > 0]
    return f"{reached[0]} to {reached[-1]} cells" if reached else f"no {kind_name(target.kind)}"


def partners(case: Case) -> str:
    """Who could be the partner that the order needs."""
    if case.order.action == Action.GET_OFF:
        return _named(case, case.me.passenger, "its passenger, and it carries none")
    if case.order.action == Action.GET_ON:
        return f"a chariot of {camp_name(case.me.camp)} in its own cell"
    if case.me.kind == PieceType.SOLDIER:
        return _named(case, case.me.home, "its own chariot, and it has none")
    return f"a chariot of {camp_name(case.me.camp)}"


def _named(case: Case, i: int, nobody: str) -> str:
    return nobody if i == NO_PIECE else case.spoken(i)


def wrong_type(case: Case) -> str:
    """Who acts, or is aimed at, and is of a type that cannot."""
    is_guider = case.me.kind in {PieceType.SOLDIER, PieceType.AEROCRAFT}
    if case.order.action == Action.GUIDE_SHOOT and is_guider:
        target = f"{case.spoken(case.row.target)} is a {kind_name(case.pieces[case.row.target].kind)}"
        return f"{target}; a guided missile needs a tank or chariot as target"
    return f"{case.spoken(case.i)} is a {kind_name(case.me.kind)}; {_ACTORS[case.order.action]}"


def bad_hop(case: Case) -> tuple[str, str]:
    """First hop of a path that is not possible, or the first of all, as two names."""
    here, steps = CellIndex(case.me.cell), case.order.words()
    for k, step in enumerate(steps):
        direction = int(case.row.path[k])
        if direction == GAP or not hop_from(case.me.kind, here, direction, case.rules, case.cells):
            return case.roster.cell_name(here), step
        here = CellIndex(case.cells[here].neighbour[direction])
    return case.roster.cell_name(case.me.cell), steps[0]


_FACTS: dict[str, Callable[[Case], object]] = {
    "tick": lambda case: int(case.game.tick),
    "piece": lambda case: case.spoken(case.i),
    "camp": lambda case: camp_name(case.me.camp),
    "kind": lambda case: kind_name(case.me.kind),
    "here": lambda case: case.roster.cell_name(case.me.cell),
    "carrier": lambda case: case.spoken(case.me.carrier),
    "doing": lambda case: doing(case.me),
    "verb": lambda case: verb(case.order.action),
    "does": lambda case: _DOES[case.order.action],
    "busy_ticks": busy_ticks,
    "keep_ticks": lambda case: case.left(case.me.keep_ends),
    "cool_ticks": lambda case: case.left(case.me.cool_ends),
    "mortar_ticks": lambda case: case.left(case.me.mortar_ends),
    "stop_ticks": lambda case: case.rules.stop_ticks,
    "decompress_above_ticks": lambda case: case.rules.decompress_above_ticks,
    "hop_done": lambda case: int(hop_progress(case.me, case.game.tick)),
    "hop_need": lambda case: case.me.hop_need,
    "hop_from": lambda case: bad_hop(case)[0],
    "hop_to": lambda case: bad_hop(case)[1],
    "path_cells": lambda case: len(case.order.words()),
    "path_limit": lambda case: case.rules.path_limit,
    "target": lambda case: case.spoken(case.row.target),
    "weapon": lambda case: Weapon(case.row.weapon).name,
    "weapons": lambda case: weapons(case.me, case.rules),
    "armed": lambda case: case.spoken(case.shooter),
    "aim": aim,
    "apart": lambda case: int(cells_apart(case.cells, case.pieces[case.shooter].cell, case.aim_cell)),
    "uphill": uphill,
    "reach": reach,
    "partner": lambda case: case.spoken(case.partner),
    "partner_doing": lambda case: partner_doing(case.pieces[case.partner], case.game),
    "partners": partners,
    "wrong_type": wrong_type,
    "crowd": lambda case: int(count_in(case.pieces, case.me.camp, case.me.cell)),
    "crowd_limit": lambda case: case.rules.stack_limit - 1,
    "n_actions": lambda _: len(Action),
}
"""What the words in braces of the sentences stand for."""
