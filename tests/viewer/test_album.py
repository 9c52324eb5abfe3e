"""Pages of many games: small, equal bytes, each game whole, nothing written where a file is broken."""

from __future__ import annotations

import base64
import gzip
import json
import re
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.errors import ConfigError, FileFormatError, ReplayFileError
from hexwar_sb3.play import record_game
from hexwar_sb3.viewer import album as album_module
from hexwar_sb3.viewer.album import Album, Clip, check_size, clips_of, interleaved, tell
from hexwar_sb3.viewer.differences import with_differences
from hexwar_sb3.viewer.story import stories

Json = dict[str, Any]
ALBUM_GAMES, ALBUM_BYTES = 64, 1_500_000


def blocks(page: str) -> dict[str, str]:
    return dict(re.findall(r'<script type="text/plain" id="([\w-]+)">([\w+/=]*)</script>', page))


def unpacked(text: str) -> Any:
    return json.loads(gzip.decompress(base64.b64decode(text)))


def summed(story: Json) -> Json:
    """A story with its differences added up, as plainly as the page on the format says."""

    def changes(values: list[Any], *, steps: bool = False, ends: bool = False) -> list[Any]:
        found, tick, last = list[Any](), 0, 0
        for gap, value in zip(values[::2], values[1::2], strict=True):
            tick += gap
            last = last + value if steps else tick + value if ends and value else value
            found += [tick, last]
        return found

    def hops(values: list[list[int]]) -> list[list[int]]:
        found, end, cell = list[list[int]](), 0, 0
        for wait, ticks, step, *broken in values:
            start, cell = end + wait, cell + step
            end = start + ticks
            found.append([start, end, cell, *(start + one for one in broken)])
        return found

    whole = json.loads(json.dumps(story))
    for piece in whole.get("pieces", {}).values():
        for name, values in piece.items():
            piece[name] = hops(values) if name == "hops" else changes(values, ends=name.endswith("_ends"))
    for enemies in whole.get("beliefs", {}).values():
        for belief in enemies.values():
            for name, values in belief.items():
                belief[name] = changes(values, steps=name == "cell")
    tick = 0
    for event in whole["events"]:
        event["tick"] = tick = tick + event["tick"]
    tick = 0
    for order in whole.get("orders", []):
        order[0] = tick = tick + order[0]
    return whole


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Games that have hardly begun: two of one map and seed, one of another map, and broken files."""
    place = tmp_path_factory.mktemp("games")
    for name, scenario in (("one", "plain"), ("two", "plain"), ("hills", "hills")):
        Replay.of(Game(scenario, seed=5)).save(place / f"{name}.hwr")
    (place / "cut.hwr").write_bytes((place / "one.hwr").read_bytes()[:-9])
    return place


def album(folder: Path, *names: str, view: str = "all") -> Album:
    return Album(title="Games", clips=clips_of([folder / f"{name}.hwr" for name in names], view))


def test_a_page_has_a_block_a_game_and_shares_the_rest(folder: Path) -> None:
    found = blocks(album(folder, "one", "two", "hills").page(Path("games.html")))

    contents = unpacked(found["contents"])
    assert [name for name in found if name.startswith("game-")] == ["game-1", "game-2", "game-3"]
    kinds = [name.partition("-")[0] for name in found]
    assert (kinds.count("map"), kinds.count("setup"), kinds.count("rules")) == (2, 2, 1)
    assert [one["name"] for one in contents["games"]] == ["one", "two", "hills"]
    for one in contents["games"]:
        assert {f"{part}-{one[part]}" for part in ("map", "setup", "rules")} <= set(found)


def test_games_of_other_maps_are_told_apart(folder: Path) -> None:
    one, two, hills = unpacked(blocks(album(folder, "one", "two", "hills").page(Path("g.html")))["contents"])[
        "games"
    ]

    assert [one[part] for part in ("map", "setup", "rules", "seed")] == [
        two[part] for part in ("map", "setup", "rules", "seed")
    ]
    assert (one["map"] == hills["map"], one["rules"] == hills["rules"]) == (False, True)


def test_equal_games_give_equal_bytes(folder: Path) -> None:
    games = album(folder, "one", "hills")

    assert games.page(Path("a.html")) == games.page(Path("b.html"))


def test_a_packed_game_is_the_whole_game(replay: Replay, tmp_path: Path) -> None:
    """Differences and shared parts lose nothing."""
    replay.save(tmp_path / "game.hwr")
    told = tell(Clip(path=tmp_path / "game.hwr", name="game"))
    woven = unpacked(told.block)
    shared = {name.partition("-")[0]: part for name, part in told.shared.items()}

    for view, story in stories(replay).items():
        own = {name: values[view] for name, values in woven.items() if view in values}
        again = {**summed(own), **shared["setup"], "rules": shared["rules"], "players": told.entry["players"]}
        assert again | {"format": "hexwar-story", "version": 1, "view": view} == json.loads(json.dumps(story))


def test_differences_leave_a_story_as_it_was(replay: Replay) -> None:
    story = stories(replay, ("red",))["red"]
    before = json.dumps(story)

    interleaved({"red": with_differences(story)})

    assert json.dumps(story) == before


def test_an_album_of_64_games_is_small(tmp_path: Path) -> None:
    """A policy with its values against a bot, as in the album of a training."""
    record_game("HRL0", "MA1", seed=1).save(tmp_path / "game.hwr")
    clips = [Clip(path=tmp_path / "game.hwr", name="game")]
    page = Album(title="Album", clips=clips).page(Path("album.html"))

    each = len(blocks(page)["game-1"])
    assert len(page.encode()) + (ALBUM_GAMES - 1) * each <= ALBUM_BYTES


def test_a_page_of_one_camp_knows_no_seed_and_no_result(folder: Path) -> None:
    found = blocks(album(folder, "one", view="red").page(Path("games.html")))

    (entry,) = unpacked(found["contents"])["games"]
    assert set(entry) & {"seed", "winner"} == set()
    assert list(entry["margin"]) == ["red"]
    assert entry["views"] == ["red"]
    assert all(set(values) == {"red"} for values in unpacked(found["game-1"]).values())


def test_a_page_that_is_too_large_says_how_many_games_fit(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = len(album(folder, "one", "two").page(tmp_path / "games.html").encode())
    monkeypatch.setattr(album_module, "MAX_PAGE_BYTES", whole - 1)

    with pytest.raises(
        FileFormatError, match=r"games.html: page: found \d+ bytes of 2 games; .* first 1 games fit"
    ):
        album(folder, "one", "two").save(tmp_path / "games.html")
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(FileFormatError, match="the first 0 games fit"):
        check_size(Path("games.html"), [whole, 1])


def test_a_broken_file_writes_nothing(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(ReplayFileError, match=r"cut\.hwr"):
        album(folder, "one", "cut").save(tmp_path / "games.html")
    with pytest.raises(ConfigError, match="no recorded game"):
        Album(title="", clips=[]).save(tmp_path / "games.html")
    assert list(tmp_path.iterdir()) == []


def test_games_are_called_by_what_tells_them_apart() -> None:
    assert [clip.name for clip in clips_of([Path("a/x.hwr"), Path("a/y.hwr")])] == ["x", "y"]
    assert [clip.name for clip in clips_of([Path("a/x.hwr"), Path("b/x.hwr")])] == ["a/x", "b/x"]
