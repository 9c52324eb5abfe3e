"""What jobs cost: seconds and memory, in files beside what they made; no result depends on them."""

from __future__ import annotations

import json
import resource
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic, process_time

from hexwar_sb3.files import replacing

FILE = "cost.json"


@contextmanager
def measured(folder: Path, part: str) -> Iterator[None]:
    """Add wall and core time of the block to a part in the folder's file; core time is this process's alone."""
    wall, core = monotonic(), process_time()
    try:
        yield
    finally:
        spent = {"wall_s": monotonic() - wall, "core_s": process_time() - core}
        found = read_cost(folder)
        before = found.get(part, {})
        found[part] = {key: round(value + before.get(key, 0.0), 1) for key, value in spent.items()}
        found[part]["peak_mb"] = max(before.get("peak_mb", 0.0), round(peak_mb()))
        folder.mkdir(parents=True, exist_ok=True)
        with replacing(folder / FILE) as temporary:
            temporary.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def read_cost(folder: Path) -> dict[str, dict[str, float]]:
    """Parts and what they cost; nothing if the file is missing or broken."""
    try:
        return dict(json.loads((folder / FILE).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return {}


def peak_mb() -> float:
    """Peak memory of this process so far, in MB."""
    unit = 1 if sys.platform == "darwin" else 1024  # bytes there, kB on Linux
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6
