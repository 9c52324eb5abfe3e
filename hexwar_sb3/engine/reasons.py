"""Why an order was refused, as a sentence: who, what was found, what is needed.

Every number in a sentence comes from the state or the rules. The state that is passed in is the
camp's own knowledge (`known_pieces`), so a sentence tells nothing that the camp may not know.
"""

from __future__ import annotations

from dataclasses import dataclass

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.order_rows import GAP
from hexwar_sb3.engine.orders import Move, Order, verb
from hexwar_sb3.engine.pieces import (
    count_in,
    has_path,
    hop_from,
    hop_progress,
    in_fight,
    is_settled,
    on_map,
    target_class,
)
from hexwar_sb3.engine.records import BOARD_ON, NEVER, NO_PIECE
from hexwar_sb3.engine.roster import Roster
from hexwar_sb3.kernels import Row, Rows
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules.enums import Action, PieceType, Weapon

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
    Code.OUT_OF_RANGE: "{aim} is {apart} cells away from {armed}; {weapon} reaches {reach}",
    Code.LEVEL_ZERO: "{aim} stands {uphill} levels above {armed} at {apart} cells; that leaves {weapon} no attack level, it needs 1",
    Code.WRONG_TYPE: "{wrong_type}",
    Code.WRONG_PARTNER: "{partner} does not fit: {piece} can {verb} only with {partners}",
    Code.PARTNER_BUSY: "{partner} is {partner_doing}; it must be settled, free and without an order of its own",
    Code.CARRIER_FULL: "{partner} carries a soldier already; it has room for 1",
    Code.CELL_FULL: "{here} holds {crowd} ground pieces of {camp}; to set one down it may hold {crowd_limit}",
    Code.NOT_SUPPRESSED: "{piece} is not suppressed; only a suppressed piece decompresses",
    Code.TOO_LATE_TO_DECOMPRESS: "{piece} is suppressed for {keep_ticks} more s; decompressing needs more than {decompress_above_ticks}",
    Code.CONFLICT: "another piece of {camp} claimed {partner} in the same tick and goes first; one piece a tick can",
    Code.BAD_CELL: "{aim} is no cell of the map; a round needs a cell to land in",
    Code.ORDER_UNKNOWN: "{piece} got an order of an unknown kind; there are {n_actions} kinds",
    Code.POINT_CONTESTED: "{piece} found an enemy in {here} or beside it; a point is occupied only when none is there",
}
"""One sentence a code; the words in braces are properties of `Case`."""

_SPECIAL: dict[tuple[Code, Action], str] = {
    (Code.MOVING, Action.MOVE): "{piece} is on its way already; it must stop before it moves anew",
    (Code.MOVING, Action.HIDE): "{piece} is on its way; it must have arrived before it hides",
    (Code.COOLING, Action.INDIRECT_SHOOT): "the mortar of {piece} cools down for {mortar_ticks} more s; it fires only when it is cool",
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
    if code is Code.MOVING and not case.moves:  # the code says only "not settled"
        code = Code.BUSY
    return _SPECIAL.get((code, case.order.action), SENTENCES[code]).format_map(case)


@dataclass(frozen=True)
class Case:
    """The facts of one refused order, each under the name that the sentences use.

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
        return getattr(self, name)

    # --- the piece -------------------------------------------------------------------------------

    @property
    def me(self) -> Row:
        return self.pieces[self.i]

    @property
    def piece(self) -> str:
        return self.roster.spoken(self.i)

    @property
    def camp(self) -> str:
        return self.piece.split()[0]

    @property
    def kind(self) -> str:
        return kind_name(self.me.kind)

    @property
    def here(self) -> str:
        return self.roster.cell_name(self.me.cell)

    @property
    def carrier(self) -> str:
        return self.roster.spoken(self.me.carrier)

    @property
    def moves(self) -> bool:
        return bool(has_path(self.me)) or self.me.stop_ends != NEVER

    @property
    def doing(self) -> str:
        return doing(self.me)

    @property
    def verb(self) -> str:
        return verb(self.order.action)

    @property
    def does(self) -> str:
        return _DOES[self.order.action]

    # --- its clocks, ticks -----------------------------------------------------------------------

    @property
    def tick(self) -> int:
        return int(self.game.tick)

    def _left(self, ends: int) -> int:
        return int(ends) - self.tick

    @property
    def busy_ticks(self) -> int:
        me = self.me
        ends = (me.hide_ends, me.board_ends, me.decompress_ends, me.stop_ends)
        return self._left(max(end for end in map(int, ends) if end != NEVER))

    @property
    def keep_ticks(self) -> int:
        return self._left(self.me.keep_ends)

    @property
    def cool_ticks(self) -> int:
        return self._left(self.me.cool_ends)

    @property
    def mortar_ticks(self) -> int:
        return self._left(self.me.mortar_ends)

    @property
    def stop_ticks(self) -> int:
        return int(self.rules.stop_ticks)

    @property
    def decompress_above_ticks(self) -> int:
        return int(self.rules.decompress_above_ticks)

    @property
    def hop_done(self) -> int:
        return int(hop_progress(self.me, self.tick))

    @property
    def hop_need(self) -> int:
        return int(self.me.hop_need)

    # --- its path --------------------------------------------------------------------------------

    @property
    def path_cells(self) -> int:
        return len(self.order.path) if isinstance(self.order, Move) else 0

    @property
    def path_limit(self) -> int:
        return int(self.rules.path_limit)

    @property
    def _bad_hop(self) -> tuple[str, str]:
        return bad_hop(self)

    @property
    def hop_from(self) -> str:
        return self._bad_hop[0]

    @property
    def hop_to(self) -> str:
        return self._bad_hop[1]

    # --- fire ------------------------------------------------------------------------------------

    @property
    def target(self) -> str:
        return self.roster.spoken(self.row.target)

    @property
    def weapon(self) -> str:
        return Weapon(self.row.weapon).name

    @property
    def weapons(self) -> str:
        pools = self.rules.pool[self.me.kind]
        return ", ".join(weapon.name for weapon in Weapon if pools[weapon] >= 0)

    @property
    def _shooter(self) -> int:
        return int(self.row.partner) if self.order.action == Action.GUIDE_SHOOT else self.i

    @property
    def armed(self) -> str:
        return self.roster.spoken(self._shooter)

    @property
    def _aim_cell(self) -> int:
        by_cell = self.order.action == Action.INDIRECT_SHOOT
        return int(self.row.cell if by_cell else self.pieces[self.row.target].cell)

    @property
    def aim(self) -> str:
        if self.order.action == Action.INDIRECT_SHOOT:
            return self.roster.cell_name(self._aim_cell)
        return self.target

    @property
    def apart(self) -> int:
        return int(cells_apart(self.cells, self.pieces[self._shooter].cell, self._aim_cell))

    @property
    def uphill(self) -> int:
        levels = self.cells.level
        return int(levels[self._aim_cell]) - int(levels[self.pieces[self._shooter].cell])

    @property
    def reach(self) -> str:
        rules = self.rules
        if self.order.action == Action.INDIRECT_SHOOT:
            return f"{rules.mortar_min_cells} to {rules.mortar_max_cells}"
        return reach_of(self.row.weapon, self.pieces[self._shooter], self.pieces[self.row.target], rules)

    # --- partners --------------------------------------------------------------------------------

    @property
    def _partner(self) -> int:
        return int(self.row.partner if self.order.action == Action.GUIDE_SHOOT else self.row.target)

    @property
    def partner(self) -> str:
        return self.roster.spoken(self._partner)

    @property
    def partner_doing(self) -> str:
        return partner_doing(self.pieces[self._partner], self.game)

    @property
    def partners(self) -> str:
        if self.order.action == Action.GET_OFF:
            return self._name_or(self.me.passenger, "its passenger; it carries none")
        if self.order.action == Action.GET_ON:
            return f"a chariot of {self.camp} in its own cell"
        if self.me.kind == PieceType.SOLDIER:
            return self._name_or(self.me.home, "its own chariot; it has none")
        return f"a chariot of {self.camp}"

    def _name_or(self, i: int, nobody: str) -> str:
        return nobody if i == NO_PIECE else self.roster.spoken(i)

    @property
    def wrong_type(self) -> str:
        is_guider = self.me.kind in {PieceType.SOLDIER, PieceType.AEROCRAFT}
        if self.order.action == Action.GUIDE_SHOOT and is_guider:
            kind = kind_name(self.pieces[self.row.target].kind)
            return f"{self.target} is a {kind}; a guided missile needs a tank or chariot as target"
        return f"{self.piece} is a {self.kind}; {_ACTORS[self.order.action]}"

    @property
    def crowd(self) -> int:
        return int(count_in(self.pieces, self.me.camp, self.me.cell))

    @property
    def crowd_limit(self) -> str:
        return f"at most {int(self.rules.stack_limit) - 1}"

    @property
    def n_actions(self) -> int:
        return len(Action)


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
    if has_path(piece):
        return "moving"
    return "stopping" if piece.stop_ends != NEVER else "settled"


def partner_doing(piece: Row, game: Row) -> str:
    """What keeps a partner from taking part, as a piece of a sentence."""
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


def reach_of(weapon: int, shooter: Row, target: Row, rules: Row) -> str:
    """Distances at which a weapon has an attack level: "0 to 18"."""
    levels = rules.level[weapon, target_class(target.kind), int(shooter.blood)]
    reached = [apart for apart, level in enumerate(levels) if level > 0]
    return f"{reached[0]} to {reached[-1]} cells" if reached else "no target of this type"


def bad_hop(case: Case) -> tuple[str, str]:
    """First hop of a path that is not possible, or the first of all, as two names."""
    here, steps = int(case.me.cell), case.order.path if isinstance(case.order, Move) else ()
    for k, step in enumerate(steps):
        direction = int(case.row.path[k])
        if direction == GAP or not hop_from(case.me.kind, here, direction, case.rules, case.cells):
            return case.roster.cell_name(here), step
        here = int(case.cells[here].neighbour[direction])
    return case.here, steps[0]
