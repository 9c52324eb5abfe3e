"""Attack every loader with bad files, and count what becomes of them.

    python tests/attack/run.py                            1,700 files, drawn from all; a table by loader
    python tests/attack/run.py --loader QMIX --most 0     all of one loader
    python tests/attack/run.py --loader QMIX --case 17    one of them, with its traceback

The loaders work in another process, which is started again when a file kills it or it does not answer.
"""

from __future__ import annotations

import argparse
import json
import os
import select
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))
from tests.attack import valid, worker  # noqa: E402  # the root must be known first
from tests.attack.archives import MARK  # noqa: E402
from tests.attack.loaders import LOADERS, Loader  # noqa: E402
from tests.attack.tricks import Case, dealt  # noqa: E402

MOST_SECONDS, MOST_MB = 2.0, 500.0
KILL_SECONDS, START_SECONDS = 10.0, 900.0  # of the processor
ASLEEP, POLL_SECONDS = 1.5, 1.0  # times as long may it sleep
PER_LOADER = 80
AS_IT_IS = Case("", "as it is", lambda _: None)
BAD = ("code executed", "signal", "over time", "over memory", "foreign", "wrong", "stray files")
HEADS = ("loader", "files", "accepted", "refused", *BAD)

say = partial(print, flush=True)


@dataclass
class Outcome:
    """What became of a bad file."""

    loader: str
    number: int  # of the case; -1: the valid files themselves
    name: str
    kind: str  # accepted, refused, foreign, wrong, signal, over time
    detail: str = ""
    seconds: float = 0.0  # of the processor
    megabytes: float = 0.0  # more than before
    executed: bool = False
    stray: str = ""

    @property
    def faults(self) -> list[str]:
        """All that is bad about it, in words of the table's heads."""
        found = [self.kind] if self.kind in BAD else []
        found += ["code executed"] * self.executed
        found += ["over time"] * (self.seconds > MOST_SECONDS and self.kind != "over time")
        found += ["over memory"] * (self.megabytes > MOST_MB)
        return [*found, *(["stray files"] if self.stray else [])]

    def __str__(self) -> str:
        cost = f"{self.seconds:.1f} s, {self.megabytes:.0f} MB"
        said = " ".join(filter(None, (self.detail, self.stray and f"left {self.stray}")))
        return f"{self.loader} {self.number} ({self.name}): {', '.join(self.faults) or self.kind}; {cost}; {said}"


class Worker:
    """A process that loads files, started again when it is gone."""

    def __init__(self, root: Path, place: Path) -> None:
        self.root, self.place = root, place
        self.process: subprocess.Popen[str] | None = None
        for folder in ("work", "elsewhere", "tmp", "case"):
            (place / folder).mkdir(parents=True)
        shutil.copy(root / valid.SCENARIO, place / "work")
        self.mark = place / "mark"

    @property
    def environment(self) -> dict[str, str]:
        """Its variables: where a payload leaves its mark, among others."""
        path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH", ""))))
        own = {MARK: str(self.mark), "TMPDIR": str(self.place / "tmp"), "PYTHONPATH": path}
        return {**os.environ, **own, "MPLBACKEND": "agg", "OMP_NUM_THREADS": "1"}

    def started(self) -> subprocess.Popen[str]:
        """The process, ready.

        Raises:
            RuntimeError: it does not start.
        """
        if self.process is None:
            script = [sys.executable, worker.__file__, str(self.root)]
            with (self.place / "errors").open("a", encoding="utf-8") as errors:
                pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": errors}
                where = {"cwd": self.place / "work", "env": self.environment}
                self.process = subprocess.Popen(script, text=True, **pipes, **where)  # type: ignore[call-overload]
            if self.answer(START_SECONDS) != "ready":
                last = (self.place / "errors").read_text(encoding="utf-8")[-1000:]
                raise RuntimeError(f"no worker: {last}")
        return self.process

    def answer(self, seconds: float) -> str | None:
        """A line; None if the process takes so many seconds of the processor, or waits; "" if it ended.

        Who sleeps for `ASLEEP` times as long waits for something that never comes; on a busy machine a process may
        also be kept waiting for the processor.
        """
        assert self.process is not None
        assert self.process.stdout is not None
        start, asleep = worker.cpu_seconds(self.process.pid), 0.0
        while not select.select([self.process.stdout], [], [], POLL_SECONDS)[0]:
            now = worker.cpu_seconds(self.process.pid)
            asleep = asleep + POLL_SECONDS if worker.sleeps(self.process.pid) else 0.0
            if now - start > seconds or asleep > ASLEEP * seconds:
                return None
        return self.process.stdout.readline().strip()

    def attack(self, loader: Loader, number: int, case: Case) -> Outcome:
        """Spoil a copy of the valid folder and let it be loaded; what costs too much must do so twice."""
        found = self._once(loader, number, case)
        if {"over time", "over memory"} & set(found.faults) and found.kind not in ("signal", "over time"):
            again = self._once(loader, number, case)
            found.seconds = min(found.seconds, again.seconds)
            found.megabytes = min(found.megabytes, again.megabytes)
        return found

    def unspoilt(self, loader: Loader) -> Outcome:
        """The valid files themselves must be taken; the first load of all may take its time."""
        outcome = self._once(loader, -1, AS_IT_IS)
        if outcome.kind == "refused":
            outcome.kind = "wrong"
        outcome.seconds = outcome.megabytes = 0.0
        return outcome

    def _once(self, loader: Loader, number: int, case: Case) -> Outcome:
        folder = self.place / "case" / "it"
        remove(folder)
        spoil(loader, self.root, case, folder)
        names, process = set(tree(folder)), self.started()
        self.mark.unlink(missing_ok=True)
        assert process.stdin is not None
        process.stdin.write(json.dumps([loader.name, str(folder)]) + "\n")
        process.stdin.flush()
        outcome = self._read(Outcome(loader.name, number, case.name, "accepted"), process)
        outcome.executed, outcome.stray = self.mark.exists(), self._strays(loader, folder, names)
        return outcome

    def _read(self, outcome: Outcome, process: subprocess.Popen[str]) -> Outcome:
        """What the process says, or how it ended; the valid files may have to compile first."""
        answer = self.answer(KILL_SECONDS if outcome.number >= 0 else START_SECONDS)
        if answer:
            vars(outcome).update(json.loads(answer))
        elif answer is None:
            outcome.kind, outcome.seconds = "over time", KILL_SECONDS
            outcome.detail = "no answer"
            self.close()
        else:
            code = process.wait()
            outcome.kind = "signal"
            outcome.detail = signal.Signals(-code).name if code < 0 else f"exit code {code}"
            self.close()
        return outcome

    def _strays(self, loader: Loader, folder: Path, names: set[str]) -> str:
        """What was written where nothing should be; outside of the case's folder it is removed."""
        found = [name for name in set(tree(folder)) - names if not loader.may_leave(name)]
        for place, own in (("elsewhere", ""), ("work", valid.SCENARIO)):
            for path in (self.place / place).iterdir():
                if path.name != own:
                    found.append(f"{place}/{path.name}")
                    remove(path)
        remove(self.place / "tmp")
        (self.place / "tmp").mkdir()
        return ", ".join(sorted(found)[:3])

    def close(self) -> None:
        """End the process."""
        if self.process is not None:
            self.process.kill()
            with suppress(BrokenPipeError):
                self.process.communicate()
            self.process = None


def spoil(loader: Loader, root: Path, case: Case, folder: Path) -> None:
    """Make a copy of the valid folder, spoilt."""
    shutil.copytree(root / loader.folder, folder, symlinks=True)
    case.change(folder)


def remove(path: Path) -> None:
    """Remove whatever lies there."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    elif os.path.lexists(path):
        path.unlink()


def tree(folder: Path) -> Iterator[str]:
    """Names of all that lies in a folder, without following links."""
    for place, folders, files in os.walk(folder):
        for name in (*folders, *files):
            yield str(Path(place, name).relative_to(folder))


def attacked(
    root: Path, loaders: Sequence[str], most: int, seed: int = 0, tell: Callable[[Outcome], object] = id
) -> list[Outcome]:
    """Attack some loaders with so many files each; 0 is all of them."""
    found = []
    with tempfile.TemporaryDirectory(prefix="attack-") as place, closing(Worker(root, Path(place))) as own:
        for loader in map(LOADERS.__getitem__, loaders):
            cases = cases_of(loader.name, root)
            found.append(own.unspoilt(loader))
            tell(found[-1])
            for number in dealt(cases, seed, most or len(cases)):
                found.append(own.attack(loader, number, cases[number]))
                tell(found[-1])
    return found


def cases_of(name: str, root: Path) -> list[Case]:
    """All cases of a loader, always the same."""
    return list(LOADERS[name].cases(root / LOADERS[name].folder))


def table(outcomes: Sequence[Outcome]) -> str:
    """Counts by loader, and all together."""
    rows = [list(HEADS)]
    for name in (*dict.fromkeys(one.loader for one in outcomes), "all"):
        own = [one for one in outcomes if name in (one.loader, "all")]
        kinds = Counter(one.kind for one in own)
        faults = Counter(fault for one in own for fault in one.faults)
        counts = [len(own), kinds["accepted"], kinds["refused"], *(faults[fault] for fault in BAD)]
        rows.append([name, *map(str, counts)])
    widths = [max(len(row[k]) for row in rows) for k in range(len(HEADS))]
    cells = [[cell.rjust(width) for cell, width in zip(row, widths, strict=True)] for row in rows]
    return "\n".join(" | ".join((row[0].strip().ljust(widths[0]), *row[1:])) for row in cells)


def make_valid(root: Path) -> Path:
    """Make the valid files, in a process of their own."""
    if not (root / valid.SCENARIO).exists():
        path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH", ""))))
        script = [sys.executable, valid.__file__, str(root)]
        subprocess.run(script, check=True, env={**os.environ, "PYTHONPATH": path, "OMP_NUM_THREADS": "1"})
    return root


def main() -> int:
    """Read the arguments, attack, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--loader", action="append", choices=list(LOADERS), help="only this one; may be repeated"
    )
    parser.add_argument("--most", type=int, default=PER_LOADER, help="files a loader; 0: all")
    parser.add_argument("--seed", type=int, default=0, help="of the draw")
    parser.add_argument("--case", type=int, help="number of one file of the loader; -1: the valid one")
    parser.add_argument("--json", type=Path, help="file that gets all outcomes")
    parser.add_argument("--root", type=Path, help="folder of the valid files; else they are made")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="valid-") as made:
        root = make_valid((asked.root or Path(made) / "root").resolve())
        if asked.case is not None:
            return reproduce(asked.loader[0], asked.case, root)
        outcomes = attacked(root, asked.loader or list(LOADERS), asked.most, asked.seed, tell_fault)
    if asked.json:
        asked.json.write_text(json.dumps([asdict(one) for one in outcomes], indent=0), encoding="utf-8")
    say(table(outcomes))
    return int(any(one.faults for one in outcomes))


def tell_fault(outcome: Outcome) -> None:
    """Print what failed, at once."""
    if outcome.faults:
        say(outcome)


def reproduce(name: str, number: int, root: Path) -> int:
    """Try one case in this process and let its error go."""
    with tempfile.TemporaryDirectory(prefix="attack-") as place:
        own, folder = Worker(root, Path(place)), Path(place) / "case" / "it"
        os.environ.update(own.environment)
        case = cases_of(name, root)[number] if number >= 0 else AS_IT_IS
        say(f"{name} {number}: {case.name}")
        spoil(LOADERS[name], root, case, folder)
        with valid.inside(Path(place) / "work"):
            LOADERS[name].prepare(root)(folder)
        say("accepted")
    return 0


if __name__ == "__main__":
    sys.exit(main())
