"""Two processes in one folder, whatever lies there; a folder that is removed."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.commands.run_folder import RunFolder
from hexwar_sb3.commands.train import Train
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.league.member import as_member

Command = Callable[..., tuple[int, str, str]]
HOLDS = """
import sys, time
from pathlib import Path
from hexwar_sb3.folders import holding
with holding(Path(sys.argv[1]), "thing"):
    print("held", flush=True)
    time.sleep(600)
"""
RUN = (
    *("--n-envs", "2", "--opponents", "MA1", "--eval-freq", "50", "--eval-games", "1", "--save-freq", "50"),
    *("--final-games", "1", "--batch-size", "8", "--lower", "heuristic"),
)


@pytest.fixture
def policy(tmp_path: Path) -> Path:
    model = QMIX("TaskPolicy", make_vec_env(n_envs=1, privileged_state=True), buffer_size=10)
    as_member(model, side="both", scenario="plain").save(tmp_path / "policy")
    return tmp_path / "policy"


@pytest.fixture
def hold() -> Iterator[Callable[[Path], None]]:
    """Let another process hold a folder until the test ends."""
    others: list[subprocess.Popen[str]] = []

    def begin(folder: Path) -> None:
        other = subprocess.Popen(
            [sys.executable, "-c", HOLDS, str(folder)], stdout=subprocess.PIPE, text=True
        )
        others.append(other)
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"

    yield begin
    for other in others:
        other.kill()
        other.communicate()


KINDS: dict[str, tuple[str, tuple[str, ...]]] = {
    "run": ("here", ("train", "--resume", "{here}")),
    "league": ("here", ("selfplay", "{policy}", "--output", "{here}", "--keep", "1")),
    "tournament": ("here", ("tournament", "MA1", "MA2", "--games", "1", "--output", "{here}")),
    "study": ("here", ("tune", "run", "{here}", "--panel", "MA1", "--opponents", "MA1")),
    "policy": ("here", ("distill", "{policy}", "--games", "1", "--updates", "1", "--output", "{here}")),
    "experiment": ("here/fig7", ("experiments", "fig7", "--work", "{here}", "--results", "{here}/r")),
    "experiment, its results": (
        "here/r/fig7",
        ("experiments", "fig7", "--work", "{here}", "--results", "{here}/r"),
    ),
    "table": ("here/table1", ("experiments", "table1", "--work", "{here}", "--results", "{here}/r")),
}


@pytest.mark.parametrize("what", KINDS)
def test_a_second_process_is_refused_at_once(
    what: str, hexwar: Command, hold: Callable[[Path], None], tmp_path: Path, policy: Path
) -> None:
    place, words = KINDS[what]
    here = tmp_path / "here"
    if what == "run":
        here.mkdir()
        RunFolder(here).write_config(Train(), "hexwar train")
    hold(tmp_path / place)
    before = sorted(path.name for path in (tmp_path / place).rglob("*"))

    code, out, err = hexwar(*(word.format(here=here, policy=policy) for word in words))

    kind = what.partition(",")[0]
    assert (code, out) == (2, "")
    assert err == f"hexwar: {tmp_path / place}: another process is working on this {kind}\n"
    assert sorted(path.name for path in (tmp_path / place).rglob("*")) == before


def test_a_run_whose_folder_is_removed_ends_and_makes_nothing(
    hexwar: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def remove(*_: object) -> None:
        shutil.rmtree(tmp_path / "commander_1")

    monkeypatch.setattr("hexwar_sb3.callbacks.checkpoint.save_checkpoint", remove)

    code, out, err = hexwar("train", *RUN, "-n", "200", "--runs", str(tmp_path))

    assert (code, out) == (2, "")
    assert "commander_1" in err.splitlines()[-1]
    assert "the folder was removed while it was in use" in err.splitlines()[-1]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_of_two_trainings_in_a_folder_the_first_goes_on_unharmed(hexwar: Command, tmp_path: Path) -> None:
    folder = tmp_path / "commander_1"
    command = [sys.executable, "-m", "hexwar_sb3.cli", "train", *RUN, "-n", "600", "--runs", str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as first:
        end = time.monotonic() + 120
        while not (folder / "checkpoint.npz").exists():
            assert time.monotonic() < end
            time.sleep(0.1)
        code, _, err = hexwar("train", "--resume", str(folder))
        first.communicate(timeout=300)

    assert code == 2
    assert err == f"hexwar: {folder}: another process is working on this run\n"
    assert first.returncode == 0
    assert (folder / "page.txt").exists()
    assert not [*folder.rglob(".new-*")]


@pytest.mark.slow
def test_who_was_killed_leaves_the_folder_to_the_next(hexwar: Command, tmp_path: Path) -> None:
    folder = tmp_path / "commander_1"
    command = [sys.executable, "-m", "hexwar_sb3.cli", "train", *RUN, "-n", "600", "--runs", str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as first:
        end = time.monotonic() + 120
        while not (folder / "checkpoint.npz").exists():
            assert time.monotonic() < end
            time.sleep(0.1)
        first.send_signal(signal.SIGKILL)
        first.communicate()
    (folder / ".new-checkpoint-x.npz").touch()

    code, _, _ = hexwar("train", "--resume", str(folder))

    assert code == 0
    assert not [*folder.rglob(".new-*")]
