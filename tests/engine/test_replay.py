"""Replay files (formats/replay.md): round trips, playing again, a camp's own record, bad files."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import zstandard

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.orders import Decompress, Hide, IndirectShoot, Move, Order, Shoot
from hexwar_sb3.engine.record import state_hash
from hexwar_sb3.engine.replay import PlayerName, Replay
from hexwar_sb3.engine.replay_file import MAX_TEXT_BYTES, replays_of
from hexwar_sb3.errors import ConfigError, ReplayFileError
from hexwar_sb3.rules import default_rules

Lines = list[dict[str, Any]]


def played(scenario: str = "plain", ticks: int = 400) -> Game:
    """A short game with moves, shots, a mortar round, an edit and a refused order."""
    game = Game(scenario, seed=9)
    orders = [Move("tank0", ["1134", "1234"]), IndirectShoot("chariot0", "2037"), Hide("aerocraft0")]
    game.submit("red", orders, strict=False)
    game.advance(100)
    with game.edit() as state:
        state["blue:tank0"].cell = "1434"
        state["red:soldier0"].aboard = None
    game.submit("red", [Shoot("tank0", "tank0", "GUN"), Decompress("soldier0")], strict=False)
    game.submit("blue", Shoot("tank0", "tank0", "GUN"))
    game.advance(ticks - 100)
    return game


@pytest.fixture(scope="module")
def game() -> Game:
    return played()


@pytest.fixture
def path(game: Game, tmp_path: Path) -> Path:
    path = tmp_path / "game.hwr"
    Replay.of(game, PlayerName(name="Ada"), PlayerName(name="MA1", kind="bot")).save(path)
    return path


def test_a_replay_comes_back_as_it_was_saved(path: Path, game: Game) -> None:
    replay = Replay.load(path)
    assert replay.head["players"] == {
        "red": {"name": "Ada", "kind": "human"},
        "blue": {"name": "MA1", "kind": "bot"},
    }
    assert replay.scenario().hash == game.world.scenario.hash
    assert replay.ruleset() == default_rules()
    assert replay.end["margin"] == {"red": game.margin("red"), "blue": game.margin("blue")}
    assert [state["tick"] for state in replay.states] == [0, 75, 150, 225, 300, 375, 400]


def test_a_replay_plays_again_to_the_same_states(path: Path) -> None:
    """Head, seed and orders alone give the same game."""
    Replay.load(path).verify()


def test_a_replay_gives_back_the_game_at_any_tick(path: Path, game: Game) -> None:
    replay = Replay.load(path)
    assert state_hash(replay.game_at(400).state, 0) == state_hash(game.state, 0)
    early = replay.game_at(60)
    assert (early.tick, early.view("red").piece("tank0").cell) == (60, "1234")
    early.advance(15)
    assert state_hash(early.state, 0) == replay.states[1]["hash"]


def test_a_replay_goes_tick_by_tick_through_the_same_states_and_events(path: Path) -> None:
    replay = Replay.load(path)
    hashes, events, ticks = {}, list[dict[str, Any]](), []
    for game, happened in replay.ticks():
        ticks.append(game.tick)
        hashes[game.tick] = state_hash(game.state, 0)
        events += [{"type": "event"} | event.as_dict() for event in happened if event.kind != "refused"]
    assert ticks == list(range(401))
    edited = 100  # after the state line of that tick
    assert all(hashes[line["tick"]] == line["hash"] for line in replay.states if line["tick"] != edited)
    assert events == replay.events


def test_refused_orders_are_written_with_their_reason_and_null_orders_not(game: Game) -> None:
    lines = [line for line in Replay.of(game).lines if line["type"] == "orders"]
    assert [line["camp"] for line in lines] == ["red", "red", "blue"]
    why = "red aerocraft0 is an aerocraft; only a ground piece hides"
    assert lines[0]["refused"] == [["aerocraft0 hide", why]]
    assert lines[0]["orders"] == ["tank0 move 1134 1234", "chariot0 indirect-shoot 2037"]


def test_shots_are_written_with_every_die(game: Game) -> None:
    shots = [event for event in Replay.of(game).events if event["kind"] == "shot"]
    assert len(shots) == 2
    dice = {
        "weapon",
        "level",
        "cells_apart",
        "roll",
        "raw",
        "correction_roll",
        "modifiers",
        "correction",
        "result",
    }
    assert dice <= set(shots[0])


def test_a_whole_game_with_its_map_fits_in_50_kb(tmp_path: Path) -> None:
    game = played("hills", ticks=200)
    while not game.over:
        for camp in ("red", "blue"):
            pieces = [
                piece for piece in game.view(camp).own if piece.doing == "settled" and piece.aboard is None
            ]
            orders: list[Order] = [Move(piece.name, ["E" if game.tick % 150 else "W"]) for piece in pieces]
            game.submit(camp, orders, strict=False)  # some are stuck at the edge
        game.advance(25)
    Replay.of(game).save(tmp_path / "whole.hwr")
    assert (tmp_path / "whole.hwr").stat().st_size <= 50_000
    Replay.load(tmp_path / "whole.hwr").verify()


def test_a_game_under_other_rules_comes_back_under_them(tmp_path: Path) -> None:
    game = Game("plain", 3, default_rules().with_aerocraft("heli"))
    game.advance(10)
    Replay.of(game).save(tmp_path / "heli.hwr")
    assert Replay.load(tmp_path / "heli.hwr").ruleset().aerocraft.name == "heli"


# --- a camp's own record -------------------------------------------------------------------------


@pytest.mark.parametrize("camp", ["red", "blue"])
def test_a_camps_own_record_has_no_secrets(camp: str, path: Path, tmp_path: Path) -> None:
    """No seed, salts, hashes, enemy orders, true score or final margin."""
    Replay.load(path).for_camp(camp).save(tmp_path / "own.hwr")
    own = Replay.load(tmp_path / "own.hwr")
    text = "\n".join(json.dumps(line) for line in own.lines)
    for secret in ("seed", "salt", "hash", "sha256", '"margin"', "winner", '"roll"', "modifiers"):
        assert secret not in text, secret
    assert all(line["camp"] == camp for line in own.lines if line["type"] == "orders")
    assert {line["type"] for line in own.lines} <= {"head", "orders", "event", "view", "known", "end"}
    assert [line["tick"] for line in own.lines if line["type"] == "view"] == [0, 75, 150, 225, 300, 375, 400]
    with pytest.raises(ReplayFileError, match=f"the record of {camp} only; expected a whole replay"):
        own.verify()


def test_a_camps_own_record_holds_the_events_that_it_could_see() -> None:
    game = Game.from_text("map plain-40x3\nred tank 0102\nblue tank 0402\nblue soldier 3902")
    game.submit("red", Shoot("tank0", "tank0", "GUN"))
    game.submit("blue", Move("soldier0", ["W"]))
    game.advance(200)
    events = Replay.of(game).for_camp("red").events
    assert ("shot", "red:tank0") in {(event["kind"], event["piece"]) for event in events}
    assert "blue:soldier0" not in {event["piece"] for event in events}
    assert "blue:soldier0" in {event["piece"] for event in Replay.of(game).events}


# --- bad files -----------------------------------------------------------------------------------


def rewritten(change: Callable[[Lines], object]) -> Callable[[bytes], bytes]:
    def rewrite(packed: bytes) -> bytes:
        lines = [json.loads(line) for line in zstandard.decompress(packed).splitlines()]
        change(lines)
        return zstandard.compress("".join(json.dumps(line) + "\n" for line in lines).encode())

    return rewrite


def bad_scenario(lines: Lines) -> None:
    lines[0]["scenario"]["points"][0]["cell"] = "9999"


def deep(_: bytes) -> bytes:
    return zstandard.compress(b'{"type":"head","x":' + b"[" * 100_000 + b"\n")


BAD_FILES: dict[str, tuple[Callable[[bytes], bytes], str]] = {
    "empty": (lambda _: b"", r"byte 0: found b''; expected a zstd-compressed file"),
    "not zstd": (lambda _: b"hello world", r"byte 0: found b'hell'; expected a zstd-compressed file"),
    "a pickle": (lambda packed: b"\x80\x04\x95" + packed, r"byte 0: found .*; expected a zstd-compressed file"),
    "cut short": (lambda packed: packed[: len(packed) // 2], r"expected one whole zstd frame"),
    "last byte gone": (lambda packed: packed[:-1], r"expected one whole zstd frame"),
    "a flipped bit": (lambda packed: packed[:-40] + bytes([packed[-40] ^ 4]) + packed[-39:], r"expected whole zstd data|expected JSON|the file was changed"),
    "1 GB of zeros": (lambda _: zstandard.compress(bytes(10**9)), rf"file: found more than {MAX_TEXT_BYTES} bytes unpacked; expected one game"),
    "zeros of the size of a game": (lambda _: zstandard.compress(bytes(10**6)), r"within a line; expected a whole last line"),
    "too large": (lambda packed: packed + bytes(5_000_000), r"file size: found more than 4000000 bytes; expected at most 4000000"),
    "something after the end": (lambda packed: packed + b"more", r"expected one whole zstd frame"),
    "no JSON": (lambda _: zstandard.compress(b"{hello\n"), r"line 1, line 1, column 2: found Expecting property name.*; expected an object as JSON"),
    "endless nesting": (deep, r"line 1: found maximum recursion depth.*; expected an object as JSON"),
    "no object": (lambda _: zstandard.compress(b"[1]\n"), r"""line 1: found .*; expected an object with a "type\""""),
    "no head": (rewritten(lambda lines: lines.pop(0)), r'line 1: found "state"; expected a line of type "head"'),
    "no end": (rewritten(lambda lines: lines.pop()), r'found .*; expected "end" last: the file was cut short'),
    "a line left out": (rewritten(lambda lines: lines.pop(3)), r"end\.sha256: found .*: the file was changed"),
    "a wrong line": (rewritten(lambda lines: lines[2].update(type="exec")), r'line 3: found "exec"; expected one of'),
    "another format": (rewritten(lambda lines: lines[0].update(format="chess")), r'head\.format: found "chess"; expected one of hexwar-replay'),
    "a later version": (rewritten(lambda lines: lines[0].update(version=3)), r"head\.version: found 3; expected a whole number from 1 to 2"),
    "other rules": (rewritten(lambda lines: lines[0]["rules"].update(hash="0" * 64)), r"these are other rules|the file was changed"),
    "a broken scenario": (rewritten(bad_scenario), r"9999|the file was changed"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD_FILES)
def test_a_bad_file_says_where_what_and_what_was_expected(name: str, path: Path) -> None:
    """Nothing is half loaded."""
    spoil, message = BAD_FILES[name]
    path.write_bytes(spoil(path.read_bytes()))
    with pytest.raises(ReplayFileError, match=message) as error:
        Replay.load(path)
    assert str(error.value).startswith(str(path))


def resealed(lines: Lines) -> Replay:
    """A replay whose lines were changed by somebody who knows how to seal it."""
    from hexwar_sb3.engine.replay_file import content_hash

    lines[-1] = {key: value for key, value in lines[-1].items() if key != "sha256"}
    lines[-1]["sha256"] = content_hash(lines[:-1])
    return Replay(tuple(lines))


def lines_of(game: Game) -> Lines:
    return json.loads(json.dumps(Replay.of(game).lines))


def test_other_rules_are_refused_by_name(game: Game, tmp_path: Path) -> None:
    lines = lines_of(game)
    lines[0]["rules"] |= {"hash": "0" * 64, "version": "0.9"}
    resealed(lines).save(tmp_path / "old.hwr")
    with pytest.raises(ReplayFileError, match=r"head\.rules\.hash: .*version 0\.9.*these are other rules"):
        Replay.load(tmp_path / "old.hwr")


def test_a_broken_scenario_names_its_place(game: Game, tmp_path: Path) -> None:
    lines = lines_of(game)
    bad_scenario(lines)
    resealed(lines).save(tmp_path / "bad.hwr")
    with pytest.raises(ReplayFileError, match=r"head\.scenario, .*9999"):
        Replay.load(tmp_path / "bad.hwr")


def test_a_state_that_does_not_come_again_is_named(game: Game) -> None:
    lines = lines_of(game)
    third = [line for line in lines if line["type"] == "state"][2]
    third["hash"] = "0" * 16
    with pytest.raises(ReplayFileError, match=r"state of tick 150: found .* when played again; expected"):
        resealed(lines).verify()


@pytest.mark.parametrize("kind", ["event", "state"])
@pytest.mark.parametrize("times", [0, 2])
def test_a_line_left_out_or_said_twice_is_not_verified(kind: str, times: int, game: Game) -> None:
    lines = lines_of(game)
    place = [number for number, line in enumerate(lines) if line["type"] == kind][3]
    lines[place : place + 1] = [lines[place]] * times

    with pytest.raises(ReplayFileError, match="when played again"):
        resealed(lines).verify()


def test_an_event_or_figure_that_did_not_come_is_not_verified(game: Game) -> None:
    for kind, change in (("event", {"piece": "red:tank1"}), ("state", {"margin": {"red": 1, "blue": 2}})):
        lines = lines_of(game)
        number, line = next(
            (number, line)
            for number, line in enumerate(lines, start=1)
            if line["type"] == kind and line.get("piece") != "red:tank1"
        )
        line.update(change)

        with pytest.raises(ReplayFileError, match=f"line {number}: found .* when played again"):
            resealed(lines).verify()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"orders": ["tank0 fly"]}, "unknown action 'fly'"),
        ({"orders": ["tank9 hide"]}, "unknown piece 'red:tank9'"),
        ({"orders": [7]}, "orders.orders: found [7]; expected at most 64 orders as texts"),
        ({"camp": "green"}, 'orders.camp: found "green"; expected red or blue'),
        ({"tick": -5}, "found -5; expected a whole number"),
        ({"tick": "soon"}, "expected a whole number"),
    ],
)
def test_orders_that_cannot_be_played_are_named(change: dict[str, Any], message: str, game: Game) -> None:
    lines = lines_of(game)
    next(line for line in lines if line["type"] == "orders").update(change)
    with pytest.raises(ReplayFileError, match=r"line \d+") as error:
        resealed(lines).verify()
    assert message in str(error.value)


def test_a_game_that_was_changed_before_its_first_tick_plays_again(tmp_path: Path) -> None:
    """A text board with a change, and an edit by hand at tick 0."""
    game = Game.from_text("map plain-9x5\nred tank 0103 blood 2\nblue tank 0403")
    with game.edit() as state:
        state["blue:tank0"].blood = 1
    game.advance(80)
    path = tmp_path / "edited.hwr"
    Replay.of(game).save(path)

    again = Replay.load(path)
    again.verify()
    assert state_hash(again.game_at(80).state, 0) == state_hash(game.state, 0)


def test_a_changed_edit_cannot_break_the_engine(game: Game) -> None:
    """A stranger's edit goes through the same checks as everybody's."""
    lines = lines_of(game)
    edit = next(line for line in lines if line["type"] == "edit")
    for bad, message in (
        (["blue:tank0", "cell", "9999"], "edit that can be played again"),
        (["blue:tank0", "blood", 99], "edit that can be played again"),
        (["x"], r"edit\.changes: found \[\[\"x\"\]\]; expected at most 2000 changes"),
        (["blue:tank0", "__class__", 1], "edit that can be played again"),
    ):
        edit["changes"] = [bad]
        with pytest.raises(ReplayFileError, match=message):
            resealed(lines).verify()


def test_a_save_that_fails_leaves_the_old_file(
    path: Path, game: Game, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Writes are atomic: a full disk or a kill in the middle loses nothing."""
    before = path.read_bytes()

    def full(*_: object) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OSError, match="no space left; the file is as it was before"):
        Replay.of(game).save(path)
    assert path.read_bytes() == before
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def test_the_replays_of_a_folder_come_by_name_without_games_under_way(tmp_path: Path) -> None:
    for name in ("b.hwr", "a/c.hwr", "a/d.txt", "a/e.partial.hwr"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()

    assert replays_of(tmp_path) == [tmp_path / "a" / "c.hwr", tmp_path / "b.hwr"]
    assert replays_of(tmp_path / "b.hwr") == [tmp_path / "b.hwr"]
    (tmp_path / "empty").mkdir()
    with pytest.raises(ConfigError, match=r"empty holds no replay \(\*\.hwr\)"):
        replays_of(tmp_path / "empty")
