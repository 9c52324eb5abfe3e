"""Carrying out runs: as processes, some side by side, gone on with where they were broken off; or on a cluster."""

from __future__ import annotations

import signal
import subprocess
import threading
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from time import sleep

from hexwar_sb3.evaluation.cluster import is_elsewhere
from hexwar_sb3.evaluation.jobs import run_jobs
from hexwar_sb3.experiments.errand import Errand, go
from hexwar_sb3.experiments.keep import keep
from hexwar_sb3.experiments.runs import HEXWAR, Places, Run
from hexwar_sb3.files import check_held
from hexwar_sb3.folders import holding
from hexwar_sb3.processes import start_python

POLL_SECONDS = 0.2
Say = Callable[[str], object]


def carry_out(runs: Sequence[Run], places: Places, *, jobs: int = 1, say: Say = print) -> list[Run]:
    """Make every run whose results are not there; return those that failed.

    Ctrl-C or SIGTERM is passed on once to the running ones, which save and end; then it goes on to the caller. On a
    cluster (`working_on`) what runs is lost then, as with a machine that is lost: it begins anew.

    Raises:
        KeyboardInterrupt: it was stopped.
        BusyError: another process carries out runs of these experiments.
    """
    if all(places.is_kept(run) for run in runs):
        return []
    with ExitStack() as held:
        for experiment in dict.fromkeys(run.experiment for run in runs):
            for place in (places.work, places.results):
                held.enter_context(holding(place / experiment, "experiment"))
        return _carry_out(runs, places, jobs, say)


def _carry_out(runs: Sequence[Run], places: Places, jobs: int, say: Say) -> list[Run]:
    waiting = [run for run in runs if not keep_results(run, places)]
    if is_elsewhere():
        return _send_out(waiting, places, jobs, say)
    running: dict[Run, subprocess.Popen[bytes]] = {}
    failed: list[Run] = []
    with _stopping(running):
        while waiting or running:
            while waiting and len(running) < jobs:
                run = waiting.pop(0)
                say(f"{run.name}: {run.command}")
                running[run] = start(run, places, alone=jobs == 1)
            for run in [run for run, process in running.items() if process.poll() is not None]:
                code = running.pop(run).returncode
                if code == 0 and keep_results(run, places):
                    say(f"{run.name}: done")
                else:
                    failed.append(run)
                    say(f"{run.name}: failed with exit code {code}; see {places.log(run)}")
            if running:
                sleep(POLL_SECONDS)
    return failed


def _send_out(runs: Sequence[Run], places: Places, jobs: int, say: Say) -> list[Run]:
    """Let a cluster make runs, which begin anew there; those that failed."""
    errands = [Errand.of(run, places) for run in runs]
    for run in runs:
        say(f"{run.name}: {run.command}")
    codes = run_jobs(go, errands, jobs, "run", leaves=lambda errand: [errand.folder, errand.log])
    failed = [
        run for run, code in zip(runs, codes, strict=True) if code != 0 or not keep_results(run, places)
    ]
    for run, code in zip(runs, codes, strict=True):
        said = f"failed with exit code {code}; see {places.log(run)}" if run in failed else "done"
        say(f"{run.name}: {said}")
    return failed


@contextmanager
def _stopping(running: dict[Run, subprocess.Popen[bytes]]) -> Iterator[None]:
    """Stop the processes where the block ends early: a full disk, say, must not leave trainings without a parent."""
    first = threading.current_thread() is threading.main_thread()  # signals are its own
    before = signal.signal(signal.SIGTERM, signal.default_int_handler) if first else None
    try:
        yield
    except BaseException:
        stop(running.values())
        raise
    finally:
        if first:
            signal.signal(signal.SIGTERM, before)


def start(run: Run, places: Places, *, alone: bool = True) -> subprocess.Popen[bytes]:
    """Start the process of a run; one that is not alone takes one core."""
    log = places.log(run)
    check_held(log.parent)
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("ab") as output:
        command = ["-m", run.module, *arguments(run, places)]
        threads = {} if alone else {"OMP_NUM_THREADS": "1"}
        return start_python(command, threads, stdout=output, stderr=subprocess.STDOUT)


def arguments(run: Run, places: Places) -> list[str]:
    """Arguments of a run: to begin, or to go on from its checkpoint."""
    begun = places.checkpoint(run)
    if run.module == HEXWAR and begun is not None:
        return ["train", "--resume", str(begun)]
    return [*run.arguments, "--runs", str(places.work / run.experiment), "--name", run.name]


def keep_results(run: Run, places: Places) -> bool:
    """Keep the results of a run whose folder is complete; whether they are there now."""
    folder = places.folder(run)
    if not places.is_kept(run) and folder is not None and places.is_trained(run):
        keep(run, folder, places.kept(run))
    return places.is_kept(run)


def stop(processes: Collection[subprocess.Popen[bytes]]) -> None:
    """Let processes save and end; SIGTERM, because what runs in the background may ignore SIGINT."""
    for process in processes:
        process.terminate()
    for process in processes:
        process.wait()
