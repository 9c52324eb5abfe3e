"""The state of a batch of games as a few record arrays (architecture.md, section 2).

A game is one row of each array; a snapshot is a copy of those rows (about 3 KB).
Times are END TICKS, never counters: a timer of n set in step t holds t + n and is over in the
state of that tick. `NEVER` marks a timer that does not run. Red's pieces come first.

Each table gives the least and the most that a field of a running game may hold, in numbers or in the words of
`sound.bounds_of`; what hangs together is checked in `sound.py`.
"""

from __future__ import annotations

from hexwar_sb3.engine.codes import Code, Event
from hexwar_sb3.engine.fields import ANY_I1, ANY_U8, Field, dtype_of
from hexwar_sb3.maps import cells
from hexwar_sb3.rules.enums import Action, Camp, PieceType, Weapon

NO_CELL = cells.NO_CELL  # off the map, void, or never seen
NEVER = 32767  # end tick of a timer that does not run
NO_PIECE = -1

MAX_PIECES = 32  # both camps together: `sees` is a 32-bit mask
MAX_SIDE = 16
MAX_POINTS = 8
PATH_CELLS = 100

BOARD_NONE, BOARD_ON, BOARD_OFF = 0, 1, 2
ROUND_FREE, ROUND_FLYING, ROUND_BURSTING = 0, 1, 2

GAME_FIELDS = (
    Field("seed", "u8", 0, ANY_U8),
    Field("salt", "u8", 0, ANY_U8, (2,)),  # [camp] dice salts, from the seed
    Field("tick", "i2", 0, "end_tick"),
    Field("end_tick", "i2", 0, "end_tick"),
    Field("over", "i1", 0, 1),
    Field("net_score", "i1", 0, 1),  # 1: own - enemy, 0: eq. (1) literally
    Field("fog", "i1", 0, 1),  # 0: lights on (debugging only)
    Field("n_red", "i1", 0, "pieces"),
    Field("n_pieces", "i1", 0, "pieces"),
    Field("n_points", "i1", 0, "points"),
    Field("early_end", "i1", 0, 1),
    Field("point_owner", "i1", 0, Camp.GREEN, (MAX_POINTS,)),  # Camp
    Field("point_cell", "i2", 0, "last_cell", (MAX_POINTS,)),
    Field("point_value", "i2", 0, NEVER, (MAX_POINTS,)),
    Field("fight_cell", "i2", 0, "last_cell", (MAX_SIDE,), (NO_CELL,)),  # NO_CELL: free row
    # tick whose step makes the next exchange
    Field("fight_next", "i2", "tick", ("tick", "fight_ticks"), (MAX_SIDE,), (NEVER,)),
    Field("loss_tick", "i2", -1, "tick", (2,)),  # [camp] last tick with an own loss; -1 before
    # [camp] last tick at which an enemy came into sight; -1 before
    Field("contact_tick", "i2", -1, "tick", (2,)),
    Field("log_count", "i4", 0, "log"),
)
GAME = dtype_of(GAME_FIELDS)

PIECE_FIELDS = (
    Field("sees", "u4", 0, "piece_bits"),  # bit j: this piece itself sees piece j
    Field("cell", "i2", 0, "last_cell"),
    # end of the hop under way; NEVER: none
    Field("arrives_at", "i2", ("tick", 1), ("tick", "longest_hop"), (), (NEVER,)),
    Field("hop_need", "i2", 0, "longest_hop"),  # ticks of the hop under way
    Field("stop_ends", "i2", ("tick", 1), ("tick", "stop_ticks"), (), (NEVER,)),
    Field("hide_ends", "i2", ("tick", 1), ("tick", "hide_ticks"), (), (NEVER,)),
    Field("board_ends", "i2", ("tick", 1), ("tick", "board_ticks"), (), (NEVER,)),
    Field("decompress_ends", "i2", ("tick", 1), ("tick", "decompress_ticks"), (), (NEVER,)),
    Field("cool_ends", "i2", ("tick", 1), ("tick", "cool_ticks"), (), (NEVER,)),
    Field("mortar_ends", "i2", ("tick", 1), ("tick", "mortar_cool_ticks"), (), (NEVER,)),
    Field("keep_ends", "i2", ("tick", 1), ("tick", "keep_ticks"), (), (NEVER,)),
    Field("arrived_at", "i2", -1, "tick"),  # tick of the last arrival in a cell; -1 before
    Field("path_pos", "i1", 0, PATH_CELLS),  # next direction of paths[piece] to walk
    Field("path_len", "i1", 0, PATH_CELLS),  # path is empty when path_pos == path_len
    Field("kind", "i1", 0, len(PieceType) - 1),  # PieceType
    Field("camp", "i1", 0, 1),
    Field("slot", "i1", 0, MAX_SIDE - 1),  # index within its camp
    Field("blood", "i1", 0, "most_blood"),  # 0: destroyed
    Field("hidden", "i1", 0, 1),
    Field("suppressed", "i1", 0, 1),
    Field("waiting", "i1", 0, 1),  # has a path but cannot start its hop
    Field("stop_forced", "i1", 0, 1),  # the transition under way (or after this hop) was ordered
    Field("stop_pending", "i1", 0, 1),  # a stop order waits for the end of this hop
    Field("board_kind", "i1", BOARD_NONE, BOARD_OFF),  # BOARD_*
    Field("board_partner", "i1", NO_PIECE, "last_piece"),
    Field("home", "i1", NO_PIECE, "last_piece"),  # a soldier's chariot
    Field("carrier", "i1", NO_PIECE, "last_piece"),  # NO_PIECE: not aboard
    Field("passenger", "i1", NO_PIECE, "last_piece"),
    Field("ammo", "i1", 0, "most_ammo", (4,)),  # [pool]
    Field("losses_now", "i1", 0, 0),  # scratch of the step under way, zero between steps:
    Field("hit_now", "i1", 0, 0),  # some result >= 0
    Field("zero_now", "i1", 0, 0),  # some result = 0
    Field("spent_now", "i1", 0, 0, (4,)),  # [pool] rounds fired in close combat
)
PIECE = dtype_of(PIECE_FIELDS)
"""stop_ends etc. are NEVER when idle. path empty + all four transitions idle = settled."""

MEMORY_FIELDS = (
    Field("cell", "i2", NO_CELL, "last_cell"),  # NO_CELL: never seen
    Field("tick", "i2", 0, "tick"),  # last tick at which it was seen (exact once `seen` is 0)
    Field("still_since", "i2", 0, "tick"),  # tick since which it has been seen in this cell
    Field("first_tick", "i2", 0, "tick"),  # tick of the last change from unseen to seen
    Field("next_cell", "i2", NO_CELL, "last_cell"),  # where its hop under way leads; NO_CELL
    Field("blood", "i1", 0, "most_blood"),
    Field("hidden", "i1", 0, 1),
    Field("suppressed", "i1", 0, 1),
    Field("moving", "i1", 0, 1),  # in_motion as last seen
    Field("seen", "i1", 0, 1),  # seen now
    Field("carrying", "i1", 0, 0),  # always 0: passengers cannot be seen
)
MEMORY = dtype_of(MEMORY_FIELDS)
"""memory[camp, piece]: what a camp knows of an enemy piece (u(sigma, t), III-A)."""

ROUND_FIELDS = (
    Field("owner", "i1", 0, "last_piece"),
    Field("camp", "i1", 0, 1),
    Field("status", "i1", ROUND_FREE, ROUND_BURSTING),  # ROUND_*
    Field("blood_at_launch", "i1", 0, "most_blood"),
    Field("hit", "i1", 0, 1),  # 1 hit, 0 off target; valid while bursting
    Field("cell", "i2", 0, "last_cell"),  # aimed at
    Field("impact", "i2", NO_CELL, "last_cell"),
    Field("launch_cells", "i2", 0, "mortar_max_cells"),
    Field("fired_at", "i2", 0, "tick"),
    Field("land_at", "i2", 0, ("tick", "flight_ticks")),
    Field("end_at", "i2", 0, ("tick", "burst_ticks")),
    Field("judged", "u4", 0, "piece_bits"),  # bit i: piece i was judged in this burst
)
ROUND = dtype_of(ROUND_FIELDS)

ORDER_FIELDS = (
    Field("kind", "i1", 0, len(Action) - 1),  # Action
    Field("code", "i1", 0, max(Code)),  # Code, written by the step
    Field("weapon", "i1", -1, len(Weapon) - 1),
    # shot at; carrier to board; passenger to set down
    Field("target", "i1", NO_PIECE, "last_piece"),
    Field("partner", "i1", NO_PIECE, "last_piece"),  # guide-shoot: the chariot that launches
    Field("path_len", "i1", 0, PATH_CELLS),
    Field("cell", "i2", NO_CELL, "last_cell"),  # indirect-shoot
    Field("path", "i1", 0, 5, (PATH_CELLS,)),  # directions 0..5
)
ORDER = dtype_of(ORDER_FIELDS)

LOG_FIELDS = (
    Field("tick", "i2", 0, "tick"),  # of the state that the event made
    Field("event", "i1", 0, max(Event)),
    Field("a", "i1", NO_PIECE, "last_piece"),  # actor
    Field("b", "i1", NO_PIECE, "last_piece"),  # target or partner
    Field("weapon", "i1", -1, len(Weapon) - 1),
    Field("level", "i1", *ANY_I1),
    Field("roll", "i1", *ANY_I1),
    Field("raw", "i1", *ANY_I1),
    Field("roll2", "i1", *ANY_I1),
    Field("mods", "i1", *ANY_I1),
    Field("corr", "i1", *ANY_I1),
    Field("result", "i1", *ANY_I1),
    Field("cell", "i2", NO_CELL, "last_cell"),
    Field("cells_apart", "i2", 0, NEVER),
    Field("extra", "i2", -NEVER, NEVER),
)
LOG = dtype_of(LOG_FIELDS)
