"""`hexwar hotspots`: counting replays or fresh games, the file, the picture, and mistakes."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from hexwar_sb3.engine import game as by_orders
from hexwar_sb3.engine.replay import PlayerName, Replay
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.play.game import Game
from hexwar_sb3.play.recording import record_game
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.tasks.hotspots import count_visits
from hexwar_sb3.tasks.spots import load_spots

Command = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def replays(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a folder of two games on plain, as `--games 1` plays them."""
    folder = tmp_path_factory.mktemp("games")
    record_game("MA1", "MA2").save(folder / "first" / "a.hwr")
    record_game("MA2", "MA1").save(folder / "first" / "b.hwr")
    return folder


def test_replays_are_counted_into_a_file_that_training_reads(
    hexwar: Command, replays: Path, tmp_path: Path
) -> None:
    path, picture = tmp_path / "new" / "plain.json", tmp_path / "plain.png"

    code, out, err = hexwar(
        "hotspots", str(replays), "--k", "3", "--out", str(path), "--picture", str(picture)
    )

    assert code == 0
    assert [line.split()[:2] for line in out.splitlines()[2:8]] == [
        [camp, rank] for camp in ("red", "blue") for rank in ("1", "2", "3")
    ]
    assert f"spots: {path}" in err
    assert picture.read_bytes().startswith(b"\x89PNG")
    document = json.loads(path.read_text(encoding="utf-8"))
    world = load_world("plain")
    names = [world.scenario.hexmap.cell_name(cell) for cell in load_spots(world, 3, path)[0]]
    assert names[2:] == document["red"]["cells"][:3]
    assert document["source"].endswith(": 2 games, 1 of MA1 against MA2, 1 of MA2 against MA1")
    assert str(replays.parent) not in document["source"]


def test_fresh_games_are_the_games_of_that_seed_in_both_pairings(hexwar: Command, replays: Path) -> None:
    played = json.loads(hexwar("hotspots", "--games", "1", "--k", "3", "--json")[1])
    counted = json.loads(hexwar("hotspots", str(replays), "--k", "3", "--json")[1])

    command = "hexwar hotspots --games 1 --scenario plain --red MA1 --blue MA2 --seed 0 --k 3"
    assert played.pop("source").startswith(f"{command}: 2 games, ")
    counted.pop("source")
    assert played == counted


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "hexwar: name replays or folders of them, or give --games, not both"),
        (("x.hwr", "--games", "2"), "hexwar: name replays or folders of them, or give --games, not both"),
        (("no.hwr",), "hexwar: no.hwr: file: found No such file"),
        (("--games", "-1"), "hexwar: games must be at least 1, got -1"),
        (("--games", "1", "--k", "18"), "hexwar: k must be in 0..17, got 18: a task set has 40 rows"),
        (("--games", "1", "--k", "-1"), "hexwar: k must be in 0..17, got -1"),
        (("--games", "1", "--seed", "-1"), "hexwar: seed must be in 0..999999, got -1"),
        (("--games", "1", "--red", "MA3"), "hexwar: unknown player 'MA3'"),
        (("--games", "1", "--scenario", "plian"), "hexwar: unknown scenario 'plian'"),
        (
            ("--games", "1", "--out", "spots.txt"),
            "hexwar: --out spots.txt must be a file's name that ends in .json",
        ),
        (("--games", "1", "--picture", "a.gif"), "hexwar: a.gif: a picture's name must end in one of .png"),
    ],
)
def test_a_mistake_is_one_line_and_no_traceback(
    hexwar: Command, arguments: tuple[str, ...], message: str
) -> None:
    code, out, err = hexwar("hotspots", *arguments)

    assert (code, out) == (2, "")
    assert err.startswith(message)
    assert err.count("\n") == 1


def test_a_folder_without_replays_is_a_mistake(hexwar: Command, tmp_path: Path) -> None:
    assert hexwar("hotspots", str(tmp_path)) == (2, "", f"hexwar: {tmp_path} holds no replay (*.hwr)\n")


def test_a_cut_off_replay_is_named(hexwar: Command, replays: Path, tmp_path: Path) -> None:
    whole = (replays / "first" / "a.hwr").read_bytes()
    cut = tmp_path / "cut.hwr"
    cut.write_bytes(whole[: len(whole) // 2])

    code, _, err = hexwar("hotspots", str(replays), str(cut))

    assert code == 2
    assert err.startswith(f"hexwar: {cut}: byte ")
    assert err.count("\n") == 1


def test_a_replay_of_another_map_is_named_with_both_maps(
    hexwar: Command, replays: Path, tmp_path: Path
) -> None:
    other = tmp_path / "hills.hwr"
    record_game("nearest", "nearest", Terms(scenario="hills")).save(other)
    out = tmp_path / "spots.json"

    code, _, err = hexwar("hotspots", str(replays), str(other), "--out", str(out))

    assert code == 2
    assert err.startswith(f'hexwar: {other}: head.scenario.map: found "hills" (')
    assert f'expected "plain" ({Replay.load(replays / "first" / "a.hwr").scenario().hexmap.hash})' in err
    assert err.count("\n") == 1
    assert not out.exists()


def test_games_of_people_are_counted_like_those_of_bots_whole_or_broken_off(
    hexwar: Command, tmp_path: Path
) -> None:
    """Files of `Game` have people's orders and no decisions; a person's game against a bot is of version 2."""
    alone = by_orders.Game("plain")
    alone.submit("red", "tank0 move E E E", strict=False)
    alone.advance(500)
    Replay.of(alone, PlayerName(name="Ann"), PlayerName(name="Ben")).save(tmp_path / "games" / "alone.hwr")
    against = Game("plain", opponent="MA1", side="blue")
    against.submit("blue", "tank0 move W W", strict=False)
    against.advance(1800)
    replay = Replay.of(against, PlayerName(name="MA1", kind="bot"), PlayerName(name="Ann"))
    replay.save(tmp_path / "games" / "deeper" / "against.hwr")
    assert replay.head["version"] == 2
    assert {"decision", "state"} <= {line["type"] for line in replay.lines}

    document = json.loads(hexwar("hotspots", str(tmp_path / "games"), "--k", "1", "--json")[1])

    assert document["source"].endswith(": 2 games, 1 of Ann against Ben, 1 of MA1 against Ann")
    counts = [count_visits(Replay.load(path), load_world("plain")) for path in tmp_path.rglob("*.hwr")]
    stays = [int(count[camp].sum()) for count in counts for camp in (0, 1)]
    assert sorted(stays)[:3] == [0, 1, 1]  # Ben's, Ann's two
    assert max(stays) > 5  # the bot's
