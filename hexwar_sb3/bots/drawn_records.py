"""What is drawn of a player of the families "drawn" and "drawn-unseen" before its game begins."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.bots.config import STYLE
from hexwar_sb3.engine.records import MAX_SIDE

SQUADS = 3  # a player has at most
STAGES = 4  # of a timetable

CHARACTER = np.dtype(
    [
        ("member", "u4"),  # of the family; 0: the game's seed draws one
        ("style", STYLE),  # how it weighs and fires
        ("squad", "i1", (MAX_SIDE,)),  # [slot] squad of a piece
        # Of both families, a value a squad
        ("point", "i1", (SQUADS,)),  # control point that it works for, most valuable first
        ("start", "i2", (SQUADS,)),  # tick at which it sets out; before, it hides
        # "drawn" alone
        ("feint", "i1", (SQUADS,)),  # point that it makes for until `turn`
        ("turn", "i2", (SQUADS,)),  # tick; 0: no feint
        ("hunt", "i2", (SQUADS,)),  # tick from which its vehicles attack what they know of
        ("staged", "u1"),  # 1: who waits does so at a far post of its point, 0: where it stands
        ("stubborn", "u1"),  # 1: nobody leaves a safe point for another
        ("dealt", "u1"),  # 1: pieces are dealt to points as MA1 deals them, 0: by squads
        ("pilot", "u1"),  # Pilot: what the aerocraft is
        ("rush", "i2"),  # tick from which it rushes the points
        ("reckless", "u1"),  # 1: it rushes whoever leads
        ("retreat_blood", "i1"),  # pieces with so little blood left, or less, withdraw
        ("retreat_threat", "f4"),  # points of expected harm at their cell from which they do
        # "drawn-unseen" alone: a timetable a squad
        ("what", "i1", (SQUADS, STAGES)),  # Duty
        ("where", "i1", (SQUADS, STAGES)),  # point, most valuable first
        ("until", "i2", (SQUADS, STAGES)),  # tick at which the stage ends at the latest
        ("ends_by", "i1", (SQUADS, STAGES)),  # Event that ends it before
        ("post", "i1", (MAX_SIDE,)),  # [slot] band and number of its post of a point
        ("quiet", "i2"),  # tick until which nobody fires unless its task is to attack
        ("rides", "u1"),  # 1: soldiers board their chariot where it stands beside them
    ],
    align=True,
)
"""brain.drawn. Zeros stand for a player that is not drawn."""
