"""`hexwar watch FILE -o NAME`: every kind of file, and what is said where the settings do not go with it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.replay import PlayerName, Replay

Command = Callable[..., tuple[int, str, str]]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with a short game and red's own record of it."""
    monkeypatch.chdir(tmp_path)
    game = Game.from_text("map plain-20x7\nred tank 0304\nblue tank 0804\nseed 5\nticks 100")
    game.submit("red", "tank0 shoot blue:tank0 GUN")
    game.advance(40)
    replay = Replay.of(game, PlayerName(name="Ann"), PlayerName(name="Ben"))
    replay.save("game.hwr")
    replay.for_camp("red").save("own.hwr")
    return tmp_path


@pytest.mark.parametrize(
    ("name", "more", "kind"),
    [
        ("game.html", ("--view", "red"), "page"),
        ("game.gif", ("--from", "5", "--to", "20"), "film"),
        ("red.hwr", ("--view", "red"), "record"),
        ("events.csv", (), "events"),
        ("events.csv", ("--view", "blue"), "events"),
        ("game.png", (), "picture"),
        ("moment.svg", ("--at", "1"), "picture"),
        ("moment.pdf", ("--at", "1", "--view", "red"), "picture"),
    ],
)
def test_the_ending_says_what_is_written(
    name: str, more: tuple[str, ...], kind: str, hexwar: Command, folder: Path
) -> None:
    code, _, said = hexwar("watch", "game.hwr", "-o", name, *more)

    assert (code, said.strip()) == (0, f"{kind}: {name}")
    assert (folder / name).stat().st_size > 100


def test_a_camps_own_file_is_its_record(hexwar: Command, folder: Path) -> None:
    hexwar("watch", "game.hwr", "-o", "red.hwr", "--view", "red")

    assert (folder / "red.hwr").read_bytes() == (folder / "own.hwr").read_bytes()
    assert Replay.load("red.hwr").camp == "red"


def test_a_camps_own_record_has_a_table_too(hexwar: Command, folder: Path) -> None:
    hexwar("watch", "own.hwr", "-o", "own.csv")
    hexwar("watch", "game.hwr", "-o", "red.csv", "--view", "red")

    assert (folder / "own.csv").read_bytes() == (folder / "red.csv").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("game.hwr", "-o", "game.txt"), "game.txt: found a name of no kind; expected one that ends in .html, .gif"),
        (("game.hwr", "-o", "game.html", "--at", "5"), "--at 5: found -o game.html; expected a name that ends in .png"),
        (("game.hwr", "-o", "e.csv", "--to", "5"), "--to 5: found -o e.csv; expected a name that ends in .gif"),
        (("game.hwr", "-o", "e.png", "--from", "5"), "--from 5: found -o e.png; expected a name that ends in .gif"),
        (("game.hwr", "--view", "red", "--at", "5"), "--view red --at 5: found no file to write; expected -o NAME"),
        (("game.hwr", "-o", "red.hwr"), "red.hwr: found --view all; expected --view red or blue"),
        (("game.hwr", "-o", "game.hwr", "--view", "red"), "game.hwr: found the file that is read; expected another name"),
        (("game.hwr", "-o", "red.png", "--view", "red"), "--view red: found no --at; expected --at TICK"),
        (("game.hwr", "-o", "red.png", "--at", "41"), "tick 41; expected one of 0..40"),
        (("own.hwr", "-o", "blue.csv", "--view", "blue"), "found the record of red; expected a whole replay, or blue's"),
        (("own.hwr", "-o", "red.png", "--at", "5"), "found the record of red only; expected a whole replay"),
    ],
)  # fmt: skip
def test_settings_that_do_not_go_together_write_nothing(
    arguments: tuple[str, ...], message: str, hexwar: Command, folder: Path
) -> None:
    before = {path: path.read_bytes() for path in folder.iterdir()}

    code, _, said = hexwar("watch", *arguments)

    assert code == 2
    assert message in said
    assert {path: path.read_bytes() for path in folder.iterdir()} == before
