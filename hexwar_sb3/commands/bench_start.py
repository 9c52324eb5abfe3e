"""How long a start takes, cold and warm, and how much memory was used."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from time import perf_counter

IMPORT = "import hexwar_sb3"
GAME = "import hexwar_sb3 as hx; hx.play_match('MA1', 'MA2', games=1)"


def start_figures() -> dict[str, float]:
    """Measure seconds of wall time in fresh processes: import; first game with and without compiled kernels."""
    with tempfile.TemporaryDirectory() as empty:
        cold = seconds(GAME, HEXWAR_CACHE=empty)
        warm = seconds(GAME, HEXWAR_CACHE=empty)
    bare = seconds("pass")
    return {"import_s": seconds(IMPORT) - bare, "warm_start_s": warm - bare, "cold_compile_s": cold - warm}


def seconds(code: str, **env: str) -> float:
    """Run Python code in a process of its own; return its wall time."""
    start = perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True, env={**os.environ, **env})  # noqa: S603  our own code
    return perf_counter() - start
