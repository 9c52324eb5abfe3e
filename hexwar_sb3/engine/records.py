"""The state of a batch of games as a few record arrays (architecture.md, section 2).

A game is one row of each array; a snapshot is a copy of those rows (about 3 KB).
Times are END TICKS, never counters: a timer of n set in step t holds t + n and is over in the
state of that tick. `NEVER` marks a timer that does not run. Red's pieces come first.
"""

from __future__ import annotations

import numpy as np

from hexwar_sb3.maps import cells

NO_CELL = cells.NO_CELL  # off the map, void, or never seen
NEVER = 32767  # end tick of a timer that does not run
NO_PIECE = -1

MAX_PIECES = 32  # both camps together: `sees` is a 32-bit mask
MAX_SIDE = 16
MAX_POINTS = 8
PATH_CELLS = 100

BOARD_NONE, BOARD_ON, BOARD_OFF = 0, 1, 2
ROUND_FREE, ROUND_FLYING, ROUND_BURSTING = 0, 1, 2

GAME = np.dtype(
    [
        ("seed", "u8"),
        ("salt", "u8", (2,)),  # [camp] dice salts, from the seed
        ("tick", "i2"),
        ("end_tick", "i2"),
        ("over", "i1"),
        ("net_score", "i1"),  # 1: own - enemy, 0: eq. (1) literally
        ("fog", "i1"),  # 0: lights on (debugging only)
        ("n_red", "i1"),
        ("n_pieces", "i1"),
        ("n_points", "i1"),
        ("early_end", "i1"),
        ("point_owner", "i1", (MAX_POINTS,)),  # Camp
        ("point_cell", "i2", (MAX_POINTS,)),
        ("point_value", "i2", (MAX_POINTS,)),
        ("fight_cell", "i2", (MAX_SIDE,)),  # NO_CELL: free row
        ("fight_next", "i2", (MAX_SIDE,)),  # tick whose step makes the next exchange
        ("loss_tick", "i2", (2,)),  # [camp] last tick with an own loss; -1 before
        ("contact_tick", "i2", (2,)),  # [camp] last tick at which an enemy came into sight; -1 before
        ("log_count", "i4"),
    ],
    align=True,
)

PIECE = np.dtype(
    [
        ("sees", "u4"),  # bit j: this piece itself sees piece j
        ("cell", "i2"),
        ("arrives_at", "i2"),  # end of the hop under way; NEVER: none
        ("hop_need", "i2"),  # ticks of the hop under way
        ("stop_ends", "i2"),
        ("hide_ends", "i2"),
        ("board_ends", "i2"),
        ("decompress_ends", "i2"),
        ("cool_ends", "i2"),
        ("mortar_ends", "i2"),
        ("keep_ends", "i2"),
        ("arrived_at", "i2"),  # tick of the last arrival in a cell; -1 before
        ("path_pos", "i1"),  # next direction of paths[piece] to walk
        ("path_len", "i1"),  # path is empty when path_pos == path_len
        ("kind", "i1"),  # PieceType
        ("camp", "i1"),
        ("slot", "i1"),  # index within its camp
        ("blood", "i1"),  # 0: destroyed
        ("hidden", "i1"),
        ("suppressed", "i1"),
        ("waiting", "i1"),  # has a path but cannot start its hop
        ("stop_forced", "i1"),  # the transition under way (or after this hop) was ordered
        ("stop_pending", "i1"),  # a stop order waits for the end of this hop
        ("board_kind", "i1"),  # BOARD_*
        ("board_partner", "i1"),
        ("home", "i1"),  # a soldier's chariot
        ("carrier", "i1"),  # NO_PIECE: not aboard
        ("passenger", "i1"),
        ("ammo", "i1", (4,)),  # [pool]
        ("losses_now", "i1"),  # scratch of the step under way, zero between steps:
        ("hit_now", "i1"),  # some result >= 0
        ("zero_now", "i1"),  # some result = 0
        ("spent_now", "i1", (4,)),  # [pool] rounds fired in close combat
    ],
    align=True,
)
"""stop_ends etc. are NEVER when idle. path empty + all four transitions idle = settled."""

MEMORY = np.dtype(
    [
        ("cell", "i2"),  # NO_CELL: never seen
        ("tick", "i2"),  # last tick at which it was seen (exact once `seen` is 0)
        ("still_since", "i2"),  # tick since which it has been seen in this cell
        ("first_tick", "i2"),  # tick of the last change from unseen to seen
        ("next_cell", "i2"),  # where its hop under way leads; NO_CELL
        ("blood", "i1"),
        ("hidden", "i1"),
        ("suppressed", "i1"),
        ("moving", "i1"),  # in_motion as last seen
        ("seen", "i1"),  # seen now
        ("carrying", "i1"),  # always 0: passengers cannot be seen
    ],
    align=True,
)
"""memory[camp, piece]: what a camp knows of an enemy piece (u(sigma, t), III-A)."""

ROUND = np.dtype(
    [
        ("owner", "i1"),
        ("camp", "i1"),
        ("status", "i1"),  # ROUND_*
        ("blood_at_launch", "i1"),
        ("hit", "i1"),  # 1 hit, 0 off target; valid while bursting
        ("cell", "i2"),  # aimed at
        ("impact", "i2"),
        ("launch_cells", "i2"),
        ("fired_at", "i2"),
        ("land_at", "i2"),
        ("end_at", "i2"),
        ("judged", "u4"),  # bit i: piece i was judged in this burst
    ],
    align=True,
)

ORDER = np.dtype(
    [
        ("kind", "i1"),  # Action
        ("code", "i1"),  # Code, written by the step
        ("weapon", "i1"),
        ("target", "i1"),  # shot at; carrier to board; passenger to set down
        ("partner", "i1"),  # guide-shoot: the chariot that launches
        ("path_len", "i1"),
        ("cell", "i2"),  # indirect-shoot
        ("path", "i1", (PATH_CELLS,)),  # directions 0..5
    ],
    align=True,
)

LOG = np.dtype(
    [
        ("tick", "i2"),  # of the state that the event made
        ("event", "i1"),
        ("a", "i1"),  # actor
        ("b", "i1"),  # target or partner
        ("weapon", "i1"),
        ("level", "i1"),
        ("roll", "i1"),
        ("raw", "i1"),
        ("roll2", "i1"),
        ("mods", "i1"),
        ("corr", "i1"),
        ("result", "i1"),
        ("cell", "i2"),
        ("cells_apart", "i2"),
        ("extra", "i2"),
    ],
    align=True,
)
