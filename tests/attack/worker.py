"""A process that loads one kind of file: a folder's name comes in, a line of JSON goes out."""

from __future__ import annotations

import json
import os
import resource
import sys
import time
import traceback
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from tests.attack.loaders import LOADERS  # the root must be known first
from tests.attack.oracle import Wrong

ROOM_BYTES = 3 << 30  # beyond what a worker has at its start
MOST_SAID = 300  # characters of a message, in the results


def work(name: str, root: Path) -> None:
    """Answer for one folder a line until the input ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    warnings.simplefilter("ignore")
    attempt = LOADERS[name].prepare(root)
    size = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + ROOM_BYTES, size + ROOM_BYTES))
    say = partial(print, file=answers, flush=True)
    say("ready")
    for line in sys.stdin:
        say(json.dumps(tried(attempt, Path(json.loads(line)))))


def tried(attempt: Callable[[Path], object], folder: Path) -> dict[str, Any]:
    """Load, use, and say what came of it and what it cost."""
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    before, start = status("VmRSS"), time.process_time()
    kind, detail = judged(attempt, folder)
    return {
        "kind": kind,
        "detail": detail,
        "seconds": time.process_time() - start,
        "megabytes": max(0.0, status("VmHWM") - before),
    }


def judged(attempt: Callable[[Path], object], folder: Path) -> tuple[str, str]:
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


if __name__ == "__main__":
    work(sys.argv[1], Path(sys.argv[2]))
