"""Why an order was refused, and what can happen: the engine's own vocabulary."""

from __future__ import annotations

from enum import IntEnum


class Code(IntEnum):
    """Outcome of one order (rule book, section 4). OK is 0; `reasons.py` has the sentences."""

    OK = 0
    GAME_OVER = 1
    DEAD = 2
    ABOARD = 3
    BUSY = 4  # hiding, boarding, decompressing, or in a forced stop
    MOVING = 5  # has a path or a stop transition where it must be settled
    SUPPRESSED = 6
    CLOSE_COMBAT = 7
    EMPTY_PATH = 8
    PATH_TOO_LONG = 9
    NO_HOP = 10  # a hop of the path has no hop time
    EXIT_BLOCKED = 11  # close combat: the next cell holds an enemy
    NO_PATH = 12  # stop: nothing to stop
    NOT_GROUND = 13
    ALREADY_HIDDEN = 14
    NOT_CONTROL_POINT = 15
    OWN_POINT = 16
    BETWEEN_CELLS = 17
    NO_AMMO = 18
    NOT_ARMED = 19  # this type does not carry this weapon
    COOLING = 20
    TARGET_GONE = 21  # dead, aboard or out of sight
    NOT_ENEMY = 22
    TARGET_IN_FIGHT = 23
    OUT_OF_RANGE = 24
    LEVEL_ZERO = 25  # the height correction leaves no attack level
    WRONG_TYPE = 26  # this type of piece has no such action, or the target is of a wrong type
    WRONG_PARTNER = 27  # guided chariot, carrier or passenger that does not fit
    PARTNER_BUSY = 28  # the partner is not settled, is suppressed, cooling or has another order
    CARRIER_FULL = 29
    CELL_FULL = 30
    NOT_SUPPRESSED = 31
    TOO_LATE_TO_DECOMPRESS = 32
    CONFLICT = 33  # another own piece got the same partner
    BAD_CELL = 34
    ORDER_UNKNOWN = 35
    POINT_CONTESTED = 36  # occupy: an enemy ground piece lives in the cell or beside it


class Event(IntEnum):
    """What the log records (formats/replay.md)."""

    SHOT = 1
    GUIDED = 2
    CLOSE_SHOT = 3
    EXIT_SHOT = 4
    MORTAR_FIRED = 5
    MORTAR_LANDED = 6
    MORTAR_JUDGED = 7
    SUPPRESSED = 8
    RELEASED = 9
    DEAD = 10
    ABOARD = 11
    OFF = 12
    GETOFF_BLOCKED = 13
    HIDDEN = 14
    OCCUPIED = 15
    FIRST_CONTACT = 16
    PATH_BLOCKED = 17
    REFUSED = 18
    ARRIVED = 19
    LOSS = 20
    SPOTTED = 21
