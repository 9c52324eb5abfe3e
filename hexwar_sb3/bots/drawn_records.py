"""What is drawn of a player of a family before its game begins."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.bots.config import Style
from hexwar_sb3.engine.records import MAX_SIDE
from hexwar_sb3.records import F4, I1, I2, U1, U4, Table, Vector, dtype_of, of_shape
from hexwar_sb3.rules.indices import SlotIndex

SQUADS = 3  # a player has at most
STAGES = 4  # of a timetable


class CharacterRecord:
    """brain.drawn. Zeros stand for a player that is not drawn."""

    member: U4[np.uint32]  # of the family; 0: the game's seed draws one
    style: Style  # how it weighs and fires
    squad: Vector[SlotIndex, I1[int]] = of_shape(MAX_SIDE)  # [slot] squad of a piece
    # Of all families, a value a squad
    point: Vector[int, I1[int]] = of_shape(SQUADS)  # control point that it works for, most valuable first
    start: Vector[int, I2[int]] = of_shape(SQUADS)  # tick at which it sets out; before, it hides
    # "drawn" alone
    feint: Vector[int, I1[int]] = of_shape(SQUADS)  # point that it makes for until `turn`
    turn: Vector[int, I2[int]] = of_shape(SQUADS)  # tick; 0: no feint
    hunt: Vector[int, I2[int]] = of_shape(SQUADS)  # tick from which its vehicles attack what they know of
    staged: U1[int]  # 1: who waits does so at a far post of its point, 0: where it stands
    stubborn: U1[int]  # 1: nobody leaves a safe point for another
    dealt: U1[int]  # 1: pieces are dealt to points as MA1 deals them, 0: by squads
    pilot: U1[int]  # Pilot: what the aerocraft is
    rush: I2[int]  # tick from which it rushes the points
    reckless: U1[int]  # 1: it rushes whoever leads
    retreat_blood: I1[int]  # pieces with so little blood left, or less, withdraw
    retreat_threat: F4[float]  # points of expected harm at their cell from which they do
    # "drawn-unseen" alone but for `what`: a timetable a squad
    what: Table[int, int, I1[int]] = of_shape(SQUADS, STAGES)  # Duty; of "drawn-plan" the first, all along
    where: Table[int, int, I1[int]] = of_shape(SQUADS, STAGES)  # point, most valuable first
    until: Table[int, int, I2[int]] = of_shape(SQUADS, STAGES)  # tick at which the stage ends at the latest
    ends_by: Table[int, int, I1[int]] = of_shape(SQUADS, STAGES)  # Event that ends it before
    post: Vector[SlotIndex, I1[int]] = of_shape(MAX_SIDE)  # [slot] band and number of its post of a point
    quiet: I2[int]  # tick until which nobody fires unless its task is to attack
    rides: U1[int]  # 1: soldiers board their chariot where it stands beside them


CHARACTER = dtype_of(CharacterRecord)
