"""The page: one file, closed to the outside, the same bytes for the same game, names that stay text."""

from __future__ import annotations

import base64
import gzip
import hashlib
import html
import json
import re
from pathlib import Path
from typing import Any

import pytest
import zstandard

import hexwar_sb3 as hx
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.replay import PlayerName, Replay
from hexwar_sb3.engine.replay_file import content_hash, write_lines
from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.viewer import page as page_module
from hexwar_sb3.viewer.page import filled, packed, replay_page, save_page
from hexwar_sb3.viewer.picture import MAX_BYTES
from hexwar_sb3.viewer.story import NAME_CHARACTERS

ROOT = Path(__file__).parents[2]
NASTY = "<script>alert(1)</script>"


@pytest.fixture(scope="module")
def page(replay: Replay) -> str:
    return replay_page(replay)


@pytest.fixture(scope="module")
def short() -> Replay:
    """A game that has hardly begun."""
    return Replay.of(Game("plain", seed=0), PlayerName(name=NASTY), PlayerName(name='"><img src=x>'))


def blocks(page: str) -> dict[str, str]:
    return dict(re.findall(r'<script type="text/plain" id="([\w-]+)">([\w+/=]*)</script>', page))


def unpacked(text: str) -> Any:
    return json.loads(gzip.decompress(base64.b64decode(text)))


def test_a_page_has_a_map_and_three_stories(page: str) -> None:
    found = blocks(page)

    assert [name for name in found if name.startswith("story")] == [
        "story-1-referee",
        "story-1-red",
        "story-1-blue",
    ]
    (key,) = [name for name in found if name.startswith("map-")]
    assert key == f"map-{unpacked(found['story-1-red'])['map']}"
    assert set(unpacked(found[key])) == {
        *("format", "version", "name", "width", "height", "grade_m", "terrain", "levels"),
    }


def test_a_page_of_one_side_has_that_side_alone(short: Replay) -> None:
    page = replay_page(short, "blue")

    assert [name for name in blocks(page) if name.startswith("story")] == ["story-1-blue"]
    assert str(short.seed) not in unpacked(blocks(page)["story-1-blue"])


def test_a_page_is_small(page: str) -> None:
    """At most 200 kB, of which the data of a game are 20 kB and the picture 40 kB."""
    stories = [text for name, text in blocks(page).items() if name.startswith("story")]

    assert len(page.encode()) <= 200_000
    assert sum(len(base64.b64decode(text)) for text in stories) <= 20_000
    assert len(base64.b64decode(re.findall(r"data:image/png;base64,([\w+/=]+)", page)[0])) <= MAX_BYTES


def test_the_same_game_gives_the_same_bytes(replay: Replay, page: str) -> None:
    assert replay_page(replay) == page


def test_the_policy_names_the_code_and_forbids_the_rest(page: str) -> None:
    policy = html.unescape(
        re.findall(r'<meta http-equiv="Content-Security-Policy" content="([^"]+)">', page)[0]
    )
    rules = dict(rule.strip().split(" ", 1) for rule in policy.split(";"))
    (script,) = re.findall(r"<script(?: type=\"module\")?>(.*?)</script>", page, re.DOTALL)
    (style,) = re.findall(r"<style>(.*?)</style>", page, re.DOTALL)

    def named(text: str) -> str:
        return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"

    assert rules == {
        "default-src": "'none'",
        "script-src": named(script),
        "style-src": named(style),
        "img-src": "data: blob:",
        "media-src": "blob:",
        "base-uri": "'none'",
        "form-action": "'none'",
    }


def test_a_page_names_no_address(page: str) -> None:
    code = re.sub(r'<script type="text/plain".*?</script>|data:image/png;base64,[\w+/=]+', "", page)
    code = code.replace("http://www.w3.org/2000/svg", "")  # a name of XML, which nobody fetches

    assert re.findall(r"https?:|(?<![.\w])(?:src|href)=|@import|url\(", code) == ["src="]  # of the picture
    assert "innerHTML" not in code


def test_names_stay_text(short: Replay) -> None:
    page = replay_page(short)

    assert NASTY not in page
    assert html.escape(NASTY) in page
    assert page.count("<script") == replay_page(Replay.of(Game("plain", seed=0))).count("<script")
    assert "<img src=x>" not in page
    assert unpacked(blocks(page)["story-1-red"])["players"]["red"]["name"] == NASTY


@pytest.mark.parametrize("name", ["x" * 10_000, "\u202eder\u202c", "\u2066a\u2069" * 3_000, NASTY * 500])
def test_names_of_any_length_and_direction_are_cut_and_change_no_code(name: str, short: Replay) -> None:
    """A name is its first 40 characters, and the policy names the same code as ever."""
    page = replay_page(Replay.of(Game("plain", seed=0), PlayerName(name=name), PlayerName(name="Ben")))

    told = unpacked(blocks(page)["story-1-red"])["players"]["red"]["name"]
    assert told == name[:NAME_CHARACTERS]
    policy = r'<meta http-equiv="Content-Security-Policy" content="[^"]*">'
    assert re.findall(policy, page) == re.findall(policy, replay_page(short))
    assert name not in page or name == told


def test_a_page_that_is_too_large_is_not_written(
    short: Replay, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page_module, "MAX_PAGE_BYTES", 1_000)

    with pytest.raises(ConfigError, match=r"the page has \d+ bytes; at most 1000"):
        save_page(short, tmp_path / "game.html")
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_view_is_refused(short: Replay) -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'referee'"):
        replay_page(short, "refree")


def test_a_place_in_the_built_page_that_data_could_name_is_filled_once() -> None:
    """A title that reads like a place for data stays a title."""
    page = filled("<!--data-->", {"story-1-red": packed({})}, b"")

    assert page.count('id="story-1-red"') == 1


def test_the_pages_are_built_of_the_sources_that_are_here() -> None:
    """`make viewer` builds them anew. Needs no Node."""
    viewer = ROOT / "viewer"
    names = [
        "index.html",
        "play.html",
        "package.json",
        "package-lock.json",
        "tsconfig.json",
        "vite.config.ts",
    ]
    names += [path.relative_to(viewer).as_posix() for path in (viewer / "src").rglob("*") if path.is_file()]
    digest = hashlib.sha256()
    for name in sorted(names):
        digest.update(f"{name}\n".encode() + (viewer / name).read_bytes())

    built = ROOT / "hexwar_sb3" / "viewer" / "built" / "sources.sha256"
    assert built.read_text().strip() == digest.hexdigest(), "run `make viewer`"


# --- in a notebook -------------------------------------------------------------------------------


def test_a_notebook_shows_a_closed_frame_and_a_picture(short: Replay) -> None:
    shown = hx.show(short, "red")

    bundle = shown._repr_mimebundle_()

    assert set(bundle) == {"text/html", "image/png"}
    assert base64.b64decode(bundle["image/png"]).startswith(b"\x89PNG")
    (sandbox, inside) = re.findall(r'<iframe sandbox="([^"]*)" srcdoc="([^"]*)"', bundle["text/html"])[0]
    assert sandbox == "allow-scripts"
    assert html.unescape(inside) == replay_page(short, "red")


# --- the command ---------------------------------------------------------------------------------


def test_the_command_writes_the_page(
    short: Replay, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from hexwar_sb3.cli import main

    short.save(tmp_path / "game.hwr")

    with pytest.raises(SystemExit) as end:
        main(("watch", str(tmp_path / "game.hwr"), "-o", str(tmp_path / "game.html"), "--view", "red"))

    assert (end.value.code, "page: " in capsys.readouterr().err) == (0, True)
    assert (tmp_path / "game.html").read_text(encoding="utf-8") == replay_page(short, "red")


def spoil(short: Replay) -> None:
    """Files that are cut, flipped in a bit, of a later version or other rules, too large or a bomb."""
    whole = Path("game.hwr").read_bytes()
    Path("cut.hwr").write_bytes(whole[:-9])
    middle = len(whole) // 2
    Path("flipped.hwr").write_bytes(whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :])
    others = {"version": "0.9", "hash": "0" * 64}
    for name, change in (
        ("future", {"version": 99}),
        ("rules", {"rules": {**short.head["rules"], **others}}),
    ):
        lines = [{**short.lines[0], **change}, *short.lines[1:-1]]
        write_lines(Path(f"{name}.hwr"), [*lines, {**short.lines[-1], "sha256": content_hash(lines)}])
    Path("bomb.hwr").write_bytes(zstandard.compress(b"0" * (64 << 20)))
    Path("large.hwr").write_bytes(whole + bytes(4_000_001))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("cut.hwr", "-o", "game.html"), "cut.hwr: byte "),
        (("cut.hwr", "game.hwr", "-o", "games.html"), "cut.hwr: byte "),
        (("flipped.hwr", "-o", "game.html"), "flipped.hwr: byte "),
        (("future.hwr", "-o", "game.html"), "version: found 99"),
        (("rules.hwr", "-o", "game.html"), "these are other rules"),
        (("bomb.hwr", "-o", "game.html"), "bomb.hwr: "),
        (("large.hwr", "-o", "game.html"), "large.hwr: "),
        (
            ("game.hwr", "-o", "game.txt"),
            "game.txt: found a name of no kind; expected one that ends in .html, .gif",
        ),
        (("game.hwr", "-o", "game.png", "--view", "red"), "--view red: found no --at; expected --at TICK"),
        (
            ("game.hwr", "-o", "game.gif", "--from", "9", "--to", "3"),
            "ticks 9 to 3; expected two ticks of 0..",
        ),
        (("own.hwr", "-o", "game.html"), "found the record of red only; expected a whole replay"),
        (("game.hwr", "-o", "folder.html"), "folder.html"),
    ],
)
def test_a_mistake_writes_nothing(
    arguments: tuple[str, ...],
    message: str,
    short: Replay,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    from hexwar_sb3.cli import main

    monkeypatch.chdir(tmp_path)
    short.save("game.hwr")
    short.for_camp("red").save("own.hwr")
    spoil(short)
    Path("folder.html").mkdir()
    before = sorted(tmp_path.iterdir())

    with pytest.raises(SystemExit) as end:
        main(("watch", *arguments))

    assert end.value.code == 2
    assert message in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == before
