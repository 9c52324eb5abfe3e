"""A game under way survives a kill at any moment: its file makes the same game again."""

from __future__ import annotations

import errno
import json
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.engine.record import state_hash
from hexwar_sb3.errors import BusyError, ConfigError, HexWarError, ReplayFileError
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.server.messages import Finish, Hint, PlanFor, Run
from hexwar_sb3.server.partial import Partial
from hexwar_sb3.server.session import Session, Setup, new_session, resumed_session

Begin = Callable[..., Session]
PLANS = {
    0: ("tank0", ("tank0 go 2030", "tank0 hide")),
    40: ("aerocraft0", ("aerocraft0 go 3030", "aerocraft0 go 4030", "aerocraft0 go 1030")),
    80: ("chariot0", ("chariot0 go 1537", "chariot0 indirect-shoot 2537")),
    160: ("tank0", ("tank0 go 1530",)),
}


def hashed(session: Session) -> str:
    return state_hash(session.game.state, 0)


def play(session: Session, until: int) -> Iterator[Session]:
    """Play by PLANS, batch by batch; the session after each."""
    while session.game.tick < until and not session.game.over:
        if session.game.tick in PLANS:
            piece, steps = PLANS[session.game.tick]
            session.answer(PlanFor(piece, steps, False))
        near = any(0 < tick - session.game.tick < 8 for tick in PLANS)
        session.answer(Run(8 if near else 64))
        session.advance()
        yield session


class KilledError(Exception):
    """The process ends here."""


def ticks_until_killed(session: Session) -> Iterator[int]:
    """The ticks that were told before the end."""
    with pytest.raises(KilledError):  # noqa: PT012  # somewhere in there
        for one in play(session, 400):
            yield one.game.tick


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory: pytest.TempPathFactory) -> dict[int, str]:
    """Hashes by tick of the game that nobody kills."""
    session = new_session(Setup(folder=tmp_path_factory.mktemp("unbroken"), seed=3, hints="HRL0"))
    found, step = {}, session._step

    def noted() -> Any:
        refused = step()
        found[session.game.tick] = hashed(session)
        return refused

    session._step = noted  # type: ignore[method-assign]
    for _ in play(session, 420):
        pass
    session.close()
    return found


@pytest.mark.parametrize("seed", range(4))
def test_a_game_that_was_killed_anywhere_goes_on_as_if_it_had_not_been(
    begin: Begin, unbroken: dict[int, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    """Killed in the middle of the n-th write, after so many bytes; what is told comes after what is kept."""
    session = begin(hints="HRL0")
    writes, write = [0], os.write
    last, cut = 3 + 16 * seed, (0, 1, 17, 10**6)[seed % 4]

    def killing(handle: int, data: bytes) -> int:
        writes[0] += 1
        if writes[0] == last:
            write(handle, data[:cut])
            raise KilledError
        return write(handle, data)

    monkeypatch.setattr(os, "write", killing)
    told = list(ticks_until_killed(session))
    monkeypatch.undo()
    session.close()

    again = resumed_session(tmp_path / "game.partial.hwr")

    assert again.game.tick >= max(told, default=0)
    assert not again.clock.running
    if again.game.tick:
        assert hashed(again) == unbroken[again.game.tick]
    for _ in play(again, 400):
        pass
    assert hashed(again) == unbroken[again.game.tick]
    again.close()


def test_plans_and_hints_are_kept(begin: Begin, tmp_path: Path) -> None:
    session = begin(hints="HRL0")
    session.answer(Hint("tank0"))
    for _ in play(session, 200):
        pass
    kept, hello = session.seat.kept(), session.hello()
    assert kept
    session.close()

    again = resumed_session(tmp_path / "game.partial.hwr")

    assert again.seat.kept() == kept
    assert again.hints_used == 1
    assert again.hello()["story"] == hello["story"]
    assert again.setup.hints == "HRL0"
    again.close()


def test_a_game_that_was_killed_at_its_end_is_written(
    begin: Begin, short: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = begin(scenario=short, player="<b>Zoë</b> 3")
    session.answer(Finish())
    monkeypatch.setattr(Session, "_end", lambda _: (_ for _ in ()).throw(KilledError))
    with pytest.raises(KilledError):  # noqa: PT012  # by the last one
        while True:
            session.advance()
    monkeypatch.undo()
    session.close()

    again = resumed_session(tmp_path / "game.partial.hwr")

    assert again.replay is not None
    assert (tmp_path / "game.hwr").exists()
    assert again.replay.head["players"]["red"]["name"] == "<b>Zoë</b> 3"
    assert again.hello()["story"]["players"]["red"]["name"] == "<b>Zoë</b> 3"
    again.replay.verify()
    assert not (tmp_path / "game.partial.hwr").exists()


def test_a_full_disk_stops_the_game_and_spoils_nothing(
    begin: Begin, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = begin()
    for _ in play(session, 16):
        pass
    before, write = (tmp_path / "game.partial.hwr").read_bytes(), os.write

    def full(handle: int, data: bytes) -> int:
        if len(data) > 9:
            return write(handle, data[:9])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    for number in range(2):
        monkeypatch.setattr(os, "write", full)
        with pytest.raises(OSError, match="No space"):
            session.answer(PlanFor("tank1", (f"tank1 go 12{30 + number}",), False))
        monkeypatch.undo()
        assert (tmp_path / "game.partial.hwr").read_bytes() == before
    session.answer(Run(64))
    monkeypatch.setattr(os, "write", full)
    with pytest.raises(OSError, match="No space"):
        session.advance()
    monkeypatch.undo()
    assert session.seat.tray()  # not given yet
    session.advance()
    hashes = hashed(session)
    session.close()
    again = resumed_session(tmp_path / "game.partial.hwr")
    assert hashed(again) == hashes
    again.close()


def test_one_process_plays_a_game_at_a_time(begin: Begin, tmp_path: Path) -> None:
    begin()
    with pytest.raises(BusyError, match="another process"):
        resumed_session(tmp_path / "game.partial.hwr")


@pytest.fixture
def kept(begin: Begin, tmp_path: Path) -> Path:
    """The file of a game of some ticks."""
    session = begin()
    for _ in play(session, 60):
        pass
    session.close()
    return tmp_path / "game.partial.hwr"


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ('"version":1', '"version":2', "head.version: found 2; expected 1"),
        ('"camp":"red"', '"camp":"green"', "head.camp"),
        ('"seed":3', '"seed":-3', "seed must be"),
        ('"player":"person"', '"player":""', r"head.player: found ''; expected 1 to 40 printable"),
        ('"player":"person"', '"player":"a\u202eb"', r"head.player: found 'a.u202eb'; expected"),
        ('"opponent":"MA2"', '"opponent":"MA7"', "unknown player 'MA7'"),
        ('"opponent":"MA2"', '"opponent":"MA1"', "plays on"),
        ('"rules":"', '"rules":"0', "head.rules: found"),
        ('"opponent_hash":"', '"opponent_hash":"0', "head.opponent_hash: found"),
        ('"type":"clock","tick":8', '"type":"clock","tick":-8', "line 4: found tick -8 after tick"),
        ('"type":"clock","tick":8', '"type":"clock","tick":9999', "line 4: found tick 9999"),
        ('"type":"clock"', '"type":"clocks"', "type: found"),
        ('"orders":["tank0', '"orders":["blue:tank0', "does not belong to red"),
        ('"plans":{"tank0"', '"plans":{"tank7"', "unknown piece"),
        ('"tank0 hide"', '"tank0 fly"', "unknown action"),
        ('"tank0 hide"', "7", "plans: found"),
    ],
)
def test_a_file_that_was_changed_is_refused_or_played(kept: Path, old: str, new: str, why: str) -> None:
    text = kept.read_text(encoding="utf-8")
    assert old in text
    kept.write_text(text.replace(old, new), encoding="utf-8")

    if why == "plays on":  # the other bot does something else: the file cannot tell
        resumed_session(kept).close()
        return
    with pytest.raises(HexWarError, match=why):
        resumed_session(kept)
    assert kept.read_text(encoding="utf-8") == text.replace(old, new)


def test_hundreds_of_broken_files_are_refused_or_played(
    kept: Path, bad: Callable[[Any], Iterator[bytes]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Session, "_step", lambda _: [])  # only what is read is looked at
    monkeypatch.setattr(Session, "_follow", lambda *_: None)
    head, *lines = kept.read_bytes().splitlines()
    small = json.loads(head)
    small["scenario"] = {"format": "none"}
    for line in (small, json.loads(lines[0])):
        for text in bad(line):
            kept.write_bytes(
                b"\n".join([text, *lines]) + b"\n" if line is small else head + b"\n" + text + b"\n"
            )
            with suppress(HexWarError):
                resumed_session(kept).close()


def test_a_file_of_another_name_is_none(kept: Path) -> None:
    other = kept.with_name("game.hwr")
    shutil.copy(kept, other)
    with pytest.raises(ConfigError, match=r"expected a file \*\.partial\.hwr"):
        resumed_session(other)
    with pytest.raises(ReplayFileError, match="No such file"):
        Partial.go_on(kept.with_name("no.partial.hwr"))
    empty = kept.with_name("empty.partial.hwr")
    empty.touch()
    with pytest.raises(ReplayFileError, match=r"head\.type: found null"):
        resumed_session(empty)
