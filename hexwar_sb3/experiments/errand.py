"""A run that another machine makes: its process works in a folder of its own, and the run's folder comes back."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from hexwar_sb3.experiments.runs import Places, Run
from hexwar_sb3.processes import start_python

CHECKPOINT = "checkpoint.npz"  # has the replay, and stays where it was made


@dataclass(frozen=True, kw_only=True)
class Errand:
    """A run to make, and what it leaves."""

    run: Run
    runs: str  # folder of its run folder, as its settings name it
    folder: Path  # its run folder, without the checkpoint
    log: Path  # what it prints

    @classmethod
    def of(cls, run: Run, places: Places) -> Errand:
        """The errand of a run.

        A run names the folder that it lies in. One that is not below this process' own cannot be had there: its name is said.
        """
        runs = places.work / run.experiment
        is_below = not runs.is_absolute() and ".." not in runs.parts
        text = str(runs) if is_below else runs.name
        return cls(run=run, runs=text, folder=places.next_folder(run), log=places.log(run))


def go(errand: Errand) -> int:
    """Make a run from its beginning: a function of `errand` alone, in any process; the exit code of the run."""
    run, environment = errand.run, {"OMP_NUM_THREADS": "1"}
    errand.log.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as place, errand.log.open("wb") as output:
        command = ["-m", run.module, *run.arguments, "--runs", errand.runs, "--name", run.name]
        process = start_python(command, environment, cwd=place, stdout=output, stderr=subprocess.STDOUT)
        code = process.wait()
        made = Path(place, errand.runs, f"{run.name}_1")
        if made.is_dir():
            (made / CHECKPOINT).unlink(missing_ok=True)
            made.rename(errand.folder)
    return code
