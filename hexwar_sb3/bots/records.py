"""What a scripted player keeps of one game, and what it knows of a map before any game."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.bots.config import BOT_CONFIG, STYLE
from hexwar_sb3.bots.drawn_records import CHARACTER, SQUADS
from hexwar_sb3.engine.records import MAX_PIECES, MAX_POINTS, MAX_SIDE

BANDS = 4  # of distances from a control point
BAND_CELLS = ((4, 8), (9, 12), (13, 16), (17, 20))  # nearest and farthest cell of each band
POSTS = 12  # firing cells kept of each band
AROUND = 91  # cells within 5 of a cell, itself included
RING = 48  # cells 6 to 14 away from an enemy, for hunters
CHOICES = BANDS * POSTS + AROUND + RING  # most cells that are looked at for one piece
REACH = 26  # distances 0..25 of the danger table
SHELTERS = 3  # a target in the open; concealed or hidden; both
UPHILL = 9  # grade steps from the shooter up to its target, 8 and more the last
SPENT = 4  # row of the danger table for a chariot without missiles
NOBODY = -1  # no slot

BRAIN = np.dtype(
    [
        ("thoughts", "u4"),  # so far; 0: a fresh brain
        ("draws", "u4"),  # random numbers drawn so far
        ("thought_at", "i2"),  # tick of the last thought
        ("wake_at", "i2"),  # next tick at which it wants to act though nothing happens
        ("loss_at", "i2"),  # own loss and new contact that were already thought about
        ("contact_at", "i2"),
        ("point", "i1", (MAX_SIDE,)),  # control point that each piece works for
        ("post", "i2", (MAX_SIDE,)),  # firing cell of each piece; NO_CELL
        ("dropped_for", "i1", (MAX_SIDE,)),  # control point + 1 that a soldier was set down for; 0: none yet
        ("taker", "i1", (MAX_POINTS,)),  # slot that is to take a point; NOBODY
        ("keeper", "i1", (MAX_POINTS,)),  # slot that is to stay on an own point; NOBODY
        ("rush", "u1"),  # behind near the end: everybody goes for the points
        ("n_foes", "u1"),
        ("foes", "i1", (MAX_SIDE,)),  # enemies with some trust, at the last thought
        ("trust", "f4", (MAX_PIECES,)),  # in what is known of each enemy, 0..1, at the last thought
        ("choices", "i2", (CHOICES,)),  # cells that the piece at hand looks at as posts
        ("allotted", "i2", (MAX_PIECES,)),  # losses expected of the shots given in this step
        ("stage", "i1", (SQUADS,)),  # of each squad's timetable; of "drawn" 1 once its feint is over
        ("since", "i2", (SQUADS,)),  # tick at which it began
        ("drawn", CHARACTER),  # of a player of a family
    ],
    align=True,
)
"""brains[2] of a game, one a camp. Zeros are a fresh brain."""

ATLAS = np.dtype(
    [
        ("config", BOT_CONFIG),
        ("style", STYLE, (2,)),  # [Bot.ATTACK, Bot.DEFENCE]
        ("width", "i2"),
        ("height", "i2"),
        ("rank", "i1", (MAX_POINTS,)),  # control points, most valuable first
        ("home", "i2", (2,)),  # [camp] cell of its first piece at the start
        # [camp, point, band] cells with a view of the point, best first
        ("post", "i2", (2, MAX_POINTS, BANDS, POSTS)),
        # [shooter or SPENT, target, sheltered, steps uphill, distance] expected points at full blood
        ("danger", "f4", (SPENT + 1, 4, SHELTERS, UPHILL, REACH)),
        ("best_gain", "f4", (4,)),  # [shooter] most that `gain_at` can say
        ("around", "i1", (AROUND, 2)),  # cube steps to the cells within 5, nearest first, red's frame
        ("ring", "i1", (RING, 2)),  # cube steps to cells 6 to 14 away, red's frame
    ],
    align=True,
)
"""Static tables of one map, `make_atlas(world)`; kernels take `atlas[0]`."""
