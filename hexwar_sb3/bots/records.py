"""What a scripted player keeps of one game, and what it knows of a map before any game."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.bots.config import BotConfig, Style
from hexwar_sb3.bots.drawn_records import SQUADS, STAGES, CharacterRecord
from hexwar_sb3.engine.fields import ANY_U4
from hexwar_sb3.engine.records import MAX_PIECES, MAX_POINTS, MAX_SIDE, NO_CELL
from hexwar_sb3.records import F4, I1, I2, I4, U1, U4, Block, Table, Vector, dtype_of, of_shape, within
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex, PointIndex, SlotIndex

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
NOBODY = SlotIndex(-1)  # no slot


class BrainRecord:
    """What a scripted player keeps of a game; zeros are a fresh brain. brains[2] of a game, one a camp."""

    thoughts: U4[np.uint32] = within(0, ("tick", 1))  # so far; 0: a fresh brain
    draws: U4[np.uint32] = within(0, ANY_U4)  # random numbers drawn so far
    thought_at: I2[int] = within(0, "tick")  # tick of the last thought
    # next tick at which it wants to act though nothing happens
    wake_at: I2[int] = within(0, ("tick", "think_ticks"))
    loss_at: I2[int] = within(-1, "tick")  # own loss and new contact that were already thought about
    contact_at: I2[int] = within(-1, "tick")
    # control point that each piece works for
    point: Vector[SlotIndex, I1[PointIndex]] = within(0, "last_point", (MAX_SIDE,))
    # firing cell of each piece; NO_CELL
    post: Vector[SlotIndex, I4[CellIndex]] = within(NO_CELL, "last_cell", (MAX_SIDE,))
    # control point + 1 that a soldier was set down for; 0: none yet
    dropped_for: Vector[SlotIndex, I1[int]] = within(0, ("last_point", 1), (MAX_SIDE,))
    # slot that is to take a point; NOBODY
    taker: Vector[PointIndex, I1[SlotIndex]] = within(-1, MAX_SIDE - 1, (MAX_POINTS,))
    # slot that is to stay on an own point; NOBODY
    keeper: Vector[PointIndex, I1[SlotIndex]] = within(-1, MAX_SIDE - 1, (MAX_POINTS,))
    rush: U1[int] = within(0, 1)  # behind near the end: everybody goes for the points
    n_foes: U1[int] = within(0, MAX_SIDE)
    # enemies with some trust, at the last thought
    foes: Vector[int, I1[PieceIndex]] = within(0, "last_piece", (MAX_SIDE,))
    # in what is known of each enemy, 0..1, at the last thought
    trust: Vector[PieceIndex, F4[float]] = within(0, 1, (MAX_PIECES,))
    # cells that the piece at hand looks at as posts
    choices: Vector[int, I4[CellIndex]] = within(NO_CELL, "last_cell", (CHOICES,))
    # losses expected of the shots given in this step
    allotted: Vector[PieceIndex, I2[int]] = within(0, "losses", (MAX_PIECES,))
    # of each squad's timetable; of "drawn" 1 once its feint is over
    stage: Vector[int, I1[int]] = within(0, STAGES - 1, (SQUADS,))
    since: Vector[int, I2[int]] = within(0, "tick", (SQUADS,))  # tick at which it began
    drawn: CharacterRecord  # of a player of a family


BRAIN = dtype_of(BrainRecord)


class AtlasRecord:
    """Static tables of one map, `make_atlas(world)`; kernels take `atlas[0]`."""

    config: BotConfig
    style: Vector[int, Style] = of_shape(2)  # [Bot.ATTACK, Bot.DEFENCE]
    width: I2[int]
    height: I2[int]
    rank: Vector[int, I1[PointIndex]] = of_shape(MAX_POINTS)  # control points, most valuable first
    home: Vector[CampIndex, I4[CellIndex]] = of_shape(2)  # [camp] cell of its first piece at the start
    # [camp, point, band] cells with a view of the point, best first
    post: Block[I4[CellIndex]] = of_shape(2, MAX_POINTS, BANDS, POSTS)
    # [shooter or SPENT, target, sheltered, steps uphill, distance] expected points at full blood
    danger: Block[F4[float]] = of_shape(SPENT + 1, 4, SHELTERS, UPHILL, REACH)
    best_gain: Vector[int, F4[float]] = of_shape(4)  # [shooter] most that `gain_at` can say
    # cube steps to the cells within 5, nearest first, red's frame
    around: Table[int, int, I1[int]] = of_shape(AROUND, 2)
    ring: Table[int, int, I1[int]] = of_shape(RING, 2)  # cube steps to cells 6 to 14 away, red's frame


ATLAS = dtype_of(AtlasRecord)
