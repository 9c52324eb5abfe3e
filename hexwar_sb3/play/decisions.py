"""What the camps of a recorded game decided, what they chose from, and what it brought: lines of its replay."""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from typing import Any

import numpy as np

from hexwar_sb3.engine.record import Line
from hexwar_sb3.engine.records import NO_CELL, NO_PIECE
from hexwar_sb3.engine.replay_lines import REWARD
from hexwar_sb3.engine.roster import SIDES, Roster, camp_name, enemy_of
from hexwar_sb3.engine.score import own_total, points_value
from hexwar_sb3.kernels import Row
from hexwar_sb3.maps.geometry import DIRECTION_NAMES
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.tasks.choose import clear_missions
from hexwar_sb3.tasks.records import TaskKind

THOUSANDTHS = 1_000  # Q as a whole number
MOST_Q = 1e6
Choice = list[Any]  # piece, number of the chosen task, tasks, their Q, last direction


class DecisionLog:
    """Looks on while the camps of an arena's one game decide; nothing that is played depends on it.

    A player that is asked chooses for every living piece, each time. A bot thinks when it likes: of it the pieces
    are written whose task is another one.
    """

    def __init__(self, arena: Arena) -> None:
        self.arena, self.roster = arena, Roster(arena.world.scenario)
        self._given = self._missions()
        self._worth = self._all_worth()
        self._asked: dict[int, list[Choice]] = {}

    def twin(self, arena: Arena) -> DecisionLog:
        """A log that goes on from here by itself, in the twin of the arena."""
        other = copy(self)
        other.arena = arena
        other._worth, other._asked = dict(self._worth), dict(self._asked)  # noqa: SLF001 - of the same class
        return other

    def ask(self) -> None:
        """Let the players whose turn it is decide, and keep what they chose from."""
        due = [camp for camp in SIDES if self.arena.drives[0].due[camp]]
        self.arena.ask([0])
        self._asked |= {camp: list(self._choices(camp)) for camp in due}

    def choices(self, camp: Camp) -> list[Choice]:
        """What the camp's player would choose now, and from what, if it had no tasks yet: [piece, chosen, tasks, Q].

        The player must have been seated; this gives its camp the tasks.
        """
        clear_missions(self.arena.missions[0])
        self.arena.drives[0].due[camp] = 1
        self.arena.ask([0])
        return list(self._choices(camp))

    def lines(self, tick: int) -> Iterator[Line]:
        """What was decided at this tick, after the pieces acted on it."""
        if not self._asked and self._missions() == self._given:
            return
        worth = self._all_worth()
        for camp in SIDES:
            choices = self._asked.pop(camp, None) or list(self._changed(camp))
            if not choices:
                continue
            gains = (now - before for now, before in zip(worth[camp], self._worth[camp], strict=True))
            for choice in choices:
                choice.append(self._direction(camp, choice[0], tick))
            yield {
                "type": "decision",
                "tick": tick,
                "camp": camp_name(camp),
                "reward": dict(zip(REWARD, gains, strict=True)),
                "choices": choices,
            }
            self._worth[camp] = worth[camp]
        self._given = self._missions()

    def _choices(self, camp: Camp) -> Iterator[Choice]:
        """Task sets of the living pieces, as the player saw them, and what it chose."""
        sight, chosen = self.arena.sight(camp), self.arena.chosen[camp][0]
        obs = {key: value[:1] for key, value in sight.obs.items()}
        player = self.arena.players[0][camp]
        values = player.q_values(obs) if isinstance(player, FrozenPolicy) else np.zeros(0)
        for n, i in enumerate(self.roster.pieces_of(camp)):
            if not self.arena.state.pieces[0, i].blood:
                continue
            valid = np.flatnonzero(obs["action_mask"][0, n])
            number = int(np.searchsorted(valid, chosen[n])) if chosen[n] in valid else 0  # stop is the first
            q = values[0, n, valid] if values.size else np.zeros(0)
            scaled = np.rint(np.clip(q * THOUSANDTHS, -MOST_Q, MOST_Q)).astype(int)
            yield [
                self.roster.short(i),
                number,
                [self._text(sight.rows[0, n, k]) for k in valid],
                scaled.tolist(),
            ]

    def _changed(self, camp: Camp) -> Iterator[Choice]:
        """Pieces of a bot that do something else now."""
        now = self._missions()
        for i in self.roster.pieces_of(camp):
            if now[i] != self._given[i] and self.arena.state.pieces[0, i].blood:
                yield [self.roster.short(i), 0, [self._text(self.arena.missions[0, i])], []]

    def _missions(self) -> list[tuple[int, int, int]]:
        missions = self.arena.missions[0]
        return list(
            zip(missions.kind.tolist(), missions.target.tolist(), missions.cell.tolist(), strict=True)
        )

    def _text(self, task: Row) -> str:
        """A task or a mission: "hold 1134", "attack blue:tank0", "stop"."""
        words = [TaskKind(task.kind).name.lower()]
        if task.target != NO_PIECE:
            words.append(self.roster.names[task.target])
        if task.cell != NO_CELL and task.target == NO_PIECE:
            words.append(self.roster.cell_name(task.cell))
        return " ".join(words)

    def _direction(self, camp: Camp, piece: str, tick: int) -> str:
        """Where the lower level led the piece when it was asked at this tick; else nothing."""
        mission = self.arena.missions[0, self.roster.own_index(camp, piece)]
        led = mission.asked_at == tick and mission.direction > 0
        return DIRECTION_NAMES[mission.direction - 1] if led else ""

    def _all_worth(self) -> dict[Camp, tuple[int, int, int]]:
        """Terms of eq. (1) as they count for a camp: control points, own pieces, enemy pieces (negative)."""
        game, pieces, rules = self.arena.state.games[0], self.arena.state.pieces[0], self.arena.world.rules[0]
        points = {camp: int(points_value(game, camp)) for camp in SIDES}
        blood = {camp: int(own_total(game, pieces, camp, rules)) - points[camp] for camp in SIDES}
        return {
            camp: (points[camp] - points[enemy_of(camp)], blood[camp], -blood[enemy_of(camp)])
            for camp in SIDES
        }
