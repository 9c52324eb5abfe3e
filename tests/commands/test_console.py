"""How commands begin and end on consoles of all kinds."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from hexwar_sb3.cli import COMMANDS, command_class
from hexwar_sb3.commands.output import as_json, print_json

Command = Callable[..., tuple[int, str, str]]
SHORT = ("maps", "plain")  # a command of one second


def shell(line: str, **environment: str) -> subprocess.CompletedProcess[bytes]:
    """Run a line of the shell in which `hexwar` is the command."""
    text = f'hexwar() {{ "{sys.executable}" -m hexwar_sb3.cli "$@"; }}; {line}'
    where = {**os.environ, **environment}
    return subprocess.run(["/bin/bash", "-c", text], env=where, capture_output=True, check=False, timeout=120)


CONSOLES: dict[str, tuple[str, int, bytes]] = {
    "a reader that has gone": ("exec 3> >(exec <&-; sleep 3); sleep 0.5; hexwar {} >&3", 141, b""),
    "output closed": ("hexwar {} >&-", 0, b""),
    "input closed": ("hexwar {} <&- >/dev/null", 0, b""),
    "all closed": ("hexwar {} <&- >&- 2>&-", 0, b""),
    "a full disk": ("hexwar {} >/dev/full", 2, b"hexwar: [Errno 28] No space left on device\n"),
    "a terminal of one column": ("COLUMNS=1 hexwar {} >/dev/null", 0, b""),
    "a terminal of no kind": (
        "env -u TERM COLUMNS=x bash -c ':' && unset TERM; hexwar {} >/dev/null",
        0,
        b"",
    ),
}


@pytest.mark.parametrize("arguments", ["--help", "maps plain", "maps --json"])
@pytest.mark.parametrize("console", CONSOLES)
def test_a_command_ends_without_a_traceback_on_every_console(console: str, arguments: str) -> None:
    line, code, said = CONSOLES[console]

    done = shell(line.format(arguments))

    assert (done.returncode, done.stderr) == (code, said)


ASCII: dict[str, dict[str, str]] = {
    "by Python's name": {"PYTHONIOENCODING": "ascii"},
    "by the locale": {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
}


@pytest.mark.parametrize("how", ASCII)
@pytest.mark.parametrize("arguments", ["--help", "match --help", "trian", "match MÄ1 MA2"])
def test_everything_can_be_said_in_ascii(how: str, arguments: str) -> None:
    done = shell(f"hexwar {arguments}", **ASCII[how])

    assert (done.stdout + done.stderr).isascii()
    assert b"Traceback" not in done.stderr
    assert done.returncode == (0 if "--help" in arguments else 2)


def test_a_name_that_is_no_text_is_told_by_its_numbers(tmp_path: Path) -> None:
    place = os.fsencode(tmp_path) + b"/no-\xff.hwr"

    done = subprocess.run(
        [sys.executable, "-m", "hexwar_sb3.cli", "watch", place], capture_output=True, check=False
    )

    assert done.returncode == 2
    assert b"no-\\udcff.hwr" in done.stderr
    assert done.stderr.count(b"\n") == 1


@pytest.mark.parametrize("name", COMMANDS)
def test_a_misspelt_command_is_met_with_the_right_one(hexwar: Command, name: str) -> None:
    code, out, err = hexwar(name[:2] + name[3:])

    assert (code, out) == (2, "")
    assert f"did you mean {name!r}?" in err


@pytest.mark.parametrize("name", COMMANDS)
def test_a_misspelt_flag_of_every_command_is_one_line(hexwar: Command, name: str) -> None:
    fields = [*command_class(name).__dataclass_fields__]  # type: ignore[attr-defined]
    for field in {fields[0], fields[-1]}:
        flag = f"--{field.replace('_', '-')}x"
        code, out, err = hexwar(name, flag, "3")

        assert (code, out) == (2, "")
        assert err.startswith(f"hexwar: unknown flag '{flag}'; ")
        assert err.count("\n") == 1


@pytest.mark.parametrize(
    "arguments",
    [
        ("train", "-n"),
        ("train", "-n", "many"),
        ("train", "--side", "green"),
        ("match", "MA1"),
        ("match", "MA1", "MA2", "MA1"),
        ("tune", "rnu"),
        ("train", "--opponents"),
        ("train", "-x"),
    ],
)
def test_arguments_that_cannot_be_read_are_one_line(hexwar: Command, arguments: tuple[str, ...]) -> None:
    code, out, err = hexwar(*arguments)

    assert code == 2
    assert (out, err.count("\n")) == ("", 1)
    assert len(err) > len("hexwar: x\n")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("play", "--seed", "abc"), "--seed must be a whole number or None, got 'abc'"),
        (("train", "--seed", "1.5"), "--seed must be a whole number, got '1.5'"),
        (("train", "-n", "many"), "-n/--n-timesteps must be a whole number, got 'many'"),
        (("train", "--learning-rate", "fast"), "--learning-rate must be a number or None, got 'fast'"),
    ],
)
def test_a_value_that_is_none_is_met_with_what_is_expected(
    hexwar: Command, arguments: tuple[str, ...], said: str
) -> None:
    assert hexwar(*arguments) == (2, "", f"hexwar: {said}\n")


def test_nothing_at_all_is_answered_with_the_help(hexwar: Command) -> None:
    code, out, err = hexwar()

    assert (code, err) == (0, "")
    assert all(name in out for name in COMMANDS)


def test_json_has_no_number_that_is_none(capsys: pytest.CaptureFixture[str]) -> None:
    values = {"a": float("nan"), "b": [float("inf"), 1.5, (float("-inf"),)], "c": {"d": 1}}
    print_json(values)

    assert json.loads(capsys.readouterr().out) == {"a": None, "b": [None, 1.5, [None]], "c": {"d": 1}}
    assert "NaN" not in as_json(values)
