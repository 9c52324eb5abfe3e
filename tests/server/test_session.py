"""One game of a person: what is told, when the clock stops, and how it ends; no network."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import hexwar_sb3 as hx
from hexwar_sb3.engine.text import parse_board
from hexwar_sb3.errors import ConfigError, HexWarError
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.server import messages
from hexwar_sb3.server.clock import Clock
from hexwar_sb3.server.delta import changed
from hexwar_sb3.server.messages import (
    Cancel,
    Finish,
    Hint,
    Look,
    Pause,
    PlanFor,
    Run,
    SetStops,
    StepTo,
    Undo,
    read_question,
)
from hexwar_sb3.server.session import READS, Session, Setup
from hexwar_sb3.viewer import stories

PAGE = (Path(__file__).parents[2] / "docs/formats/play.md").read_text(encoding="utf-8")
Json = dict[str, Any]
Begin = Callable[..., Session]


def example(name: str) -> Json:
    return dict(
        json.loads(PAGE.partition(f"<!-- example: play.{name} -->\n```json\n")[2].partition("\n```")[0])
    )


def play(session: Session, story: Json, question: Any) -> tuple[Json, list[Json]]:
    """Ask for time, and let it pass; the story as a page has it then, and the messages."""
    session.answer(question)
    messages = []
    while session.clock.running:
        messages.append(session.advance())
        story = changed(story, json.loads(json.dumps(messages[-1]["story"])))
    return story, messages


def test_a_page_that_follows_has_the_story_of_the_replay(begin: Begin, brief: Scenario) -> None:
    """Hello and changes add up to what `hexwar watch --view red` says of the same game, played again."""
    session = begin(opponent="MA1", scenario=replace(brief, game_ticks=900))
    story = session.hello()["story"]
    session.answer(PlanFor("tank0", ("tank0 go 2030", "tank0 hide"), False))
    session.answer(PlanFor("aerocraft0", ("aerocraft0 go 3030", "aerocraft0 go 4030"), False))
    while not session.game.over:
        story, _ = play(session, story, Run(64))

    assert session.replay is not None
    assert story == json.loads(json.dumps(stories(session.replay, ("red",))["red"]))
    assert story["orders"]
    assert story["events"]


def test_the_replay_is_whole_and_says_who_played(begin: Begin, brief: Scenario, tmp_path: Path) -> None:
    session = begin(side="blue", opponent="HRL0", hints="HRL0", command="hexwar play HRL0", scenario=brief)
    session.answer(Hint("tank0"))
    _, messages = play(session, session.hello()["story"], Finish())

    replay = hx.Replay.load(tmp_path / "game.hwr")
    replay.verify()
    assert replay.head["players"]["blue"] == {"name": "person", "kind": "human", "hints": 1}
    assert replay.head["players"]["red"]["name"] == "HRL0"
    assert replay.head["command"] == "hexwar play HRL0"
    assert "hints" not in str(replay.for_camp("red").head["players"])
    assert session.hello()["story"]["players"]["blue"] == {"name": "person", "kind": "human"}
    assert not (tmp_path / "game.partial.hwr").exists()
    assert len(messages) == 300 / 75
    over = session.over()
    assert over.keys() == example("over").keys()
    assert over["margin"] == replay.end["margin"]
    assert over["result"] in {"won", "lost", "drawn"}
    assert (replay.end["winner"] == "blue") == (over["result"] == "won")


def test_messages_are_as_the_page_on_the_protocol_says(begin: Begin) -> None:
    session = begin()
    hello = session.hello()
    assert hello.keys() == example("hello").keys()
    for name in ("clock", "stops", "hints"):
        assert hello[name].keys() == example("hello")[name].keys()
    assert session.now().keys() == example("now").keys()
    look, _ = session.answer(Look("chariot0", None))
    path, _ = session.answer(messages.Path("tank0", 2500, None))
    shared = {"say", "to"}
    assert look.keys() == example("look").keys() - shared
    assert path.keys() == example("path").keys() - shared
    assert look["mortar"][0].keys() == {"class", "hit", "off_target", "scatter", "cells"}


def test_orders_wait_in_the_tray_and_plans_are_told(begin: Begin) -> None:
    session = begin()
    session.answer(PlanFor("tank0", ("tank0 go 1234", "tank0 hide"), False))
    now = session.now()

    assert now["story"] == {}
    assert now["tray"] == {"tank0": "tank0 move 1235 1234"}
    assert now["plans"] == {"tank0": ["tank0 go 1234", "tank0 hide"]}
    assert now["undo"] == 1
    session.answer(Undo())
    assert session.now()["tray"] == {}


def test_the_clock_stops_where_a_piece_has_done_what_it_was_told(begin: Begin) -> None:
    session = begin()
    session.answer(PlanFor("tank0", ("tank0 go 1235",), False))

    _, messages = play(session, session.hello()["story"], Run(8))

    assert messages[-1]["stopped"] == "tank0 has done what it was told, in 1235"
    assert messages[-1]["clock"]["tick"] == session.game.tick == 94
    assert [message["clock"]["tick"] for message in messages] == list(
        range(1, 95)
    )  # one a tick at 8 a second


def test_what_is_refused_when_it_is_due_stops_the_clock(begin: Begin) -> None:
    session = begin()
    session.answer(PlanFor("tank0", ("tank0 go 1235", "tank0 occupy", "tank0 hide"), False))

    _, messages = play(session, session.hello()["story"], Run(8))

    why = "red tank0 stands in 1235, which is no control point; it must stand in one to occupy it"
    assert messages[-1]["refused"] == [["tank0", "tank0 occupy", why]]
    assert messages[-1]["stopped"].startswith(f"tank0 occupy was refused: {why}")
    assert messages[-1]["plans"] == {}


def test_what_the_step_itself_refuses_is_told(begin: Begin) -> None:
    """Whether an enemy is beside the point is looked for in the step (rule book, section 4)."""
    scenario = parse_board("""
        map   plain-40x9
        point ford 0604 40
        red   tank 0604
        blue  soldier 0605
        ticks 300
    """).scenario
    session = begin(scenario=scenario)
    session.answer(PlanFor("tank0", ("tank0 occupy", "tank0 hide"), False))

    _, messages = play(session, session.hello()["story"], Run(8))

    assert messages[0]["refused"] == [
        [
            "tank0",
            "tank0 occupy",
            "red tank0 found an enemy in 0604 or beside it; a point is occupied only when none is there",
        ]
    ]
    assert messages[0]["clock"]["running"] is False
    assert messages[0]["plans"] == {}


@pytest.mark.parametrize(("to", "tick"), [("tick", 1), ("decision", 75)])
def test_steps_end_where_they_are_to_end(begin: Begin, to: Any, tick: int) -> None:
    session = begin()

    _, messages = play(session, session.hello()["story"], StepTo(to))

    assert session.game.tick == tick
    assert messages[-1]["stopped"] is None
    assert len(messages) == -(-tick // 16)
    play(session, session.hello()["story"], StepTo(to))
    assert session.game.tick == 2 * tick


def test_a_step_to_the_next_event_ends_with_what_the_camp_sees(begin: Begin) -> None:
    session = begin(opponent="MA1")
    session.answer(SetStops(False, False, False))
    session.answer(PlanFor("aerocraft0", ("aerocraft0 go 3535",), False))

    story, _ = play(session, session.hello()["story"], StepTo("event"))

    assert 0 < session.game.tick < 1800
    assert story["events"] or any(
        state == 1 for one in story["beliefs"]["red"].values() for state in one["state"][1::2]
    )


def test_switches_hold(begin: Begin, short: Scenario) -> None:
    session = begin(opponent="MA1", scenario=short)
    session.answer(SetStops(False, False, False))
    session.answer(PlanFor("tank0", ("tank0 go 0304",), False))

    _, messages = play(session, session.hello()["story"], Run(64))

    assert session.game.over
    assert {message["stopped"] for message in messages} == {None}
    assert [message["clock"]["tick"] for message in messages] == list(range(8, 201, 8))


def test_a_pause_stops_the_clock(begin: Begin) -> None:
    session = begin()
    session.answer(Run(8))
    session.advance()
    session.answer(Pause())

    assert not session.clock.running
    assert session.now()["clock"]["running"] is False


def test_one_who_reads_along_only_looks(begin: Begin) -> None:
    session = begin(hints="HRL0")
    session.answer(Look("tank0", None), READS)
    session.answer(messages.Path("tank0", 2500, None), READS)
    for message in json.loads(PAGE.partition("play.asks -->\n```json\n")[2].partition("\n```")[0])[2:]:
        with pytest.raises(HexWarError, match="reads along"):
            session.answer(read_question(message), READS)
    assert session.hints_used == 0


def test_hints_are_those_of_the_policy_and_counted(begin: Begin) -> None:
    session = begin(hints="HRL0")
    before = session.game.state.pieces.tobytes()
    told, _ = session.answer(Hint("chariot0"))
    again, _ = session.answer(Hint("chariot0"))

    assert told.keys() == example("hint").keys() - {"say", "to"}
    assert again == told | {"used": 2}
    assert len(told["tasks"]) == len(told["values"]) > told["chosen"]
    assert told["values"][told["chosen"]] == max(told["values"])
    assert session.game.state.pieces.tobytes() == before


def test_without_a_policy_there_are_no_hints(begin: Begin) -> None:
    with pytest.raises(HexWarError, match="no policy gives hints"):
        begin().answer(Hint("tank0"))


def test_a_bot_gives_no_hints(begin: Begin) -> None:
    with pytest.raises(ConfigError, match="hints are given by a policy"):
        begin(hints="MA1")


def test_after_the_end_nothing_is_ordered(begin: Begin, short: Scenario) -> None:
    session = begin(scenario=short)
    play(session, session.hello()["story"], Finish())

    for question in (
        PlanFor("tank0", ("tank0 hide",), False),
        Undo(),
        Cancel("tank0"),
        Run(8),
        StepTo("tick"),
        Finish(),
    ):
        with pytest.raises(HexWarError, match="the game is over since tick 200"):
            session.answer(question)
    assert session.hello()["over"] == session.over()


def test_before_the_end_no_result_is_told(begin: Begin) -> None:
    session = begin()

    with pytest.raises(HexWarError, match="not over"):
        session.over()
    assert session.hello()["over"] is None


def test_a_game_is_not_begun_over_another(begin: Begin, tmp_path: Path) -> None:
    begin()
    with pytest.raises(ConfigError, match="there already"):
        begin()
    (tmp_path / "other.hwr").write_bytes(b"")
    with pytest.raises(ConfigError, match="there already"):
        begin(name="other")


@pytest.mark.parametrize(
    "wrong", [{"opponent": "MA9"}, {"scenario": "moon"}, {"side": "green"}, {"seed": -1}]
)
def test_what_there_is_not_is_said(wrong: Json) -> None:
    with pytest.raises(HexWarError):
        Session(Setup(**wrong))


def test_the_clock_has_a_fixed_pace() -> None:
    clock = Clock()
    found = {}
    for speed in (1, 8, 9, 64):
        clock.run(speed)
        found[speed] = (clock.batch, clock.seconds)
    assert found == {1: (1, 1.0), 8: (1, 0.125), 9: (2, 2 / 9), 64: (8, 0.125)}
    clock.step("event", 5)
    assert (clock.batch, clock.seconds, clock.until) == (16, 1 / 16, None)
    clock.step("decision", 75)
    assert clock.until == 150
    clock.finish()
    assert clock.seconds == 0
