"""`hexwar experiments`: what it lists and refuses, and a whole one, as small as it can be."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from hexwar_sb3.experiments.kept import Kept

Command = Callable[..., tuple[int, str, str]]

TINY = ("--games", "64", "--eval-games", "1", "--final-games", "2", "--seeds", "0")


def places(folder: Path) -> tuple[str, ...]:
    return ("--results", str(folder / "results"), "--work", str(folder / "work"))


def test_the_list_says_what_is_missing_and_starts_nothing(hexwar: Command, tmp_path: Path) -> None:
    code, out, _ = hexwar("experiments", "ablation", "--list", "--only", "vdn", *places(tmp_path))

    assert code == 0
    assert [line.split()[::2] for line in out.splitlines()[2:]] == [[f"vdn-{k}", "missing"] for k in range(3)]
    assert list(tmp_path.iterdir()) == []


def test_the_list_as_json_has_the_commands(hexwar: Command, tmp_path: Path) -> None:
    _, out, _ = hexwar("experiments", "fig7", "--list", "--json", *places(tmp_path))

    commands = {row["run"]: row["command"] for row in json.loads(out)["runs"]}
    assert commands["hrl-paddy-0"].startswith("hexwar train --scenario paddy --seed 0 --n-timesteps 240000 ")
    assert len(commands) == 20  # four methods, three seeds on one map and one on two others


def test_the_stages_of_table_1_are_listed(hexwar: Command, tmp_path: Path) -> None:
    _, out, _ = hexwar("experiments", "table1", "--list", "--json", *places(tmp_path))

    stages = json.loads(out)["stages"]
    assert stages["warm-up hrl-plain-0"] == "missing"
    assert stages["iterations of the league"] == "0 of 10"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("fig8",), "hexwar: unknown experiment 'fig8'; did you mean 'fig7'?"),
        (("ablation", "--only", "vnd"), "hexwar: unknown run 'vnd'; did you mean 'vdn'?"),
        (("fig7", "--games", "0"), "hexwar: games must be at least 1, got 0"),
        (
            ("table1", "--games", "5"),
            "hexwar: table1 is one pipeline with settings of its own; it takes no games",
        ),
        (("table1", "--jobs", "0"), "hexwar: jobs must be at least 1, got 0"),
        (("fig7", "--jobs", "0"), "hexwar: jobs must be at least 1, got 0"),
        (("fig7", "--seeds", "1", "1"), "hexwar: name seeds, each of them once; got (1, 1)"),
        (("fig7", "--seeds", "-1"), "hexwar: seed must be in 0..999999, got -1"),
    ],
)
def test_a_mistake_is_one_line(hexwar: Command, arguments: tuple[str, ...], message: str) -> None:
    code, out, err = hexwar("experiments", *arguments)

    assert (code, out) == (2, "")
    assert err.startswith(message)
    assert err.count("\n") == 1


@pytest.mark.slow
def test_both_methods_are_trained_kept_and_drawn_and_not_trained_again(
    hexwar: Command, tmp_path: Path
) -> None:
    arguments = ("experiments", "fig7", "--only", "hrl-plain", "dqn-plain", *TINY, *places(tmp_path))

    first, again = hexwar(*arguments), hexwar(*arguments)

    assert (first[0], again[0]) == (0, 0)
    assert first[2].count(": done\n") == 2
    files = ("table.txt", "table.json", "fig7.png")
    assert again[2].splitlines() == [str(tmp_path / "results" / "fig7" / name) for name in files]
    for name in ("hrl-plain-0", "dqn-plain-0"):
        kept = Kept(tmp_path / "results" / "fig7", name)
        assert kept.is_there
        assert kept.curve("all")["games"][-1] in {64.0, 65.0}


@pytest.mark.slow
def test_a_stopped_run_saves_and_the_same_command_goes_on(hexwar: Command, tmp_path: Path) -> None:
    arguments = (
        "experiments",
        "ablation",
        "--only",
        "base-0",
        *TINY[2:],
        *places(tmp_path),
        "--games",
        "640",
    )
    process = subprocess.Popen([sys.executable, "-m", "hexwar_sb3.cli", *arguments], stderr=subprocess.PIPE)
    checkpoint = tmp_path / "work" / "ablation" / "base-0_1" / "checkpoint.npz"
    while process.poll() is None and not checkpoint.exists():
        time.sleep(0.1)
    os.kill(process.pid, signal.SIGTERM)
    _, err = process.communicate()

    _, listed, _ = hexwar(*arguments, "--list")
    code, out, _ = hexwar(*arguments)

    assert process.returncode == 130
    assert err.endswith(b"stopped; the same command goes on\n")
    assert listed.split()[-2:] == ["broken", "off"]
    assert code == 0
    assert [path.name for path in (tmp_path / "work" / "ablation").glob("base-0_*")] == ["base-0_1"]
    assert re.search(r"^base +MA1", out, re.MULTILINE)
