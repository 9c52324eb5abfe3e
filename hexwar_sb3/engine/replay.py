"""Replays `*.hwr`: a whole game in one small file that stands alone and can be played again.

Lines: `head` (rules, scenario with its map, seed, players), then in the order of the game
`orders`, `edit`, `event` and, every 75 ticks, `state` with a hash; last `end`. Head, orders and
edits alone make the same game again; `verify` does so and compares every state.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from hexwar_sb3.engine.edit import Editor
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import GameEvent
from hexwar_sb3.engine.known_events import known_lines
from hexwar_sb3.engine.orders import Order
from hexwar_sb3.engine.record import Line, Recorder, state_hash, state_line
from hexwar_sb3.engine.replay_file import content_hash, fail, read_lines, write_lines
from hexwar_sb3.engine.replay_lines import SINCE_2, checked
from hexwar_sb3.engine.roster import SIDES, Roster, camp_name
from hexwar_sb3.engine.score import margin, own_total
from hexwar_sb3.engine.state import State
from hexwar_sb3.errors import FileFormatError, HexWarError, ReplayFileError
from hexwar_sb3.kinds import read_fields
from hexwar_sb3.maps.document import Document, shown
from hexwar_sb3.maps.files import scenario_from_document
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.maps.scenario_file import scenario_document
from hexwar_sb3.rules import RuleSet, default_rules
from hexwar_sb3.rules.tables import AEROCRAFT
from hexwar_sb3.version import __version__

FORMAT = "hexwar-replay"
FORMAT_VERSION = 2  # 1 has no lines of what was decided and known
MAX_SEED = 2**64 - 1
MOST_WORD, MOST_COMMAND = 80, 1_000  # characters
_HEAD = ("type", "format", "version", "rules", "scenario")
_OPEN = ("type", "format", "version", "players")  # of the head, in a camp's own record
_PLAYED = frozenset({"orders", "edit", "state"})
_NAMES = ("piece", "target", "shooter")  # of pieces, in an event
_OF_A_PLAYER = frozenset({"hash", "hints"})  # that the other side does not know


@dataclass(frozen=True, kw_only=True)
class PlayerName:
    """Who played a camp."""

    name: str
    kind: str = "human"  # human, bot, policy or random
    hash: str | None = None  # of the policy's weights, or of what all bots do
    hints: int | None = None  # of a policy, that a person asked for in the game

    def as_dict(self) -> dict[str, Any]:
        """The fields that are known."""
        known = {"name": self.name, "kind": self.kind, "hash": self.hash, "hints": self.hints}
        return {key: value for key, value in known.items() if value is not None}


@dataclass(frozen=True)
class Replay:
    """One recorded game; its lines are checked when it is made, also by hand.

    Raises:
        ReplayFileError: a line has other keys or values than `replay_lines.LINES` says, or there are too many.

    Example:
        >>> game = Game("plain", seed=0)
        >>> Replay.of(game).save("game.hwr")
        >>> Replay.load("game.hwr").verify()
    """

    lines: tuple[Line, ...]
    source: Path = Path("replay")  # named in messages

    def __post_init__(self) -> None:
        object.__setattr__(self, "lines", checked(self.lines, self.source))
        self._check_head()

    @property
    def head(self) -> Line:
        """Rules, scenario, seed, players."""
        return self.lines[0]

    @property
    def end(self) -> Line:
        """Score and winner."""
        return self.lines[-1]

    @property
    def events(self) -> list[Line]:
        """Everything that happened, in order."""
        return [line for line in self.lines if line["type"] == "event"]

    @property
    def states(self) -> list[Line]:
        """The state every 75 ticks and at the end."""
        return [line for line in self.lines if line["type"] == "state"]

    @classmethod
    def of(cls, game: Game, red: PlayerName | None = None, blue: PlayerName | None = None) -> Replay:
        """The replay of a game as far as it was played."""
        return cls.recorded(game.recorder, game.state, 0, game.seed, red, blue)

    @classmethod
    def recorded(
        cls,
        recorder: Recorder,
        state: State,
        b: int,
        seed: int,
        red: PlayerName | None = None,
        blue: PlayerName | None = None,
        command: str | None = None,
    ) -> Replay:
        """The replay of game b of a batch that a recorder looked on, and what made it, as one would type it."""
        players = {camp_name(camp): player for camp, player in zip(SIDES, (red, blue), strict=True)}
        head = _head(recorder, seed, players) | ({"command": command[:MOST_COMMAND]} if command else {})
        lines = [head, *recorder.lines, *_last_lines(recorder, state, b)]
        return cls((*lines, _end_line(recorder, state, b) | {"sha256": content_hash(lines)}))

    # --- files -----------------------------------------------------------------------------------

    def save(self, path: str | Path) -> None:
        """Write the file, whole or not at all."""
        write_lines(Path(path), self.lines)

    @classmethod
    def load(cls, path: str | Path) -> Replay:
        """Read a file and check that it is whole and of these rules.

        Raises:
            ReplayFileError: names the place, what was found and what was expected.
        """
        replay = cls(read_lines(Path(path)), Path(path))  # type: ignore[arg-type]  # checked as they come
        if replay.camp is None:
            found, expected = replay.end.get("sha256"), content_hash(replay.lines[:-1])
            if found != expected:
                replay._fail("end.sha256", shown(found), f"{expected!r}: the file was changed")
            replay.ruleset()
        replay._check_names(replay.scenario())
        return replay

    def _check_head(self) -> None:
        head = self._document(self.head, "head")
        head.has(*_HEAD)
        head.choice("format", (FORMAT,))
        version = head.integer("version", 1, FORMAT_VERSION)
        self._check_kinds(version)
        rules, scenario = (self._document(self.head[key], f"head.{key}") for key in ("rules", "scenario"))
        scenario.has("map")
        self._document(scenario.data["map"], "head.scenario.map")
        if self.camp is not None:
            head.choice("camp", tuple(map(camp_name, SIDES)))
            head.only((*_HEAD, "camp"), ("players", "created"))
            rules.only(("version",))
        else:
            head.only((*_HEAD, "seed"), ("players", "software", "created", "command"))
            head.integer("seed", 0, MAX_SEED)
            self._document(self.end, "end").has("margin", "winner", "sha256")
        for key, limit in (("software", MOST_WORD), ("created", MOST_WORD), ("command", MOST_COMMAND)):
            if key in head.data:
                head.text(key, limit)
        self._check_players()

    def _check_kinds(self, version: int) -> None:
        for number, line in enumerate(self.lines, start=1):
            if version == 1 and line["type"] in SINCE_2:
                self._fail(f"line {number}", shown(line["type"]), "a line of version 1, as the head says")
            if line["type"] == "known" and self.camp is None:
                self._fail(f"line {number}", '"known"', "a line of a whole replay")
            if line["type"] == "decision":
                self._check_decision(line, f"line {number}, decision")

    def _check_decision(self, line: Line, place: str) -> None:
        if self.camp is None and "reward" not in line:
            self._fail(place, "no 'reward'", "one, as in every whole replay")
        if self.camp is not None and (line["camp"] != self.camp or "reward" in line):
            self._fail(place, "what the camp does not know", f"choices of {self.camp}, without a reward")
        if len({choice[0] for choice in line["choices"]}) < len(line["choices"]):
            self._fail(place, "a piece twice", "one choice a piece")

    def _check_players(self) -> None:
        players = self._document(self.head.get("players", {}), "head.players")
        players.only((), tuple(map(camp_name, SIDES)))
        for camp, player in players.data.items():
            read_fields(PlayerName, player, self.source, ReplayFileError, f"head.players.{camp}")

    def _check_names(self, scenario: Scenario) -> None:
        """Events and states are of pieces and cells of the scenario, and within its time."""
        names, cells = Roster(scenario).names, frozenset(_cells_of(scenario))
        known = {**dict.fromkeys(_NAMES, frozenset(names)), "cell": cells}
        for number, line in enumerate(self.lines[1:], start=2):
            if line["tick"] > scenario.game_ticks:
                self._fail(f"line {number}.tick", str(line["tick"]), f"at most {scenario.game_ticks}")
            if line["type"] == "event":
                for key, allowed in known.items():
                    if key in line and line[key] not in allowed:
                        self._fail(f"line {number}, event.{key}", shown(line[key]), "a name of the scenario")
            elif line["type"] == "decision":
                if not {f"{line['camp']}:{choice[0]}" for choice in line["choices"]} <= set(names):
                    self._fail(f"line {number}, decision", "another piece", f"pieces of {line['camp']}")
            elif line["type"] == "known":
                places = {piece[1] for piece in line["pieces"]} - {None}
                places |= {*line.get("bursting", ()), *line.get("fights", ())}
                if not ({piece[0] for piece in line["pieces"]} <= set(names) and places <= cells):
                    self._fail(f"line {number}, known", "other names", "pieces and cells of the scenario")
            elif line["type"] == "state":
                found = tuple(piece[0] for piece in line["pieces"])
                where = {piece[1] for piece in line["pieces"]} - {None}
                if found != names or not where <= cells or len(line["owners"]) != len(scenario.points):
                    self._fail(
                        f"line {number}, state", "other names", "pieces, cells and points of the scenario"
                    )

    @property
    def camp(self) -> str | None:
        """The camp whose own record this is; None for a whole replay."""
        return self.head.get("camp")

    def _fail(self, place: str, found: str, expected: str) -> None:
        fail(self.source, place, found, expected)

    def _document(self, line: Any, place: str) -> Document:
        return Document(line, str(self.source), ReplayFileError, place)

    # --- what the head says ----------------------------------------------------------------------

    @property
    def seed(self) -> int:
        """Of all dice."""
        return int(self.head["seed"])

    def scenario(self) -> Scenario:
        """The scenario with its map.

        Raises:
            ReplayFileError: it cannot be used, or is not what its hash says.
        """
        try:
            return scenario_from_document(self.head["scenario"], str(self.source))
        except FileFormatError as error:
            place = f"head.scenario, {error.place}"
            problem = ReplayFileError(self.source, place, found=error.found, expected=error.expected)
            raise problem from error

    def ruleset(self) -> RuleSet:
        """The rules of the game, if they are the rules of this software.

        Raises:
            ReplayFileError: other rules.
        """
        rules = self._document(self.head["rules"], "head.rules")
        rules.only(("version", "hash", "aerocraft"))
        ruleset = default_rules().with_aerocraft(rules.choice("aerocraft", tuple(AEROCRAFT)))
        if rules.text("hash") != ruleset.hash:
            found = f"{shown(self.head['rules']['hash'])} (version {rules.text('version')})"
            expected = f'"{ruleset.hash}" (version {ruleset.version})'
            self._fail("head.rules.hash", found, f"{expected}: these are other rules")
        return ruleset

    # --- playing it again ------------------------------------------------------------------------

    def verify(self) -> None:
        """Play the game again from head, orders and edits, and compare every state and every event.

        Raises:
            ReplayFileError: the first line that differs or cannot be played.
        """
        game = self._new_game()
        for number, line in enumerate(self.lines[:-1], start=1):
            self._follow(game, line, number)
            if line["type"] == "state" and state_hash(game.state, 0) != line["hash"]:
                found = f'"{state_hash(game.state, 0)}" when played again'
                self._fail(f"line {number}, state of tick {line['tick']}", found, shown(line["hash"]))
        again = _end_line(game.recorder, game.state, 0)
        if again != {key: value for key, value in self.end.items() if key != "sha256"}:
            self._fail("end", shown(again), f"{shown(self.end)} as in the file")
        self._compare([*game.recorder.lines, *_last_lines(game.recorder, game.state, 0)])

    def _compare(self, again: list[Line]) -> None:
        """Compare events and states with those of the game that was played again."""
        for kind in ("event", "state"):
            own = [(number, line) for number, line in enumerate(self.lines, start=1) if line["type"] == kind]
            lines = [line for line in again if line["type"] == kind]
            for (number, line), other in zip(own, lines, strict=False):
                if line != other:
                    self._fail(f"line {number}", f"{shown(other)} when played again", shown(line))
            if len(own) != len(lines):
                self._fail(
                    "file", f"{len(lines)} lines of {kind} when played again", f"{len(own)} as in the file"
                )

    def played_again(self) -> Iterator[tuple[Line, Game]]:
        """Play the game again: each line after the head, with the game as it stood before the line does anything.

        Raises:
            ReplayFileError: a line cannot be played; or the record is one camp's own.
        """
        game = self._new_game()
        for number, line in enumerate(self.lines[1:], start=2):
            game.advance(line["tick"] - game.tick)
            yield line, game
            self._follow(game, line, number)

    def game_at(self, tick: int) -> Game:
        """The game as it stood at a tick, ready to be played on in another way."""
        game = self._new_game()
        for number, line in enumerate(self.lines[1:], start=2):
            if line["tick"] > tick or (line["tick"] == tick and line["type"] != "edit"):
                break
            self._follow(game, line, number)
        game.advance(max(0, tick - game.tick))
        return game

    def ticks(self) -> Iterator[tuple[Game, list[GameEvent]]]:
        """Play it again tick by tick: the game as it stands at each tick, and the events that led there.

        It is one game that goes on; a caller that wants to keep something of it copies that.
        """
        game, events = self._new_game(), list[GameEvent]()
        acts = deque(
            (n, line) for n, line in enumerate(self.lines, start=1) if line["type"] in {"orders", "edit"}
        )
        while True:
            while acts and acts[0][1]["tick"] == game.tick:
                number, line = acts.popleft()
                self._follow(game, line, number)
            yield game, events
            if game.over or game.tick >= self.end["tick"]:
                return
            events = game.advance(1)

    def _new_game(self) -> Game:
        if self.camp is not None:
            self._fail("head", f"the record of {self.camp} only", "a whole replay")
        return Game(self.scenario(), self.seed, self.ruleset())

    def _follow(self, game: Game, line: Line, number: int) -> None:
        """Bring the game to this line, and do what it says."""
        if line["type"] not in _PLAYED:
            return
        end_tick = game.world.scenario.game_ticks
        place = self._document(line, f"line {number}")
        game.advance(place.integer("tick", game.tick, end_tick) - game.tick)
        try:
            if line["type"] == "orders":
                orders = [Order.parse(text) for text in line["orders"]]
                game.submit(line["camp"], orders, strict=False)
            elif line["type"] == "edit":
                editor = Editor(
                    game.state, game.world
                )  # without the way back of `game.edit`: an error ends it all
                for who, field, value in line["changes"]:
                    editor.apply((who, field, value))
                editor.finish()
                game.recorder.note_edit(game.tick, editor.changes)
        except HexWarError as error:
            self._fail(f"line {number}", str(error), f"{line['type']} that can be played again")

    # --- one camp's own file ---------------------------------------------------------------------

    def for_camp(self, camp: str) -> Replay:
        """What one camp may see of it: no seed, hashes, enemy orders, true score, final margin or date.

        Games that differ only in what the camp did not see have equal records. The scenario is known to both camps, and with
        it where all pieces began.
        """
        head: Line = {key: self.head[key] for key in _OPEN if key in self.head}
        players = self.head.get("players", {}).items()
        head["players"] = {
            side: {k: v for k, v in player.items() if k not in _OF_A_PLAYER} for side, player in players
        }
        scenario = {key: value for key, value in self.head["scenario"].items() if key != "hash"}
        scenario["map"] = {k: v for k, v in scenario["map"].items() if k not in {"hash", "seed"}}
        head |= {
            "version": FORMAT_VERSION,
            "camp": camp,
            "rules": {"version": self.head["rules"]["version"]},
            "scenario": scenario,
        }
        return Replay((head, *known_lines(camp, self._new_game(), self.lines, self._follow)), self.source)


def _cells_of(scenario: Scenario) -> Iterator[str]:
    """Names of all cells of its map."""
    hexmap = scenario.hexmap
    return (hexmap.cell_name(cell) for cell in range(hexmap.n_cells) if hexmap.playable.flat[cell])


def _head(recorder: Recorder, seed: int, players: dict[str, PlayerName | None]) -> Line:
    world = recorder.world
    named = {camp: player or PlayerName(name="unknown") for camp, player in players.items()}
    return {
        "type": "head",
        "format": FORMAT,
        "version": FORMAT_VERSION,
        "rules": {
            "version": world.ruleset.version,
            "hash": world.ruleset.hash,
            "aerocraft": world.ruleset.aerocraft.name,
        },
        "scenario": scenario_document(world.scenario),
        "seed": seed & MAX_SEED,
        "players": {camp: player.as_dict() for camp, player in named.items()},
        "software": __version__,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def _last_lines(recorder: Recorder, state: State, b: int) -> list[Line]:
    """The states that are still to be written, the last of them at the present tick."""
    tick, states = int(state.games[b].tick), recorder.copy()
    states.note_states(state, b, tick)
    lines = states.lines[len(recorder.lines) :]
    if not states.lines or states.lines[-1]["tick"] < tick or states.lines[-1]["type"] != "state":
        lines.append(state_line(state, b, tick, recorder.world, recorder.roster))
    return lines


def _end_line(recorder: Recorder, state: State, b: int) -> Line:
    game, pieces, rules = state.games[b], state.pieces[b], recorder.world.rules[0]
    margins = {camp_name(camp): int(margin(game, pieces, camp, rules)) for camp in SIDES}
    lead = margins["red"] - margins["blue"]
    winner = "draw" if lead == 0 else "red" if lead > 0 else "blue"
    return {
        "type": "end",
        "tick": int(game.tick),
        "over": bool(game.over),
        "own": {camp_name(camp): int(own_total(game, pieces, camp, rules)) for camp in SIDES},
        "margin": margins,
        "winner": winner if game.over else None,
    }
