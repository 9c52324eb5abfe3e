"""Names and ids of the scripted players."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

BOTS_VERSION = "1"  # goes into every result beside the hash; a change re-runs every figure that names a bot


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
    "two-hold": BotSpec(Bot.TWO_HOLD, "constant plan: one piece holds each point, the others hunt"),
}
