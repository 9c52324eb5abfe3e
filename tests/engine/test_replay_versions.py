"""Replays of version 1 are read for ever; what came with version 2 (docs/formats/replay.md)."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.replay_file import content_hash, write_lines
from hexwar_sb3.engine.view import known_now
from hexwar_sb3.errors import ReplayFileError
from hexwar_sb3.play.recording import record_game
from hexwar_sb3.rules.enums import Camp

OLD = sorted(Path(__file__).with_name("replays_of_version_1").glob("*.hwr"))


@pytest.mark.parametrize("path", OLD, ids=[path.stem for path in OLD])
def test_a_replay_of_version_1_is_read_and_played_again(path: Path, tmp_path: Path) -> None:
    replay = Replay.load(path)

    assert replay.head["version"] == 1
    if replay.camp is None:
        replay.verify()
        replay.for_camp("red").save(tmp_path / "red.hwr")
        assert Replay.load(tmp_path / "red.hwr").camp == "red"


def test_there_are_old_files_of_every_kind() -> None:
    camps = [Replay.load(path).camp for path in OLD]

    assert {None, "red", "blue"} == set(camps)
    assert any("edit" in {line["type"] for line in Replay.load(path).lines} for path in OLD)


@pytest.fixture(scope="module")
def replay() -> Replay:
    return record_game("HRL0", "MA1", seed=8, command="hexwar match HRL0 MA1")


def test_a_line_that_came_later_is_not_of_version_1(replay: Replay) -> None:
    lines: list[dict[str, Any]] = json.loads(json.dumps(replay.lines))
    lines[0]["version"] = 1
    lines[-1]["sha256"] = content_hash(lines[:-1])

    with pytest.raises(ReplayFileError, match=r'found "decision"; expected a line of version 1'):
        Replay(tuple(lines))


def test_a_replay_says_who_played_and_what_made_it(replay: Replay) -> None:
    players = replay.head["players"]

    assert [len(players[camp]["hash"]) for camp in ("red", "blue")] == [64, 16]
    assert replay.head["command"] == "hexwar match HRL0 MA1"
    gone = {"seed", "software", "command", "created"}
    assert replay.for_camp("red").head.keys() == {*replay.head} - gone | {"camp"}
    assert "hash" not in json.dumps(replay.for_camp("red").head)


@pytest.mark.parametrize("camp", [Camp.RED, Camp.BLUE])
def test_a_camps_own_record_can_be_followed_tick_by_tick(camp: Camp, replay: Replay) -> None:
    """What the `known` lines say until a tick is what the camp knew then."""
    own = replay.for_camp(camp.name.lower())
    now: dict[str, Any] = {"pieces": {}}
    lines = iter([line for line in own.lines if line["type"] == "known"])
    line: dict[str, Any] | None = next(lines)
    game = Game(replay.scenario(), replay.seed)
    acts = [one for one in replay.lines if one["type"] == "orders"]
    for tick in range(replay.end["tick"] + 1):
        while line is not None and line["tick"] == tick:
            now |= {
                name: line[name] for name in ("owners", "known_margin", "bursting", "fights") if name in line
            }
            now["pieces"] |= {piece[0]: piece for piece in line["pieces"]}
            line = next(lines, None)

        known = known_now(camp, game.state, 0, game.world)

        assert now == known | {"pieces": {piece[0]: piece for piece in known["pieces"]}}
        for one in acts:
            if one["tick"] == tick:
                game.submit(one["camp"], one["orders"], strict=False)
        game.advance(1)


def test_a_camp_keeps_its_own_decisions_and_no_true_gain(replay: Replay) -> None:
    own = replay.for_camp("red")
    lines = [line for line in own.lines if line["type"] == "decision"]

    assert {line["camp"] for line in lines} == {"red"}
    assert len(lines) == len(
        [line for line in replay.lines if line.get("camp") == "red" and "choices" in line]
    )
    assert not any("reward" in line for line in lines)


BAD: dict[str, tuple[Callable[[Any], Any], str]] = {
    "another piece": (lambda line: line["choices"][0].__setitem__(0, "tank9"), "another piece"),
    "an enemy's piece": (lambda line: line["choices"][0].__setitem__(0, "blue:tank0"), "another piece"),
    "a choice that is none": (lambda line: line["choices"][0].__setitem__(1, 99), r"choices: found .*; expected at most 64 of"),
    "a value that is no number": (lambda line: line["choices"][0][3].__setitem__(0, 0.5), "choices: found"),
    "a task that is none": (lambda line: line["choices"][0][2].__setitem__(0, "attack blue:tank0 now"), "choices: found"),
    "values of another length": (lambda line: line["choices"][0][3].pop(), "choices: found"),
    "no such direction": (lambda line: line["choices"][0].__setitem__(4, "N"), "choices: found"),
    "part of a reward": (lambda line: line["reward"].pop("own"), "reward: found .*; expected whole numbers for"),
    "more pieces than a camp has": (lambda line: line["choices"].extend(line["choices"] * 10), "choices: found"),
}  # fmt: skip


@pytest.mark.parametrize("what", BAD)
def test_a_bad_decision_is_refused_with_its_place(what: str, replay: Replay, tmp_path: Path) -> None:
    spoil, message = BAD[what]
    lines: list[dict[str, Any]] = json.loads(json.dumps(replay.lines))
    spoil(next(line for line in lines if line["type"] == "decision" and line["camp"] == "red"))
    lines[-1]["sha256"] = content_hash(lines[:-1])

    write_lines(tmp_path / "bad.hwr", lines)

    with pytest.raises(ReplayFileError, match=message):
        Replay.load(tmp_path / "bad.hwr")


BAD_KNOWN: dict[str, tuple[Callable[[Any], Any], str]] = {
    "a piece of nobody": (lambda line: line["pieces"][0].__setitem__(0, "red:tank9"), "other names"),
    "a cell off the map": (lambda line: line["pieces"][0].__setitem__(1, "9999"), "other names"),
    "a burst off the map": (lambda line: line.update(bursting=["9999"]), "other names"),
    "a piece of another length": (lambda line: line["pieces"][0].pop(), "pieces: found"),
    "no such owner": (lambda line: line.update(owners=["grey"]), "owners: found"),
}  # fmt: skip


@pytest.mark.parametrize("what", BAD_KNOWN)
def test_bad_knowledge_is_refused_with_its_place(what: str, replay: Replay, tmp_path: Path) -> None:
    spoil, message = BAD_KNOWN[what]
    lines: list[dict[str, Any]] = json.loads(json.dumps(replay.for_camp("red").lines))
    spoil(next(line for line in lines if line["type"] == "known"))
    write_lines(tmp_path / "bad.hwr", lines)

    with pytest.raises(ReplayFileError, match=message):
        Replay.load(tmp_path / "bad.hwr")
