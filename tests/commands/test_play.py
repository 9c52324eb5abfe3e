"""`hexwar play`: begins, is killed or stopped, goes on, and says so."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.commands import play
from hexwar_sb3.engine.record import state_hash
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.text import parse_board
from hexwar_sb3.maps.files import save_scenario
from hexwar_sb3.server.session import resumed_session

Command = Callable[..., tuple[int, str, str]]
SECONDS = 60.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("MA9",), "unknown player 'MA9'"),
        (("--scenario", "moon"), "moon"),
        (("--hints", "MA1"), "MA1 is a bot; hints are given by a policy, like HRL0"),
        (("--name", "../game"), "--name must be of letters, digits, - and _"),
        (("--player", ""), "--player must be 1 to 40 printable characters"),
        (("--player", "x" * 41), "--player must be 1 to 40 printable characters"),
        (("--player", "a\u202eb"), r"got 'a\u202eb'"),
        (("--player", " Zoë"), "no blanks at the ends"),
        (("--port", "65536"), "--port must be at most 65535"),
        (("--seed", "-1"), "--seed must be an integer >= 0"),
        (("--resume", "no.partial.hwr"), "no.partial.hwr: file: found No such file"),
        (("--resume", "game.hwr"), "expected a file *.partial.hwr"),
        (("--resume", "no.partial.hwr", "--side", "blue"), "found --side, expected none"),
        (("--resume", "no.partial.hwr", "--player", "Zoë"), "found --player, expected none"),
    ],
)
def test_mistakes_end_in_a_line(
    hexwar: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    code, out, err = hexwar("play", "--no-browser", *arguments)

    assert code == 2
    assert message in err
    assert not out
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("package", play.NEEDED)
def test_a_missing_package_is_named(hexwar: Command, package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "hexwar_sb3.commands.play.find_spec", lambda name: None if name == package else find_spec(name)
    )
    code, _, err = hexwar("play")

    assert code == 2
    assert err == f'hexwar: playing needs {package}: pip install "hexwar-sb3[play]"\n'


def test_a_port_in_use_leaves_no_game_behind(hexwar: Command, tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        code, out, err = hexwar("play", "MA2", "--no-browser", "--port", str(port), "--folder", str(tmp_path))

    assert (code, out) == (2, "")
    assert (
        err.splitlines()[-1]
        == f"hexwar: --port {port}: Address already in use; without it any that is free is taken"
    )
    assert not list(tmp_path.glob("*.hwr"))


def test_games_are_numbered(tmp_path: Path) -> None:
    (tmp_path / "game_1.hwr").touch()
    (tmp_path / "game_2.partial.hwr").touch()

    assert play._free_name(tmp_path) == "game_3"
    assert play._free_name(tmp_path / "none") == "game_1"


def test_the_browser_is_sent_by_a_file_of_this_user(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[tuple[str, str, int]] = []

    def look(uri: str) -> None:
        path = Path(uri.removeprefix("file://"))
        opened.append((uri, path.read_text(), path.parent.stat().st_mode & 0o077))

    monkeypatch.setattr(play.webbrowser, "open", look)  # type: ignore[attr-defined]
    with play._browser("http://127.0.0.1:1/#token", opens=True):
        ((uri, text, others),) = opened

    assert "token" not in uri
    assert 'url=http://127.0.0.1:1/#token"' in text
    assert others == 0
    with play._browser("x", opens=False):
        assert len(opened) == 1


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    board = parse_board("map plain-40x9\npoint ford 0604 40\nred tank 0204\nblue tank 3904\nticks 300")
    save_scenario(board.scenario, tmp_path / "short.json")
    return tmp_path / "short.json"


@contextmanager
def running(folder: Path, *arguments: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """The command in a process of its own, and the address that it shows."""
    command = [sys.executable, "-m", "hexwar_sb3.cli", "play", "--no-browser", *arguments]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        address = next((line.strip() for line in process.stdout if line.startswith("http://")), "")
        assert address, process.communicate(timeout=SECONDS)[1]
        yield process, address
    finally:
        process.kill()
        process.communicate()


@contextmanager
def connected(address: str) -> Iterator[Callable[..., Any]]:
    """Function that asks, and gives the last message when the clock stands again."""
    import httpx
    from websockets.sync.client import connect
    from websockets.typing import Origin

    origin, _, token = address.partition("/#")
    answer = httpx.post(f"{origin}/enter", content=token, headers={"Origin": origin})
    cookie = {"Cookie": answer.headers["set-cookie"].partition(";")[0]}
    host = origin.removeprefix("http://")
    with connect(f"ws://{host}/socket", origin=Origin(origin), additional_headers=cookie) as socket:
        hello = json.loads(socket.recv(SECONDS))

        def ask(ask: str, **fields: Any) -> Any:
            if ask == "hello":
                return hello
            socket.send(json.dumps({"id": 1, "ask": ask, **fields}))
            while (message := json.loads(socket.recv(SECONDS)))["say"] != "now" or message["clock"][
                "running"
            ]:
                pass
            return message

        yield ask


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs signals")
def test_a_game_that_is_killed_and_stopped_goes_on_to_its_end(scenario: Path, tmp_path: Path) -> None:
    begins = ("MA1", "--scenario", str(scenario), "--seed", "5", "--player", "Zoë")
    with running(tmp_path, *begins) as (process, address):
        with connected(address) as ask:
            ask("plan", piece="tank0", steps=["tank0 go 0604", "tank0 occupy"], then=False)
            ask("step", to="decision")
        os.kill(process.pid, signal.SIGKILL)
    file = tmp_path / "play" / "game_1.partial.hwr"
    session = resumed_session(file)
    killed_at = state_hash(session.game.state, 0)
    session.close()

    with running(tmp_path, "--resume", "play/game_1.partial.hwr") as (process, address):
        with connected(address) as ask:
            assert ask("hello")["clock"]["tick"] == 75
            ask("step", to="tick")
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=SECONDS)
    assert process.returncode == 130
    assert (
        err.splitlines()[-1] == "stopped at tick 76; go on with: hexwar play --resume play/game_1.partial.hwr"
    )

    with running(tmp_path, "--resume", "play/game_1.partial.hwr") as (process, address):
        with connected(address) as ask:
            assert ask("finish")["clock"]["over"]
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=SECONDS)
    assert process.returncode == 0
    replay = Replay.load(tmp_path / "play" / "game_1.hwr")
    replay.verify()
    assert replay.head["players"]["red"] == {"name": "Zoë", "kind": "human", "hints": 0}
    assert [line["hash"] for line in replay.states if line["tick"] == 75] == [killed_at]
    assert not file.exists()


def test_a_ladder_names_the_opponent(
    hexwar: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    code, _, err = hexwar("play", "MA1", "--ladder", "runs/commander_1")

    assert code == 2
    assert err == "hexwar: --ladder says who is next; found MA1, expected no opponent\n"
