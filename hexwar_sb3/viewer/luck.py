"""How lucky each shot was: its chances in the state before it, and what came of it, in points.

Shots at one target in one tick are taken one after the other: each counts with what it adds to those before. So the
points of all shots add up to the points that were lost, and what a shot is expected to add is exact given those.
A mortar round counts from where it came down: its scatter is no part of it.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from hexwar_sb3.engine.chances import shot_chances
from hexwar_sb3.engine.game_events import GameEvent
from hexwar_sb3.engine.records import NO_PIECE
from hexwar_sb3.engine.roster import Roster
from hexwar_sb3.engine.world import World
from hexwar_sb3.kernels import Row, Rows
from hexwar_sb3.rules.compiled import NO_EFFECT
from hexwar_sb3.rules.enums import PieceType, Weapon
from hexwar_sb3.rules.odds import ONE_DIE, TWO_DICE

SHOTS = frozenset({"shot", "guided", "close_shot", "exit_shot", "mortar_judged"})
_DIGITS = 4  # of a chance, in a file


class ShotLuck(NamedTuple):
    """One shot: what it could do and what it did."""

    chances: dict[int, float]  # by result: -1 nothing, 0 suppressed, n losses
    expected: float  # points
    variance: float  # points squared
    lost: int  # points

    def told(self) -> dict[str, object]:
        """As it stands with an event of a story."""
        best = max(self.chances)
        return {
            "chances": [round(self.chances.get(n, 0.0), _DIGITS) for n in range(NO_EFFECT, best + 1)],
            "expected": round(self.expected, 2),
            "variance": round(self.variance, 2),
            "lost": self.lost,
        }


class Loss(NamedTuple):
    """What a target has suffered so far in a tick."""

    blood: int = 0
    suppressed: bool = False

    def and_then(self, result: int) -> Loss:
        """With one result more."""
        return Loss(self.blood + max(result, 0), self.suppressed or result == 0)


def judge_shots(
    events: Iterable[GameEvent], before: Rows, world: World, roster: Roster
) -> dict[int, ShotLuck]:
    """The luck of the shots among the events of one tick, by their number.

    before: pieces [P] in the state before the tick.
    """
    found, suffered = dict[int, ShotLuck](), dict[int, Loss]()
    for number, event in enumerate(events):
        if event.kind not in SHOTS or event.target is None or event.result is None:
            continue
        target = roster.index(event.target)
        loss = suffered.get(target, Loss())
        found[number] = _luck(event, target, loss, before, world, roster)
        suffered[target] = loss.and_then(event.result)
    return found


def _luck(event: GameEvent, target: int, loss: Loss, before: Rows, world: World, roster: Roster) -> ShotLuck:
    rules = world.rules[0]
    chances = chances_of(event, before, world, roster)

    def added(result: int) -> int:
        return points_lost(target, loss.and_then(result), before, rules) - points_lost(
            target, loss, before, rules
        )

    expected = sum(chance * added(result) for result, chance in chances.items())
    variance = sum(chance * (added(result) - expected) ** 2 for result, chance in chances.items())
    return ShotLuck(chances, expected, variance, added(int(event.result or 0)))


def chances_of(event: GameEvent, before: Rows, world: World, roster: Roster) -> dict[int, float]:
    """Chances of every result of a shot: -1 nothing, 0 suppressed, n losses, capped at the target's blood."""
    target = before[roster.index(str(event.target))]
    if event.kind == "mortar_judged":
        return _burst_chances(bool(event.hit), int(event.modifiers or 0), int(target.blood), world.rules[0])
    shooter = before[roster.index(event.shooter or event.piece)]
    weapon = Weapon[str(event.weapon)]
    chances = shot_chances(weapon, shooter, target, before, world.rules[0], world.cells)
    losses = {n: chance for n, chance in enumerate(chances.losses, start=1) if chance > 0}
    return {NO_EFFECT: chances.nothing, 0: chances.suppressed} | losses


def _burst_chances(hit: bool, modifiers: int, blood: int, rules: Row) -> dict[int, float]:
    chances: dict[int, float] = {}
    last = rules.burst_correction.size - 1
    for roll, first in TWO_DICE.items():
        for die, second in ONE_DIE.items():
            correction = int(rules.burst_correction[int(np.clip(die + modifiers, 0, last))])
            result = min(blood, max(NO_EFFECT, int(rules.burst_result[int(hit), roll]) + correction))
            chances[result] = chances.get(result, 0.0) + first * second
    return chances


def points_lost(target: int, loss: Loss, pieces: Rows, rules: Row) -> int:
    """Points that a piece and its passenger lose by what it suffered in one tick (rule book, sections 7 and 13)."""
    piece = pieces[target]
    more = piece.kind == PieceType.SOLDIER and piece.suppressed and loss.suppressed
    blood = min(int(piece.blood), loss.blood + int(more))
    points = blood * int(rules.value[piece.kind])
    if piece.passenger == NO_PIECE:
        return points
    rider = pieces[piece.passenger]
    squads = int(rider.blood) if blood == piece.blood else min(blood, int(rider.blood))
    return points + squads * int(rules.value[rider.kind])
