"""Whether missions, brains and drives that come from a file belong to the games beside them."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.bots.config import CONFIG, STYLE
from hexwar_sb3.bots.draw import draw_player
from hexwar_sb3.bots.drawn_records import CHARACTER
from hexwar_sb3.bots.records import BrainRecord
from hexwar_sb3.bots.registry import BOTS, FAMILIES
from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.fields import Bounds, check_all, check_range, check_rows, refuse
from hexwar_sb3.engine.legality import order_code
from hexwar_sb3.engine.records import MAX_SIDE, NEVER, NO_CELL, NO_PIECE
from hexwar_sb3.engine.sound import bounds_of
from hexwar_sb3.engine.state import State
from hexwar_sb3.engine.world import World
from hexwar_sb3.kernels import Rows
from hexwar_sb3.play.fingerprint import fingerprint
from hexwar_sb3.play.lower import HEURISTIC
from hexwar_sb3.play.records import EXTERNAL, DriveRecord
from hexwar_sb3.records import fields_of
from hexwar_sb3.rules.enums import Action, Camp, PieceType
from hexwar_sb3.rules.indices import CampIndex, PieceIndex, camp_range
from hexwar_sb3.tasks.records import WALKING, MissionRecord, TaskKind

_AT_CELL = (TaskKind.HOLD, TaskKind.HIDE, TaskKind.DROP)
_AT_ENEMY = (TaskKind.ATTACK, TaskKind.GUIDE, TaskKind.BOMBARD, TaskKind.SHADOW)


def check_play(world: World, state: State, missions: Rows, brains: Rows, drives: Rows) -> None:
    """Check what the drive loop keeps of games, whose state is sound.

    Raises:
        CheckpointError: it does not belong to them.
    """
    bounds = {
        **bounds_of(world, state),
        "think_ticks": CONFIG.think_ticks,
        "orders": MAX_SIDE * state.games.tick.astype(np.int64),
        "losses": MAX_SIDE * int(world.rules[0].blood.max()),
    }
    _check_missions(world, state, missions, bounds)
    _check_brains(world, brains, bounds)
    _check_drawn(state, brains, drives)
    _check_drives(world, state, drives, bounds)
    _check_orders(world, state)


def _check_missions(world: World, state: State, missions: Rows, bounds: Bounds) -> None:
    check_rows("missions", missions, fields_of(MissionRecord), bounds)
    pieces, cells = state.pieces, world.cells
    target = pieces[np.arange(len(missions))[:, None], missions.target]
    named = missions.target != NO_PIECE
    of_enemy = np.isin(missions.kind, _AT_ENEMY)
    boards = missions.kind == TaskKind.BOARD
    fits = np.where(of_enemy, named & (target.camp != pieces.camp), ~named)
    fits = np.where(boards, named & (target.camp == pieces.camp) & (target.kind == PieceType.CHARIOT), fits)
    check_all(
        "missions.target", fits, missions.target, "an enemy, a chariot or nobody, as the kind of task has it"
    )
    playable = cells.playable == 1
    playable[0] |= not world.scenario.points  # where bots then see their point
    somewhere = (missions.cell != NO_CELL) & playable[missions.cell] & np.isin(missions.kind, _AT_CELL)
    check_all(
        "missions.cell",
        (missions.cell == NO_CELL) | somewhere,
        missions.cell,
        "a playable cell, for a task at a cell",
    )
    check_all(
        "missions.goal",
        (missions.goal == NO_CELL) | playable[missions.goal],
        missions.goal,
        "a playable cell",
    )
    goes = (missions.direction == 0) | (missions.state == WALKING)
    on_way = (pieces.arrives_at != NEVER) & (missions.direction > 0)
    beside = cells.neighbour[pieces.cell, np.maximum(missions.direction, 1) - 1]
    goes &= ~on_way | (beside != NO_CELL)
    check_all("missions.direction", goes, missions.direction, "a way to walk")


def _check_brains(world: World, brains: Rows, bounds: Bounds) -> None:
    check_rows("brains", brains, [one for one in fields_of(BrainRecord) if one.name != "drawn"], bounds)
    for camp in (Camp.RED, Camp.BLUE):
        own, enemy, brain = world.side(camp), world.side(1 - camp), brains[:, camp]
        n_own = own.stop - own.start
        for name in ("taker", "keeper"):
            check_range(f"brains.{name}", brain[name], -1, max(0, n_own - 1))
        used = np.arange(brain.foes.shape[1]) < brain.n_foes[:, None]
        fits = (brain.foes >= enemy.start) & (brain.foes < enemy.stop)
        check_all("brains.foes", ~used | fits, brain.foes, "enemies")
        check_range("brains.n_foes", brain.n_foes, 0, enemy.stop - enemy.start)
        playable = (brain.post == NO_CELL) | (world.cells.playable[brain.post] == 1)
        thinks = (brain.thoughts[:, None] > 0) & (np.arange(brain.post.shape[1]) < n_own) & (brain.post != 0)
        check_all("brains.post", ~thinks | playable, brain.post, "a playable cell")


def _check_drawn(state: State, brains: Rows, drives: Rows) -> None:
    """What was drawn for a player is what its game draws again."""
    found = brains["drawn"]
    of_family = np.isin(drives.seat, [BOTS[name].id for name in FAMILIES])
    check_all(
        "brains.drawn.member",
        of_family | (found["member"] == 0),
        found["member"],
        "0 but for a family's member",
    )
    again = np.zeros(found.shape, CHARACTER)
    again["member"] = found["member"]
    for b, camp in np.argwhere(of_family & (brains.thoughts > 0)).tolist():
        draw_player(drives.seat[b, camp], CampIndex(camp), state.games[b], state.pieces[b], again[b, camp])
    for name in [name for name in CHARACTER.names or () if name != "style"]:
        check_all(f"brains.drawn.{name}", found[name] == again[name], found[name], "what the game draws")
    for name in STYLE.names or ():
        values, expected = found["style"][name], again["style"][name]
        check_all(f"brains.drawn.style.{name}", values == expected, values, "what the game draws")


def _check_drives(world: World, state: State, drives: Rows, bounds: Bounds) -> None:
    check_rows("drives", drives, fields_of(DriveRecord), bounds)
    outside = drives.seat == EXTERNAL
    check_all("drives.asked", ~outside | (drives.asked == 1), drives.asked, "1 where no bot sits")
    check_all("drives.due", (drives.due == 0) | (drives.asked == 1), drives.due, "0 where nobody is asked")
    check_all(
        "drives.wake_at", outside == (drives.wake_at == NEVER), drives.wake_at, f"{NEVER} where no bot sits"
    )
    check_all(
        "drives.lower", outside | (drives.lower == HEURISTIC), drives.lower, f"{HEURISTIC} where a bot sits"
    )
    waits = drives.waiting <= drives.outside
    check_all("drives.waiting", waits, drives.waiting, "pieces for which somebody outside answers")
    for camp in (Camp.RED, Camp.BLUE):
        others = ~np.uint64((1 << len(world.piece_names(camp))) - 1)
        ended = drives.ended[:, camp]
        check_all("drives.ended", (ended & others) == 0, ended, "pieces of the camp")
    for b, game in enumerate(state.games):
        if drives.stepped_at[b] < game.tick:
            known = [
                fingerprint(camp, game, state.pieces[b], state.memory[b], state.rounds[b])
                for camp in camp_range(2)
            ]
            check_all("drives.known", drives.known[b] == known, drives.known[b], "what the camp knows")


def _check_orders(world: World, state: State) -> None:
    """An order that lies there, because a piece of the other camp waits, is legal now."""
    rules, cells = world.rules[0], world.cells
    for b, i in np.argwhere(state.orders.kind != Action.NULL).tolist():
        code = order_code(PieceIndex(i), state.orders[b, i], state.games[b], state.pieces[b], rules, cells)
        if code != Code.OK:
            refuse("orders.kind", f"{state.orders.kind[b, i]} at [{b}, {i}]", "a legal order")
