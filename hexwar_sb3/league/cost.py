"""What jobs cost: seconds and memory, in files beside what they made; no result depends on them."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic

from hexwar_sb3.errors import FileFormatError
from hexwar_sb3.evaluation.jobs import core_seconds
from hexwar_sb3.files import write_json
from hexwar_sb3.kinds import fits
from hexwar_sb3.reading import read_json

FILE = "cost.json"
Cost = dict[str, dict[str, float]]  # by part: wall_s, core_s, peak_mb (of the largest process)


@contextmanager
def measured(folder: Path, part: str) -> Iterator[None]:
    """Add wall and core time of the block to a part in the folder's file.

    Core time is that of this process and of its jobs in others.

    Args:
        folder: gets the file.
        part: name of what the block does.
    """
    wall, core = monotonic(), core_seconds()
    try:
        yield
    finally:
        spent = {"wall_s": monotonic() - wall, "core_s": core_seconds() - core}
        found = read_cost(folder)
        before = found.get(part, {})
        found[part] = {key: round(value + before.get(key, 0.0), 1) for key, value in spent.items()}
        found[part]["peak_mb"] = max(before.get("peak_mb", 0.0), round(peak_mb()))
        write_json(folder / FILE, found)


def read_cost(folder: Path) -> Cost:
    """Parts and what they cost; nothing if the file is missing or broken."""
    try:
        found = read_json(folder / FILE)
    except FileFormatError:
        return {}
    return found if all(fits(spent, dict[str, float]) for spent in found.values()) else {}


def added(costs: Iterable[Cost]) -> Cost:
    """Costs of several folders, part by part: seconds add up, the highest peak stays."""
    total: Cost = {}
    for cost in costs:
        for part, spent in cost.items():
            before = total.setdefault(part, {})
            for key, value in spent.items():
                old = before.get(key, 0.0)
                before[key] = max(old, value) if key == "peak_mb" else old + value
    return total


def peak_mb() -> float:
    """Peak memory so far of this process or of one that works for it, in MB; of the others Linux alone tells, Windows nothing: 0."""
    found = [_peak_of("self"), *map(_peak_of, _workers())]
    known = [mb for mb in found if mb is not None]
    if known:
        return max(known)
    try:
        import resource
    except ImportError:  # Windows
        return 0.0
    unit = 1 if sys.platform == "darwin" else 1024  # bytes there, kB elsewhere
    return (
        resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6
    )  # on Linux it begins with the parent's


def _workers() -> Iterator[str]:
    """Numbers of the processes that this one has started."""
    for children in Path("/proc/self/task").glob("*/children"):
        yield from children.read_text(encoding="ascii").split()


def _peak_of(pid: str) -> float | None:
    """Peak memory of a process in MB; None where it is not told, or the process has ended."""
    try:
        status = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
    except OSError:
        return None
    found = re.search(r"VmHWM:\s*(\d+) kB", status)
    return None if found is None else int(found[1]) * 1024 / 1e6
