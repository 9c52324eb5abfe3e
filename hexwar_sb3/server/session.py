"""One game of a person against an opponent: what may be asked, and what is told (formats/play.md). No network.

What is told is made of the camp's views, its orders and their results. The referee's state is read for the end alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path as File
from typing import Any, Literal

from hexwar_sb3.engine.orders import Order
from hexwar_sb3.engine.replay import PlayerName, Replay
from hexwar_sb3.engine.replay_file import SUFFIX, UNDER_WAY
from hexwar_sb3.engine.roster import camp_name, enemy_of
from hexwar_sb3.errors import ConfigError, HexWarError, OrderError, ReplayFileError
from hexwar_sb3.maps.files import scenario_from_document
from hexwar_sb3.maps.scenario import ScenarioLike
from hexwar_sb3.maps.scenario_file import scenario_document
from hexwar_sb3.play.game import Game
from hexwar_sb3.play.recording import player_name
from hexwar_sb3.players.player import given_name, make_player
from hexwar_sb3.server.advice import look_at, path_to
from hexwar_sb3.server.clock import Clock
from hexwar_sb3.server.delta import frozen, new_in
from hexwar_sb3.server.hints import Adviser
from hexwar_sb3.server.ladder import Ladder, Played
from hexwar_sb3.server.messages import (
    ONLY_LOOKS,
    VERSION,
    Cancel,
    Finish,
    Hint,
    Look,
    Path,
    Pause,
    PlanFor,
    Question,
    Run,
    SetStops,
    StepTo,
    Undo,
)
from hexwar_sb3.server.partial import ClockLine, Head, HintLine, Line, OrdersLine, Partial
from hexwar_sb3.server.person import PERSON
from hexwar_sb3.server.seat import PersonSeat, Refused
from hexwar_sb3.server.stops import Stops, Watcher
from hexwar_sb3.viewer.camp_story import CampTeller
from hexwar_sb3.viewer.map_block import map_block
from hexwar_sb3.viewer.story import NAME_CHARACTERS, common_part

COMMANDS, READS = "commands", "reads along"
Json = dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Setup:
    """What a game is made of.

    opponent, hints: players as `make_player` takes them, by name or folder.
    """

    opponent: str = "MA2"
    scenario: ScenarioLike = "plain"
    side: str = "red"
    seed: int = 0
    player: str = PERSON  # what the person is called
    hints: str | None = None
    name: str = "game"
    folder: File = File("play")
    ladder: Ladder | None = None  # on which the opponent stands
    command: str | None = None  # what made it, as one would type it


class Session:
    """The game, the person's plans and clock, and what the person was told.

    Args:
        setup: of the game.
        record: where it is kept; None: nowhere.

    Raises:
        UnknownNameError, ConfigError, HexWarError: there is no such scenario or player, or it is for other games.
    """

    def __init__(self, setup: Setup, record: Partial | None = None) -> None:
        self.setup, self.record = setup, record
        self.game = Game(setup.scenario, setup.seed, opponent=setup.opponent, side=setup.side)
        self.camp = camp_name(self.game.side)
        self.seat, self.clock, self.stops = PersonSeat(self.game, self.camp), Clock(), Stops()
        self.opponent = _opponent(setup)
        self.adviser = None
        if setup.hints is not None:
            name = given_name(setup.hints) or setup.hints
            self.adviser = Adviser(setup.hints, name, self.game, self.camp)
        self.hints_used = 0
        self.replay: Replay | None = None  # once the game is over
        self._teller = CampTeller(self.camp, self.game.roster)
        self._teller.look(self.game, [])
        self._watcher = Watcher(self._teller.view, ())
        self._common = common_part(self._players(), self.game.world)
        self._told = self._story()

    # --- what is told ----------------------------------------------------------------------------

    def hello(self, role: str = COMMANDS) -> Json:
        """The first message: all that the camp knows."""
        scenario = self.game.world.scenario
        return {
            "say": "hello",
            "version": VERSION,
            "role": role,
            "camp": self.camp,
            "name": self.setup.name,
            "opponent": self.opponent.name[:NAME_CHARACTERS],
            "scenario": scenario.name[:NAME_CHARACTERS],
            "map": map_block(scenario.hexmap),
            "story": self._told,
            **self.state(),
            "ladder": self._ladder(),
            "over": self.over() if self.replay is not None else None,
        }

    def state(self) -> Json:
        """Clock and plans, whole."""
        clock, game = self.clock, self.game
        return {
            "clock": {
                "tick": game.tick,
                "end": game.world.scenario.game_ticks,
                "running": clock.running,
                "speed": clock.speed,
                "over": game.over,
            },
            "stops": self.stops.as_dict(),
            "tray": self.seat.tray(),
            "plans": self.seat.told(),
            "undo": self.seat.undoes,
            "hints": {"policy": self.adviser.name if self.adviser else None, "used": self.hints_used},
        }

    def now(self, stopped: str | None = None, refused: Sequence[Refused] = ()) -> Json:
        """What is new since the last message."""
        story = self._story()
        news, self._told = new_in(self._told, story), story
        told = [list(one) for one in refused]
        return {"say": "now", "story": news, **self.state(), "stopped": stopped, "refused": told}

    def over(self) -> Json:
        """How the game ended: the first thing that is told of what the camp does not know.

        Raises:
            OrderError: it is not over.
        """
        if self.replay is None:
            raise OrderError("the game is not over; its result is told at the end")
        margins = self.replay.end["margin"]
        return {
            "say": "over",
            "result": self._result(self.replay),
            "margin": margins,
            "hints": self.hints_used,
            "after": "/after",
            "replay": "/replay",
            "file": self.file.name,
            "ladder": self._ladder(),
        }

    def _result(self, replay: Replay) -> Literal["won", "drawn", "lost"]:
        winner = replay.end["winner"]
        return "drawn" if winner == "draw" else "won" if winner == self.camp else "lost"

    def _ladder(self) -> Json | None:
        return None if self.setup.ladder is None else self.setup.ladder.told()

    def _story(self) -> Json:
        document = self._common | self._teller.document(self.game.recorder.lines)
        return dict(frozen(document))

    # --- what is asked ---------------------------------------------------------------------------

    def answer(self, question: Question, role: str = COMMANDS) -> tuple[Json, bool]:
        """The fields of an answer, and whether anything changed.

        Raises:
            HexWarError: it is refused; nothing changed.
        """
        if role != COMMANDS and not isinstance(question, ONLY_LOOKS):
            raise OrderError("this page reads along; another one gives the orders")
        match question:
            case Look(piece, at):
                return look_at(self.game, self.camp, piece, at), False
            case Path(piece, to, start):
                return path_to(self.game, self.camp, piece, to, start), False
            case Hint(piece):
                return self._hint(piece), True
            case SetStops():
                self.stops = Stops(question.first_sight, question.own_loss, question.idle)
            case Pause():
                self.clock.stop()
            case PlanFor() | Undo() | Cancel():
                self._replan(question)
            case Run() | StepTo() | Finish():
                self._start(question)
        return {}, True

    def _replan(self, question: PlanFor | Undo | Cancel) -> None:
        self._check_open()
        match question:
            case PlanFor(piece, steps, then):
                self.seat.plan(piece, steps, then=then)
            case Cancel(piece):
                self.seat.cancel(piece)
            case Undo():
                self.seat.undo()
        self._keep_clock()

    def _start(self, question: Run | StepTo | Finish) -> None:
        self._check_open()
        match question:
            case Run(speed):
                self.clock.run(speed)
            case StepTo(to):
                self.clock.step(to, self.game.tick)
            case Finish():
                self.seat.plans = {}
                self.clock.finish()

    def _check_open(self) -> None:
        if self.game.over:
            raise OrderError(f"the game is over since tick {self.game.tick}; no order is taken any more")

    def _hint(self, piece: str) -> Json:
        if self.adviser is None:
            raise OrderError("no policy gives hints in this game; `hexwar play --hints HRL0` has one")
        self._check_open()
        told = self.adviser.hint(piece)
        self.hints_used += 1
        self._write(HintLine(tick=self.game.tick, piece=piece))
        return told | {"used": self.hints_used}

    # --- the clock -------------------------------------------------------------------------------

    def advance(self) -> Json:
        """Play the ticks to the next message; the message."""
        refused, said = list[Refused](), list[str]()
        for _ in range(self.clock.batch):
            if not self.clock.running:
                break
            new_refused, said = self._tick()
            refused += new_refused
        self._keep_clock()
        if self.game.over and self.replay is None:
            self._end()
        return self.now("; ".join(said) or None, refused)

    def _tick(self) -> tuple[list[Refused], list[str]]:
        """One tick; what was refused in it, and why the clock stopped."""
        orders, refused = self._due()
        self.game.submit(self.camp, orders, strict=False)
        n_events = len(self._teller.events)
        refused += self._step()
        for one in refused:
            self.seat.drop(one.piece)
        said = self._watcher.look(self._teller.view, self.seat.plans, self.stops)
        said += [f"{one.order} was refused: {one.why}" for one in refused]
        is_event = bool(said) or len(self._teller.events) > n_events
        if self.clock.finishing:
            said = []
        self._stop_where_due(is_event=is_event, stopped=bool(said))
        return refused, said

    def _due(self) -> tuple[list[Order], list[Refused]]:
        """What is due, and kept before it is played.

        Raises:
            OSError: it cannot be kept; then nothing was due.
        """
        plans = self.seat.plans
        orders, refused = self.seat.due()
        if orders:
            given = tuple(map(str, orders))
            try:
                self._write(OrdersLine(tick=self.game.tick, orders=given, plans=self.seat.kept()))
            except OSError:
                self.seat.plans = plans
                raise
        return orders, refused

    def _stop_where_due(self, *, is_event: bool, stopped: bool) -> None:
        clock = self.clock
        reached = clock.until is not None and self.game.tick >= clock.until
        if stopped or reached or self.game.over or (clock.to_event and is_event):
            clock.stop()

    def _step(self) -> list[Refused]:
        """One tick of the game, looked at; own orders that the engine refused in it."""
        lines = self.game.recorder.lines
        n_lines = len(lines)
        events = self.game.advance(1)
        self._teller.look(self.game, events)
        own = [line for line in lines[n_lines:] if line["type"] == "orders" and line["camp"] == self.camp]
        return [Refused(text.split()[0], text, why) for line in own for text, why in line["refused"]]

    def close(self) -> None:
        """Stop the clock; the file is kept, and free for who goes on."""
        self.clock.stop()
        if self.record is not None:
            self.record.close()

    # --- the files -------------------------------------------------------------------------------

    @property
    def file(self) -> File:
        """Where the whole replay is written."""
        return self.setup.folder / f"{self.setup.name}{SUFFIX}"

    def _players(self) -> dict[str, Json]:
        told = {
            self.camp: PlayerName(name=self.setup.player),
            camp_name(enemy_of(self.game.side)): self.opponent,
        }
        return {camp: player.as_dict() for camp, player in told.items()}

    def _write(self, line: Line) -> None:
        if self.record is not None:
            self.record.write(line)

    def _keep_clock(self) -> None:
        self._write(ClockLine(tick=self.game.tick, plans=self.seat.kept()))

    def _end(self) -> None:
        """Write the whole replay; what was kept on the way is no longer needed."""
        person, game = PlayerName(name=self.setup.player, hints=self.hints_used), self.game
        players = (person, self.opponent) if self.camp == "red" else (self.opponent, person)
        self.replay = Replay.recorded(game.recorder, game.state, 0, game.seed, *players, self.setup.command)
        if self.record is not None:
            self.replay.save(self.file)
            self._climb(self.replay)
            self.record.remove()

    def _climb(self, replay: Replay) -> None:
        """Write the game into the record of its ladder."""
        if self.setup.ladder is not None:
            played = Played(
                rung=self.setup.ladder.rung_of(self.setup.opponent).name,
                camp=self._side(),
                scenario=self.game.world.scenario.name,
                result=self._result(replay),
                margin=replay.end["margin"][self.camp],
                game=self.setup.name,
            )
            self.setup.ladder.note(played)

    def _side(self) -> Literal["red", "blue"]:
        return "red" if self.camp == "red" else "blue"

    def head(self) -> Head:
        """What the game is kept with."""
        return Head(
            scenario=scenario_document(self.game.world.scenario),
            rules=self.game.world.ruleset.hash,
            seed=self.setup.seed,
            camp=self._side(),
            player=self.setup.player,
            opponent=self.setup.opponent,
            opponent_hash=self.opponent.hash,
            hints=self.setup.hints,
        )

    def check(self, head: Head, source: File) -> None:
        """Check that this is the game of a file.

        Raises:
            ReplayFileError: the rules or the opponent are others now.
        """
        for name in ("rules", "opponent_hash"):
            found, expected = getattr(head, name), getattr(self.head(), name)
            if found != expected:
                raise ReplayFileError(source, f"head.{name}", found=repr(found), expected=repr(expected))

    def go_on(self, lines: Sequence[Line], source: File) -> None:
        """Play again what a file has of this game.

        Raises:
            ReplayFileError: a line that cannot be played.
        """
        plans: dict[str, tuple[str, ...]] = {}
        for number, line in enumerate(lines, start=2):
            try:
                self._follow(line)
                if not isinstance(line, HintLine):
                    plans = {piece: tuple(steps) for piece, steps in line.plans.items()}
                self.seat.restore(plans)
            except HexWarError as error:
                expected = "a line that can be played"
                raise ReplayFileError(
                    source, f"line {number}", found=str(error), expected=expected
                ) from error
        self._watcher = Watcher(self._teller.view, self.seat.plans)
        self._told = self._story()
        if self.game.over:
            self._end()

    def _follow(self, line: Line) -> None:
        if not self.game.tick <= line.tick <= self.game.world.scenario.game_ticks:
            raise OrderError(f"tick {line.tick} after tick {self.game.tick}")
        while self.game.tick < line.tick and not self.game.over:
            self._step()
        if isinstance(line, HintLine):
            self.hints_used += 1
        elif isinstance(line, OrdersLine):
            self.game.submit(self.camp, line.orders, strict=False)
            self._step()


def _opponent(setup: Setup) -> PlayerName:
    """What the opponent is called: as it was given, or by its rung."""
    told = player_name(setup.opponent, make_player(setup.opponent))
    return told if setup.ladder is None else replace(told, name=setup.ladder.rung_of(setup.opponent).name)


def new_session(setup: Setup) -> Session:
    """A game that begins, and is kept in its folder.

    Raises:
        ConfigError: there is one of that name already.
    """
    session = Session(setup)
    if session.file.exists():
        raise ConfigError(f"{session.file} is there already; name another game")
    session.record = Partial.begin(setup.folder / f"{setup.name}{UNDER_WAY}", session.head())
    return session


def resumed_session(path: File, ladder: Ladder | None = None) -> Session:
    """A game that goes on where its file ends.

    Args:
        path: of the file.
        ladder: in whose record it is to count.

    Raises:
        ConfigError: it is not called like such a file, or its opponent is not on the ladder.
        ReplayFileError: it is none, or the rules or the opponent are others now.
        BusyError: another process plays it.
    """
    if not path.name.endswith(UNDER_WAY):
        raise ConfigError(f"{path}: expected a file *{UNDER_WAY}, as `hexwar play` keeps them")
    record, head, lines = Partial.go_on(path)
    try:
        scenario = scenario_from_document(head.scenario, str(path))
        name = path.name.removesuffix(UNDER_WAY)
        given = {key: getattr(head, key) for key in ("opponent", "seed", "player", "hints")}
        given |= {"scenario": scenario, "side": head.camp, "name": name, "folder": path.parent}
        setup = Setup(ladder=ladder, **given)
        session = Session(setup, record)
        session.check(head, path)
        session.go_on(lines, path)
    except BaseException:
        record.close()
        raise
    return session
