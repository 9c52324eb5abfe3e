"""How a player plays, counted over recorded games: tasks by phase, targets, moves, places (IV-B, IV-C, IV-D, Fig. 8)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.legal import Advisor
from hexwar_sb3.engine.orders import GuideShoot, Move, Order, Shoot
from hexwar_sb3.engine.record import Line
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.roster import enemy_of, parse_camp
from hexwar_sb3.errors import ReplayFileError
from hexwar_sb3.evaluation.intervals import Estimate, ratio_interval
from hexwar_sb3.maps.geometry import DIRECTION_NAMES, direction_between
from hexwar_sb3.rules.enums import Camp, PieceType
from hexwar_sb3.rules.indices import CellIndex, PieceIndex
from hexwar_sb3.tasks.travel import next_direction

PHASES = ("deployment", "preemption", "endgame")
"""Until more than half of the enemies were seen; then; from the first capture of either camp on (IV-B)."""
STOP, GRID, PIECE = "stop", "grid task", "piece task"
_GRID = ("hold", "hide", "drop")
TYPES = tuple(kind.name.lower() for kind in PieceType)
LEAST_SHARE = 0.8  # of moves as the heuristic's, IV-D
LEAST_GAMES = 20  # that tell of a claim, before anything is said of it


def group_of(task: str) -> str:
    """Whether a task ("hold 1134") is one of a cell or of a piece."""
    kind = task.split(maxsplit=1)[0]
    return STOP if kind == STOP else GRID if kind in _GRID else PIECE


@dataclass
class PlayStats:
    """Counts over games of one player, in either colour.

    Example:
        >>> from hexwar_sb3.play import record_game
        >>> stats = PlayStats()
        >>> stats.add(record_game("HRL0", "MA2", seed=3), "red")
        >>> stats.games, sorted({phase for phase, _, _ in stats.tasks})
        (1, ['deployment', 'endgame'])
    """

    games: int = 0
    tasks: Counter[tuple[str, str, str]] = field(default_factory=Counter)  # phase, piece type, kind of task
    targets: Counter[tuple[str, str]] = field(
        default_factory=Counter
    )  # shooter, target; first half of the game
    # the same, each shot shared evenly among all targets that it could have had
    available: dict[tuple[str, str], float] = field(default_factory=dict)
    blood: list[float] = field(
        default_factory=list
    )  # of the target less the mean of the available ones, by shot
    value: list[float] = field(default_factory=list)  # likewise, points a blood
    moves: Counter[str] = field(default_factory=Counter)  # hops towards the cell of a task, by piece type
    agreeing: Counter[str] = field(default_factory=Counter)  # of them as the heuristic's
    visits: Counter[str] = field(default_factory=Counter)  # cells that its ground pieces came into
    kills: Counter[str] = field(default_factory=Counter)  # cells where enemies were destroyed
    counts: dict[str, list[tuple[float, float]]] = field(
        default_factory=dict
    )  # by claim: part and whole of each game

    def add(self, replay: Replay, camp: str) -> None:
        """Count one more game, in which the player had this camp.

        Raises:
            ReplayFileError: the replay holds no decisions of it; or the record is one camp's own.
        """
        if not any(line["type"] == "decision" and line["camp"] == camp for line in replay.lines):
            raise ReplayFileError(
                replay.source,
                "file",
                found=f"no decisions of {camp}",
                expected="a replay of version 2 with them",
            )
        one = PlayStats(games=1)
        watch = _Watch(one, parse_camp(camp))
        try:
            for line, game in replay.played_again():
                watch.look(line, game)
        except (LookupError, ValueError) as error:  # an arrival without a cell, a task that is none
            found, expected = f"{type(error).__name__}: {error}", "events and tasks of pieces on the map"
            raise ReplayFileError(replay.source, "events", found=found, expected=expected) from error
        one.counts = {words: [counts] for words, counts, _ in one._counted()}
        self.merge(one)

    def merge(self, other: PlayStats) -> None:
        """Take in the counts of another."""
        self.games += other.games
        for name in ("tasks", "targets", "moves", "agreeing", "visits", "kills"):
            getattr(self, name).update(getattr(other, name))
        for key, share in other.available.items():
            self.available[key] = self.available.get(key, 0.0) + share
        self.blood += other.blood
        self.value += other.value
        for words, counts in other.counts.items():
            self.counts.setdefault(words, []).extend(counts)

    def decisions(self, phase: str, *types: str) -> Counter[str]:
        """Numbers of grid and of piece tasks in a phase, of some piece types or all."""
        counts: Counter[str] = Counter()
        for (when, piece, kind), count in self.tasks.items():
            if when == phase and (piece in types or not types):
                counts[group_of(kind)] += count
        return counts

    def _counted(self) -> Iterator[tuple[str, tuple[float, float], float]]:
        """Claims: words, part and whole, and the least ratio of them with which the claim holds."""
        for words, group, counts in (
            ("deployment: grid tasks", GRID, self.decisions(PHASES[0])),
            ("preemption: chariots and aerocraft pick piece tasks", PIECE, self.decisions(PHASES[1], "chariot", "aerocraft")),
            ("endgame: piece tasks", PIECE, self.decisions(PHASES[2])),
        ):  # fmt: skip
            yield words, (counts[group], counts[GRID] + counts[PIECE]), 0.5
        yield "moves as the heuristic's", (self.agreeing.total(), self.moves.total()), LEAST_SHARE
        yield (
            "blood of targets, less the mean of the available ones",
            (-sum(self.blood), len(self.blood)),
            0.0,
        )
        yield "value of targets, less the mean of the available ones", (sum(self.value), len(self.value)), 0.0

    def claims(self) -> Iterator[tuple[str, Estimate, bool | None]]:
        """What the paper says of its best commander, the figure here with its interval over games, and whether it holds.

        It does where the whole interval is above the bar (below 0 for the blood of targets), it does not where all of it
        is on the other side; else, and with less than 20 games that tell of it, it is open (None).
        """
        for words, _, least in self._counted():
            parts, wholes = zip(*self.counts.get(words, [(0, 0)]), strict=True)
            found = ratio_interval(parts, wholes)
            told = sum(whole > 0 for whole in wholes) >= LEAST_GAMES
            verdict = True if found.low > least else False if found.high < least else None
            lower = words.startswith("blood")
            yield (
                words,
                Estimate(-found.value, -found.high, -found.low) if lower else found,
                verdict if told else None,
            )

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "games": self.games,
            "tasks": [[*key, count] for key, count in sorted(self.tasks.items())],
            "targets": [[*key, count, round(self.available.get(key, 0.0), 1)] for key, count in sorted(self.targets.items())],
            "moves": {kind: [self.agreeing[kind], count] for kind, count in sorted(self.moves.items())},
            "visits": dict(self.visits.most_common()),
            "kills": dict(self.kills.most_common()),
            "claims": [[words, found.value, found.low, found.high, holds] for words, found, holds in self.claims()],
        }  # fmt: skip


class _Watch:
    """Follows one game for the counts of one camp."""

    def __init__(self, stats: PlayStats, camp: Camp) -> None:
        self.stats, self.camp = stats, camp
        self.doing: dict[str, str] = {}  # task of each piece
        self.seen = np.uint32(0)
        self.captured = False

    def look(self, line: Line, game: Game) -> None:
        """Count what a line says."""
        kind, own = line["type"], line.get("camp") == self.camp.name.lower()
        if kind == "decision" and own:
            self._decision(line, game)
        elif kind == "orders" and own:
            self._orders(line, game)
        elif kind == "event":
            self._event(line, game)

    def _phase(self, game: Game) -> str:
        if self.captured:
            return PHASES[2]
        enemies = game.roster.pieces_of(enemy_of(self.camp))
        memory = game.state.memory[0, self.camp]
        known = sum(int(memory[i].cell) >= 0 for i in enemies)
        return PHASES[1] if 2 * known > len(enemies) else PHASES[0]

    def _type(self, game: Game, i: PieceIndex) -> str:
        return TYPES[int(game.pieces[i].kind)]

    def _decision(self, line: Line, game: Game) -> None:
        phase = self._phase(game)
        for piece, chosen, tasks, *_ in line["choices"]:
            kind = self._type(game, game.roster.own_index(self.camp, piece))
            self.doing[piece] = tasks[chosen]
            self.stats.tasks[phase, kind, tasks[chosen].split()[0]] += 1

    def _orders(self, line: Line, game: Game) -> None:
        advisor: Advisor | None = None
        for order in map(Order.parse, line["orders"]):
            i = game.roster.own_index(self.camp, order.piece)
            if isinstance(order, Shoot | GuideShoot):
                if advisor is None:
                    advisor = Advisor(
                        self.camp, game.state.games[0], game.pieces, game.state.memory[0], game.world
                    )
                self._shot(
                    i, game.roster.index_in(enemy_of(self.camp), order.target), advisor.targets(i), game
                )
            elif isinstance(order, Move):
                self._move(i, order, game)

    def _shot(self, i: PieceIndex, target: PieceIndex, could: list[PieceIndex], game: Game) -> None:
        stats, pieces, value = self.stats, game.pieces, game.world.rules[0].value
        if game.tick * 2 < int(game.state.games[0].end_tick):
            stats.targets[self._type(game, i), self._type(game, target)] += 1
            for other in could:
                key = self._type(game, i), self._type(game, other)
                stats.available[key] = stats.available.get(key, 0.0) + 1 / len(could)
        if len(could) > 1:
            bloods = [int(pieces[j].blood) for j in could]
            values = [int(value[pieces[j].kind]) for j in could]
            stats.blood.append(int(pieces[target].blood) - float(np.mean(bloods)))
            stats.value.append(int(value[pieces[target].kind]) - float(np.mean(values)))

    def _move(self, i: PieceIndex, order: Move, game: Game) -> None:
        """A hop of a piece that was told to go to a cell: is it the heuristic's?"""
        task = self.doing.get(game.roster.short(i), STOP)
        aim = task.partition(" ")[2]
        if group_of(task) != GRID or not order.path or not aim:  # some of a random player's lead nowhere
            return
        world, piece = game.world, game.pieces[i]
        goal, here = game.roster.cell(aim), CellIndex(piece.cell)
        best = next_direction(
            piece.kind, piece.camp, here, goal, False, world.rules[0], world.cells, world.eta
        )
        step = order.path[0]
        taken = (
            DIRECTION_NAMES.index(step)
            if step in DIRECTION_NAMES
            else direction_between(world.cells, here, game.roster.cell(step))
        )
        kind = self._type(game, i)
        self.stats.moves[kind] += 1
        self.stats.agreeing[kind] += int(taken == best)

    def _event(self, line: Line, game: Game) -> None:
        own = line["piece"].startswith(f"{self.camp.name.lower()}:")
        if line["kind"] == "occupied":
            self.captured = True
        elif line["kind"] == "arrived" and own and "aerocraft" not in line["piece"]:
            self.stats.visits[line["cell"]] += 1
        elif line["kind"] == "dead" and not own:
            self.stats.kills[line["cell"]] += 1
