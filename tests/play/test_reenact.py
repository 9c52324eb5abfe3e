"""Recorded games are played again before they are shown: what is not as recorded, or not of these games, is refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.record import state_hash
from hexwar_sb3.engine.replay import PlayerName, Replay
from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.errors import ReplayFileError
from hexwar_sb3.maps.files import load_scenario
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.game import Game as GameWithOpponent
from hexwar_sb3.play.hindsight import Decided, Hindsight
from hexwar_sb3.play.recorded import RecordedGame, nearest_tasks
from hexwar_sb3.play.recording import record_game
from hexwar_sb3.play.reenact import read_recorded
from hexwar_sb3.play.sight import Sight
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.rules.ruleset import default_rules
from hexwar_sb3.tasks.records import TaskKind

SHORT = replace(load_scenario("plain"), name="short", game_ticks=600)
Change = Callable[[Replay, Callable[[list[Any]], object]], Replay]
AsPerson = Callable[..., Replay]


@pytest.fixture(scope="module")
def world() -> World:
    return load_world(SHORT)


@pytest.fixture(scope="module")
def replay() -> Replay:
    return record_game("MA2", "MA1", Terms(scenario=SHORT), seed=1)


def read(replay: Replay, world: World, folder: Path) -> RecordedGame:
    replay.save(folder / "game.hwr")
    return read_recorded(folder / "game.hwr", world)


def play(game: RecordedGame, world: World, camp: Camp) -> Arena:
    """Play a game again without choosing anything; the arena at its end."""
    arena = Arena(world, 1)
    arena.begin(0, game.seed, *game.seats(camp))
    while not arena.state.games[0].over:
        game.play(arena, 0)
    return arena


@pytest.mark.parametrize("named", [True, False])
@pytest.mark.parametrize("camp", [Camp.RED, Camp.BLUE])
def test_a_recorded_game_ends_as_it_did_whether_a_bot_thinks_along_or_not(
    replay: Replay, world: World, tmp_path: Path, as_person: AsPerson, named: bool, camp: Camp
) -> None:
    game = read(as_person(replay, named=named), world, tmp_path)

    arena = play(game, world, camp)

    assert (game.bots[camp] is not None) == named
    assert state_hash(arena.state, 0) == replay.states[-1]["hash"]


@pytest.mark.parametrize("named", [True, False])
def test_it_stops_at_every_decision_of_the_camp_that_is_shown(
    replay: Replay, world: World, tmp_path: Path, as_person: AsPerson, named: bool
) -> None:
    game = read(as_person(replay, named=named), world, tmp_path)
    arena, ticks = Arena(world, 1), list[int]()
    arena.begin(0, game.seed, *game.seats(Camp.RED))
    arena.drives[0].asked[Camp.RED] = 1  # as an env has it
    while not arena.state.games[0].over:
        game.play(arena, 0)
        if arena.due(np.array([0]), Camp.RED)[0]:
            ticks.append(int(arena.state.games[0].tick))

    assert ticks == list(range(75, 600, 75))


def test_a_bot_thinks_along_only_where_it_gave_just_these_orders(
    replay: Replay, world: World, tmp_path: Path, changed_replay: Change
) -> None:
    other = changed_replay(replay, lambda lines: lines[0]["players"]["red"].update(name="MA1"))

    game = read(other, world, tmp_path)

    assert game.bots[Camp.RED] is None
    assert game.bots[Camp.BLUE] is not None
    assert isinstance(game.aims[Camp.RED], Decided)


def test_the_orders_that_a_person_gave_are_those_that_are_given_again(world: World, tmp_path: Path) -> None:
    """Also those that were refused: nothing comes of them again."""
    played = GameWithOpponent(SHORT, seed=4, opponent="MA1", side="blue")
    played.submit("blue", "tank0 move W W W; chariot0 occupy; aerocraft0 move W W W W", strict=False)
    played.advance(300)
    played.submit("blue", ["tank0 hide", "aerocraft0 stop"], strict=False)
    played.advance(600)
    red, blue = PlayerName(name="MA1", kind="bot"), PlayerName(name="Ann")

    game = read(Replay.of(played, red, blue), world, tmp_path)

    assert game.shows == (Camp.BLUE,)
    assert game.names == ("MA1", "Ann")
    assert [bot is None for bot in game.bots] == [False, True]
    assert isinstance(game.aims[Camp.BLUE], Hindsight)
    arena = play(game, world, Camp.BLUE)
    assert arena.margins(np.array([0]), np.array([1]))[0] == played.margin("blue")


def task_text(world: World, task: Any) -> str:
    """A task as replays have it."""
    words = [TaskKind(task.kind).name.lower()]
    words += [str(world.scenario.pieces[task.target])] if task.target >= 0 else []
    words += [world.scenario.hexmap.cell_name(task.cell)] if task.cell >= 0 else []
    return " ".join(words)


def test_the_tasks_of_a_recorded_policy_are_those_that_it_chose(world: World, tmp_path: Path) -> None:
    replay = record_game("HRL0", "nearest", Terms(scenario=SHORT), seed=2)
    game = read(replay, world, tmp_path)
    decided = {
        line["tick"]: {one[0]: one[2][one[1]] for one in line["choices"]}
        for line in replay.lines
        if line["type"] == "decision" and line["camp"] == "red"
    }
    arena, sight, checked = Arena(world, 1), Sight(world, 1), 0
    arena.begin(0, game.seed, *game.seats(Camp.RED))
    names = world.piece_names(Camp.RED)
    while not arena.state.games[0].over:
        tick = int(arena.state.games[0].tick)
        if tick in decided:
            arena.look(np.array([0]), np.array([0]), np.array([Camp.RED]), sight)
            aims = game.aims[Camp.RED].at(tick, tick + 75, arena.state.memory[0, Camp.RED])
            tasks = nearest_tasks(arena, 0, Camp.RED, aims, sight, 0)
            for n, name in enumerate(names):
                if name in decided[tick]:
                    assert task_text(world, sight.rows[0, n, tasks[n]]) == decided[tick][name]
                    checked += 1
        game.play(arena, 0)
    assert checked > 30


@pytest.mark.parametrize(
    ("people", "shown"),
    [
        (("red",), (Camp.RED,)),
        (("blue",), (Camp.BLUE,)),
        (("red", "blue"), (Camp.RED, Camp.BLUE)),
        ((), (Camp.BLUE,)),
    ],
)
def test_people_are_watched_and_without_them_the_winner(
    replay: Replay,
    world: World,
    tmp_path: Path,
    as_person: AsPerson,
    people: tuple[str, ...],
    shown: tuple[Camp, ...],
) -> None:
    assert replay.end["winner"] == "blue"

    assert read(as_person(replay, *people), world, tmp_path).shows == shown


def test_a_record_of_other_games_is_refused(replay: Replay, world: World, tmp_path: Path) -> None:
    with pytest.raises(ReplayFileError, match=r"head: found the record of red only; expected a whole replay"):
        read(replay.for_camp("red"), world, tmp_path)
    with pytest.raises(ReplayFileError, match=r'head.scenario.map: found "hills" .* expected "plain" \('):
        read(record_game("nearest", "nearest", Terms(scenario="hills")), world, tmp_path)
    shorter = replace(SHORT, name="shorter", game_ticks=75)
    with pytest.raises(ReplayFileError, match=r'head.scenario: found "shorter" .* expected "short" \('):
        read(record_game("nearest", "nearest", Terms(scenario=shorter)), world, tmp_path)
    other = Game(SHORT, ruleset=default_rules().with_aerocraft("heli"))
    other.advance(600)
    with pytest.raises(ReplayFileError, match=r"head.rules.aerocraft: found heli; expected default"):
        read(Replay.of(other), world, tmp_path)


def test_a_game_that_was_broken_off_is_known_as_far_as_it_was_played(
    world: World, tmp_path: Path, changed_replay: Change
) -> None:
    game = Game(SHORT)
    game.submit("red", "tank0 move E E E")
    game.advance(400)

    read_back = read(
        Replay.of(game, PlayerName(name="Ann"), PlayerName(name="MA1", kind="bot")), world, tmp_path
    )

    assert read_back.end_tick == 400
    assert read_back.shows == (Camp.RED,)
    said_over = changed_replay(Replay.of(game), lambda lines: lines[-1].update(over=True))
    with pytest.raises(ReplayFileError, match=r"end: found .* when played again; expected "):
        read(said_over, world, tmp_path)
    with pytest.raises(
        ReplayFileError, match=r"end.tick: found 0; expected a game of which something was played"
    ):
        read(Replay.of(Game(SHORT)), world, tmp_path)


def test_a_game_that_was_changed_by_hand_is_refused(world: World, tmp_path: Path) -> None:
    game = Game(SHORT)
    with game.edit() as state:
        state["red:tank0"].blood = 1
    game.advance(600)

    with pytest.raises(
        ReplayFileError, match=r"line \d+: found a change by hand; expected a game that was played"
    ):
        read(Replay.of(game), world, tmp_path)


def drop_orders(lines: list[Any]) -> None:
    """Forget the first line of orders."""
    lines.remove(next(line for line in lines if line["type"] == "orders"))


def late_orders(lines: list[Any]) -> None:
    """Give orders when the game is over."""
    lines.insert(-1, {"type": "orders", "tick": 600, "camp": "red", "orders": []})


def unreadable(lines: list[Any]) -> None:
    """An order that is none."""
    next(line for line in lines if line["type"] == "orders")["orders"][0] = "tank0 fly 1134"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda lines: lines[0].update(seed=7),
            r"line \d+, state of tick 0: found .* when played again; expected",
        ),
        (drop_orders, r"line \d+, state of tick 75: found .* when played again; expected "),
        (late_orders, r"line \d+.tick: found 600; expected the end at 600, as played again"),
        (unreadable, r"line \d+: found .*unknown action 'fly'.*; expected orders that can be played again"),
        (lambda lines: lines[-1]["margin"].update(red=3), r"end: found .* when played again; expected .*"),
    ],
)
def test_a_game_that_does_not_come_out_as_recorded_is_refused(
    replay: Replay, world: World, tmp_path: Path, changed_replay: Change, change: Any, message: str
) -> None:
    with pytest.raises(ReplayFileError, match=message):
        read(changed_replay(replay, change), world, tmp_path)


def test_a_damaged_file_is_refused(replay: Replay, world: World, tmp_path: Path) -> None:
    path = tmp_path / "game.hwr"
    replay.save(path)
    path.write_bytes(path.read_bytes()[:-100])

    with pytest.raises(ReplayFileError, match=r"game.hwr: byte \d+"):
        read_recorded(path, world)


def test_a_decision_that_is_no_task_is_refused(
    replay: Replay, world: World, tmp_path: Path, changed_replay: Change
) -> None:
    def change(lines: list[Any]) -> None:
        next(line for line in lines if line["type"] == "decision")["choices"][0][2] = ["hold"]

    with pytest.raises(ReplayFileError, match=r'line \d+, decision: found "hold".*; expected a task'):
        read(changed_replay(replay, change), world, tmp_path)
