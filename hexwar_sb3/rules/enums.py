"""The names of the game's kinds: camps, pieces, weapons, actions. No numbers of the rules."""

from __future__ import annotations

from enum import IntEnum


class Camp(IntEnum):
    """Who a piece or a control point belongs to (II-A)."""

    RED = 0
    BLUE = 1
    GREEN = 2  # nobody's; only control points


class PieceType(IntEnum):
    """The four types of pieces (II-A)."""

    TANK = 0
    CHARIOT = 1
    SOLDIER = 2
    AEROCRAFT = 3


class Weapon(IntEnum):
    """Weapons of the rule book, section 2; the platform's codes stand in the weapon table."""

    GUN = 0
    GUN2 = 1
    GUN3 = 2
    CANNON = 3
    LIGHT = 4
    SMALL = 5
    ROCKET = 6
    PORT = 7
    HEAVY = 8
    AIRM = 9
    AIRM2 = 10
    MORTAR = 11


class TargetClass(IntEnum):
    """What an attack table distinguishes (rule book, section 7)."""

    VEHICLE = 0
    SOLDIER = 1
    AEROCRAFT = 2


class HopClass(IntEnum):
    """What a hop-time table distinguishes (rule book, section 1); an aerocraft needs no table."""

    VEHICLE = 0
    SOLDIER = 1


class Action(IntEnum):
    """The eleven actions (II-B)."""

    NULL = 0
    MOVE = 1
    STOP = 2
    HIDE = 3
    OCCUPY = 4
    SHOOT = 5
    GUIDE_SHOOT = 6
    INDIRECT_SHOOT = 7
    GET_ON = 8
    GET_OFF = 9
    DECOMPRESS = 10


class Dice(IntEnum):
    """What a die is thrown for (rule book, section 11); part of the key of every die."""

    DIRECT = 1
    DIRECT_CORRECTION = 2
    AIR = 3
    SCATTER = 4
    SCATTER_DIRECTION = 5
    INDIRECT = 6
    INDIRECT_CORRECTION = 7
    CLOSE_TIE = 8
    EXIT_SHOT = 9
    PRIORITY = 99
