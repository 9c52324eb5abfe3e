"""A process that loads files: names of a loader and a folder come in, a line of JSON goes out."""

from __future__ import annotations

import json
import os
import resource
import sys
import time
import traceback
import warnings
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from tests.attack.loaders import LOADERS  # the root must be known first
from tests.attack.oracle import ACTS, Attempt, Wrong

ROOM_BYTES = 4 << 30  # beyond what a worker has at its start
MOST_SAID = 300  # characters of a message, in the results


def work(root: Path) -> None:
    """Answer for a loader and a folder a line until the input ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    warnings.simplefilter("ignore")
    import_module("hexwar_sb3.algorithms.hierarchical")  # with all that is large
    size = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + ROOM_BYTES, size + ROOM_BYTES))
    attempts = cache(lambda name: LOADERS[name].prepare(root))
    say = partial(print, file=answers, flush=True)
    say("ready")
    for line in sys.stdin:
        name, folder = json.loads(line)
        say(json.dumps(tried(attempts(name), Path(folder))))


def tried(attempt: Attempt, folder: Path) -> dict[str, Any]:
    """Load, use, and say what came of it and what it cost: of acts that are told apart the longest counts."""
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    ACTS.clear()
    before, start = status("VmRSS"), time.process_time()
    kind, detail = judged(attempt, folder)
    return {
        "kind": kind,
        "detail": detail,
        "seconds": max(ACTS or [time.process_time() - start]),
        "megabytes": max(0.0, status("VmHWM") - before),
    }


def judged(attempt: Attempt, folder: Path) -> tuple[str, str]:
    """The kind of end, and what was said."""
    from hexwar_sb3.errors import HexWarError

    try:
        attempt(folder)
    except Wrong as error:
        return "wrong", str(error)[:300]
    except (HexWarError, OSError) as error:
        problem = why_unreadable(str(error))
        return ("wrong", problem) if problem else ("refused", str(error)[:300])
    except BaseException as error:  # noqa: BLE001  # whatever a stranger's file leads to
        frames = traceback.extract_tb(error.__traceback__)
        ours = [frame for frame in frames if "/hexwar_sb3/" in frame.filename] or frames
        at = f"{Path(ours[-1].filename).name}:{ours[-1].lineno}"
        return "foreign", f"{type(error).__name__} at {at}: {str(error)[:160]!r}"
    return "accepted", ""


def why_unreadable(message: str) -> str | None:
    """What is wrong with a message, if it is none for a terminal."""
    if len(message) > 4000:
        return f"a message of {len(message)} characters: {message[:60]!r}"
    odd = [one for one in message if not (one.isprintable() or one in "\n\t")]
    return f"a message with {odd[0]!r}" if odd else None


def status(name: str) -> float:
    """A figure of this process's memory, MB."""
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith(f"{name}:"):
            return int(line.split()[1]) / 1024
    return 0.0


def cpu_seconds(pid: int) -> float:
    """Seconds of the processor that a process has taken; its ended children's too."""
    fields = stat_fields(pid)
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")


def sleeps(pid: int) -> bool:
    """Whether a process waits for something other than the processor."""
    return stat_fields(pid)[0] in ("S", "D")


def stat_fields(pid: int) -> list[str]:
    """What /proc says of a process, from its state on."""
    return Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()


if __name__ == "__main__":
    work(Path(sys.argv[1]))
