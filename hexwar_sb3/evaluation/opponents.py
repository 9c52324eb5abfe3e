"""Opponents of a training as they are written: NAME, or NAME=WEIGHT."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache
from math import isfinite

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps.files import load_scenario
from hexwar_sb3.maps.scenario import Scenario, ScenarioLike
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.player import POLICIES
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.rules.ruleset import default_rules

OPPONENTS = ("MA1=6", "MA2=6", "drawn=3", "drawn-plan=3", "nearest", "defender", "all-main", "half-half")
"""Scripted players of both kinds, known ones and others in each game: who learns against them holds against more."""
LEARNED, WEIGHT_OF_LEARNED = (
    "HRL0",
    2,
)  # a trained policy beside them, for the rules and line-ups of its training
SELF = "self"  # an opponent of a training: copies of what it was before
WEIGHT = re.compile(r"(.+)=([0-9.]+(?:[eE][-+]?[0-9]+)?)", re.DOTALL)


def broad_mixture(scenario: ScenarioLike) -> tuple[str, ...]:
    """Opponents of a training where none is named; the trained policy is among them where rules and scenario are like its own.

    Raises:
        UnknownNameError: there is no such scenario.
        ScenarioFileError, MapFileError: its file is broken.

    Example:
        >>> broad_mixture("hills")[-1]
        'HRL0=2'
    """
    fits = sizes(scenario) == sizes("plain") and _knows_the_rules(LEARNED)
    return (*OPPONENTS, *((f"{LEARNED}={WEIGHT_OF_LEARNED}",) if fits else ()))


@cache
def _knows_the_rules(policy: str) -> bool:
    """Whether a built-in policy was trained under the rules of today; who changes them trains it anew."""
    return FrozenPolicy.load(POLICIES[policy]).about["rules"] == default_rules().hash


@cache
def sizes(scenario: ScenarioLike) -> tuple[int, int]:
    """Number of the larger camp's pieces, and of control points; a policy fits where they are its own."""
    start = scenario if isinstance(scenario, Scenario) else load_scenario(scenario)
    red = sum(piece.camp == Camp.RED for piece in start.pieces)
    return max(red, len(start.pieces) - red), len(start.points)


def named(opponents: Sequence[str]) -> list[str]:
    """Opponents that are there before the training: all but itself.

    Raises:
        ConfigError: as `with_weights`.
    """
    return [name for name in with_weights(opponents) if name != SELF]


def with_weights(opponents: Sequence[str], what: str = "opponent") -> dict[str, float]:
    """Opponents and their weights: NAME=WEIGHT, or NAME alone for a weight of 1.

    Args:
        opponents: as they are written.
        what: they are, for messages.

    Raises:
        ConfigError: there is none, one is named twice, or a weight is out of its range.

    Example:
        >>> with_weights(["MA1=3", "nearest"])
        {'MA1': 3.0, 'nearest': 1.0}
    """
    found: dict[str, float] = {}
    for text in opponents:
        matched = WEIGHT.fullmatch(text)
        name, number = matched.groups() if matched else (text, "1")
        weight = _weight(what, text, number)
        if name in found:
            raise ConfigError(f"each {what} is named once, got {name!r} again")
        found[name] = weight
    if not sum(found.values()) > 0.0:
        raise ConfigError(f"name at least one {what} with a weight above 0")
    return found


def _weight(what: str, text: str, number: str) -> float:
    try:
        weight = float(number)
    except ValueError:
        weight = float("nan")
    if not isfinite(weight):
        raise ConfigError(f"{'an' if what[0] == 'o' else 'a'} {what} is NAME or NAME=WEIGHT, got {text!r}")
    return weight
