"""What a stranger's replay leads to: one of our errors, at once, whatever its lines hold."""

from __future__ import annotations

import json
from itertools import islice
from pathlib import Path
from time import process_time
from typing import Any

import pytest
import zstandard

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.orders import Move, Shoot
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.replay_file import MAX_LINES, content_hash
from hexwar_sb3.engine.replay_lines import LINES, MAX_CHANGES
from hexwar_sb3.errors import HexWarError, ReplayFileError

Lines = list[dict[str, Any]]


@pytest.fixture(scope="module")
def lines() -> Lines:
    """A game of a few ticks with every kind of line but those of a camp's own record."""
    game = Game.from_text("map plain-9x5\nred tank 0102\nred soldier 0103\nblue tank 0402\nticks 200")
    game.submit("red", [Shoot("tank0", "tank0", "GUN"), Move("soldier0", ["E"])])
    game.submit("blue", [Shoot("tank0", "tank0", "LIGHT")], strict=False)
    game.advance(3)
    with game.edit() as state:
        state["blue:tank0"].ammo = {"GUN": 3}
    game.advance(80)
    line = {"type": "decision", "tick": 0, "camp": "red", "reward": {"points": 1, "own": -2, "enemy": 3}}
    game.recorder.lines.insert(1, line | {"choices": [["tank0", 1, ["stop", "hold 0203"], [-5, 3000], "NE"]]})
    return json.loads(json.dumps(Replay.of(game).lines))


def write(path: Path, lines: list[Any], *, sealed: bool = True) -> Path:
    """A file of these lines, sealed by somebody who knows how."""
    if sealed:
        lines = [*lines[:-1], {**lines[-1], "sha256": content_hash(lines[:-1])}]
    text = "".join(json.dumps(line) + "\n" for line in lines)
    path.write_bytes(zstandard.compress(text.encode()))
    return path


def use(path: Path) -> None:
    replay = Replay.load(path)
    replay.verify()
    replay.game_at(40)
    replay.for_camp("red")


def test_a_state_has_the_margins_of_both_camps(lines: Lines, tmp_path: Path) -> None:
    number = next(n for n, line in enumerate(lines) if line["type"] == "state")
    lines = [*lines[:number], {**lines[number], "margin": {"red": 0}}, *lines[number + 1 :]]
    with pytest.raises(
        ReplayFileError, match=r"state\.margin: found .*; expected a whole number for red and for blue"
    ):
        Replay.load(write(tmp_path / "x.hwr", lines))


@pytest.mark.parametrize("kind", ["head", *(name for name in LINES if name not in ("view", "known"))])
def test_nothing_but_our_errors_comes_of_a_bad_line(
    kind: str, lines: Lines, bad: Any, tmp_path: Path
) -> None:
    number = next(n for n, line in enumerate(lines) if line["type"] == kind)
    refused = 0
    line = {**lines[number]}
    if kind == "head":  # maps and scenarios have tests of their own
        line["scenario"] = {
            **line["scenario"],
            "map": {**line["scenario"]["map"], "terrain": [], "levels": []},
        }
    for content in islice(bad(line), 0, None, 4 if kind == "head" else 2):
        try:
            value = json.loads(content)
        except (ValueError, RecursionError):
            continue
        if kind == "head" and isinstance(value, dict) and isinstance(value.get("scenario"), dict):
            if isinstance(value["scenario"].get("map"), dict):
                own = lines[0]["scenario"]["map"]
                value["scenario"]["map"] |= {name: own[name] for name in ("terrain", "levels")}
        path = write(
            tmp_path / "bad.hwr",
            [*lines[:number], value, *lines[number + 1 :]],
            sealed=isinstance(value, dict),
        )
        try:
            use(path)
        except (HexWarError, OSError):
            refused += 1
    assert refused > 25


def test_the_game_itself_is_read(lines: Lines, tmp_path: Path) -> None:
    use(write(tmp_path / "good.hwr", lines))


def event(**values: Any) -> dict[str, Any]:
    return {"type": "event", "tick": 1, "kind": "arrived", "piece": "red:tank0", "cell": "0102", **values}


EDIT = {"type": "edit", "tick": 1, "changes": [["red:tank0", "blood", 2]]}
WRONG: dict[str, tuple[Any, str]] = {
    "an unknown key": (event(colour=1), r"the key \"colour\"; expected only the keys"),
    "an event of no kind": (event(kind="exec"), r'event\.kind: found "exec"; expected the kind of an event'),
    "a piece that is none": (
        event(piece="red:tank7"),
        r"event\.piece: found \"red:tank7\"; expected a name of",
    ),
    "a cell off the map": (event(cell="9901"), r"event\.cell: found \"9901\""),
    "a piece that steers a terminal": (event(piece="\x1b[2J"), r"event\.piece: .* printable"),
    "a tick after the game": (event(tick=201), "at most 200|of at least"),
    "a huge number": (event(result=10**39), r"event\.result: found 1000.*; expected a whole number"),
    "a state without a hash": ({"type": "state", "tick": 1}, "no 'hash'"),
    "a state without a tick": ({"type": "state"}, "no 'tick'"),
    "orders of nobody": (
        {"type": "orders", "tick": 1, "camp": None, "orders": []},
        r"orders\.camp: found null",
    ),
    "orders of a hundred pieces": (
        {"type": "orders", "tick": 1, "camp": "red", "orders": ["x"] * 100},
        "at most 64 orders",
    ),
    "a change of two": ({**EDIT, "changes": [["red:tank0", "blood"]]}, r"edit\.changes"),
    "a second head": ({"type": "head"}, "expected one of orders"),
    "a second end": ({"type": "end", "tick": 1, "over": False, "own": {}}, "expected one of orders"),
    "a list": ([1], "expected"),
    "nothing": (None, "expected"),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_line_that_no_game_has_is_refused_when_it_is_read(what: str, lines: Lines, tmp_path: Path) -> None:
    line, message = WRONG[what]
    with pytest.raises(ReplayFileError, match=message):
        Replay.load(write(tmp_path / "bad.hwr", [lines[0], lines[1], line, lines[-1]]))
    with pytest.raises(ReplayFileError, match=message):
        Replay((lines[0], lines[1], line, lines[-1]))._check_names(Replay(tuple(lines)).scenario())


def test_players_that_are_none_are_refused(lines: Lines) -> None:
    strange: tuple[object, ...] = (
        None,
        [],
        {"red": None},
        {"red": {"name": 1}},
        {"green": {"name": "x"}},
        {"red": {"nom": "x"}},
    )
    for players in strange:
        with pytest.raises(ReplayFileError, match=r"head\.players"):
            Replay(({**lines[0], "players": players}, *lines[1:]))


def orders(tick: int, camp: str) -> dict[str, Any]:
    return {"type": "orders", "tick": tick, "camp": camp, "orders": [], "refused": []}


MANY: dict[str, tuple[Lines, str]] = {
    "150,000 edits": ([EDIT] * 150_000, "lines; expected at most"),
    "edits of a game of its own": ([EDIT] * MAX_CHANGES, "more changes by hand"),
    "long ways by hand": (
        [{**EDIT, "changes": [["red:tank0", "path", ["E"] * 100]]}] * 200,
        "more changes by hand",
    ),
    "orders twice": ([orders(1, "red")] * 2, "orders of red twice"),
    "time that runs backwards": ([orders(9, "red"), orders(8, "blue")], "of at least 9"),
    "events without end": ([event()] * (MAX_LINES + 1), "lines; expected at most"),
}


@pytest.mark.parametrize("what", MANY)
def test_more_than_a_game_has_is_refused_in_two_seconds(what: str, lines: Lines, tmp_path: Path) -> None:
    many, message = MANY[what]
    path = write(tmp_path / "many.hwr", [lines[0], lines[1], *many, lines[-1]])
    begun = process_time()
    with pytest.raises(ReplayFileError, match=message):
        Replay.load(path)
    assert process_time() - begun < 2.0


def test_as_many_edits_as_may_be_are_played_again_in_two_seconds(lines: Lines, tmp_path: Path) -> None:
    path = write(tmp_path / "edits.hwr", [lines[0], *[EDIT] * (MAX_CHANGES // 2), lines[-1]])
    replay = Replay.load(path)
    begun = process_time()
    with pytest.raises(ReplayFileError):
        replay.verify()
    assert process_time() - begun < 2.0


@pytest.mark.parametrize("content", ["window", "dictionary", "two frames", "empty blocks", "run lengths"])
def test_zstd_that_costs_much_is_refused(content: str, tmp_path: Path) -> None:
    magic = b"\x28\xb5\x2f\xfd"
    frames = {
        "window": magic + b"\x00\xf8\x01\x00\x00",
        "dictionary": magic + b"\x03\x58\x01\x02\x03\x04\x01\x00\x00",
        "two frames": zstandard.compress(b"{}\n") * 2,
        "empty blocks": magic + b"\x00\x58" + b"\x00\x00\x00" * 1_300_000 + b"\x01\x00\x00",
        "run lengths": magic + b"\x00\x58" + b"\x02\x00\x10a" * 999_000,
    }
    (tmp_path / "bad.hwr").write_bytes(frames[content])
    begun = process_time()
    with pytest.raises(ReplayFileError):
        Replay.load(tmp_path / "bad.hwr")
    assert process_time() - begun < 2.0


def test_a_game_at_a_tick_takes_no_later_edit(lines: Lines) -> None:
    """The edit of tick 3 is no part of the game at tick 2."""
    assert Replay(tuple(lines)).game_at(2).tick == 2
    ammo = dict(Replay(tuple(lines)).game_at(2).view("blue").piece("tank0").ammo)
    assert ammo["GUN"] != 3
