"""Names and ids of the scripted players."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

BOTS_VERSION = "1"  # goes into every result beside the hash; a change re-runs every figure that names a bot
DRAWN_VERSION = "2"  # of the families


class Bot(IntEnum):
    """Ids of the scripted players, as the drive loop knows them."""

    ATTACK = 0
    DEFENCE = 1
    RANDOM = 2
    NEAREST = 3
    DEFENDER = 4
    ALL_MAIN = 5
    HALF_HALF = 6
    TWO_HOLD = 7
    DRAWN = 8
    UNSEEN = 9
    DRAWN_PLAN = 10


class Duty(IntEnum):
    """What a squad of "drawn-unseen" does in a stage of its timetable, and one of "drawn-plan" all along."""

    TAKE = 0  # goes onto a point, and holds it
    KEEP = 1  # the same, hidden
    AMBUSH = 2  # hides at a firing post of a point
    CHASE = 3  # attacks the nearest known enemy; with none known it goes onto a point
    PICK = 4  # attacks the enemy that is worth most
    SHADOW = 5  # follows the nearest known enemy, out of its reach
    ESCORT = 6  # stays with the camp's first living vehicle
    RAID = 7  # goes to where the enemy began
    WAIT = 8  # hides where it is


class Pilot(IntEnum):
    """What the aerocraft of a member of "drawn" is."""

    SCOUT = 0  # as MA1's and MA2's
    HUNTER = 1  # attacks what is worth most for the way to it
    PICKET = 2  # stays above its point


class Event(IntEnum):
    """What ends a stage before its time."""

    NOTHING = 0
    TAKEN = 1  # its point is the camp's
    CONTACT = 2  # an enemy came into sight after the stage began
    LOSS = 3  # an own piece was hurt after the stage began


@dataclass(frozen=True)
class BotSpec:
    """One scripted player."""

    id: int  # Bot
    what: str  # one line for lists of players


BOTS: dict[str, BotSpec] = {
    "MA1": BotSpec(Bot.ATTACK, "offensive: rushes the points, hunts what it knows of"),
    "MA2": BotSpec(Bot.DEFENCE, "defensive: fires from cover, takes what it can hold"),
    "random": BotSpec(Bot.RANDOM, "random legal orders"),
    "nearest": BotSpec(Bot.NEAREST, "nearest point, then nearest enemy"),
    "defender": BotSpec(Bot.DEFENDER, "takes the nearest point and only defends it"),
    "all-main": BotSpec(Bot.ALL_MAIN, "constant plan: all to the main point, and hold"),
    "half-half": BotSpec(Bot.HALF_HALF, "constant plan: half to each of the two best points, and hold"),
    "two-hold": BotSpec(
        Bot.TWO_HOLD, "constant plan: a chariot and its soldier hold each point, the others hunt"
    ),
    "drawn": BotSpec(
        Bot.DRAWN, "drawn anew for each game: posture, squads, points, times, feints; to train against"
    ),
    "drawn-plan": BotSpec(
        Bot.DRAWN_PLAN,
        "constant plan drawn anew for each game: squads that hold a point or hunt; to train against",
    ),
    "drawn-unseen": BotSpec(Bot.UNSEEN, "drawn anew, of another construction: timetables; only to measure"),
}
FAMILIES = ("drawn", "drawn-plan", "drawn-unseen")
"""Players of which each game draws a member; "drawn:7" is the seventh, the same in every game."""
MOST_MEMBER = 2**32 - 1


def as_member(name: str) -> tuple[str, int]:
    """Split the name of a family's member, "drawn:7", into family and number; any other name is its own, member 0."""
    family, colon, number = name.rpartition(":")
    member = number.isascii() and number.isdecimal() and 0 < int(number[:10]) <= MOST_MEMBER
    if colon and family in FAMILIES and member and len(number) <= len(str(MOST_MEMBER)):
        return family, int(number)
    return name, 0


def is_bot(player: object) -> bool:
    """Whether this names a scripted player, or a member of a family."""
    return isinstance(player, str) and as_member(player)[0] in BOTS
