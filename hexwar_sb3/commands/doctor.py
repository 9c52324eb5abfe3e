"""`hexwar doctor`: what is installed, where things lie, and whether a game runs."""

from __future__ import annotations

import os
import platform
import shutil
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter

from hexwar_sb3.commands.output import compile_first, print_json
from hexwar_sb3.commands.settings import Json
from hexwar_sb3.version import __version__

PACKAGES = (
    "numpy",
    "numba",
    "torch",
    "stable-baselines3",
    "sb3-contrib",
    "gymnasium",
    "pettingzoo",
    "tensorboard",
)


@dataclass(frozen=True, kw_only=True)
class Doctor:
    """Say what is installed and whether a game can be played here."""

    json: Json = False

    def run(self) -> int:
        """Print the findings."""
        findings = {**self._versions(), **self._machine(), **self._game()}
        if self.json:
            print_json(findings)
        else:
            for name, value in findings.items():
                print(f"{name:<20} {value}")
        return 0

    def _versions(self) -> dict[str, str]:
        found = {"hexwar-sb3": __version__, "python": platform.python_version()}
        for package in PACKAGES:
            try:
                found[package] = version(package)
            except PackageNotFoundError:
                found[package] = "not installed"
        return found

    def _machine(self) -> dict[str, str]:
        import torch

        from hexwar_sb3.cache import cache

        root = cache()
        device = torch.cuda.get_device_name(0) if torch.cuda.is_available() else "none, the CPU trains"
        state = (
            f"NOT usable: {root.trouble}; instead {root.place or 'nothing is kept'}"
            if root.trouble
            else "writable"
        )
        found = {"cores": str(os.cpu_count()), "gpu": device, "cache": f"{root.named} ({state})"}
        if root.place is not None:
            size = f"{_size(root.place) / 1e6:.0f} MB"
            found["cache size"] = f"{size} (compiled kernels and maps; may be deleted, is made again)"
            found["free disk"] = f"{shutil.disk_usage(root.place).free / 1e9:.1f} GB"
        return found

    def _game(self) -> dict[str, str]:
        from hexwar_sb3.evaluation.matches import play_match
        from hexwar_sb3.kernels import COMPILED, counts

        compile_first()
        compiled, start = counts[COMPILED], perf_counter()
        play_match("MA1", "MA2", games=1)
        first, compiled = perf_counter() - start, counts[COMPILED] - compiled
        how = (
            f"compiled {compiled} kernels, which were not in the cache"
            if compiled
            else "reads the compiled kernels"
        )
        start = perf_counter()
        play_match("MA1", "MA2", games=20)
        return {
            "first game": f"{first:.1f} s ({how})",
            "games": f"{20 / (perf_counter() - start):.0f} a second, MA1 against MA2",
        }


def _size(folder: Path) -> int:
    """Bytes of all files below a folder, as far as they can be seen."""
    size = 0
    for path in folder.rglob("*"):
        with suppress(OSError):  # somebody removes it meanwhile
            size += path.lstat().st_size if path.is_file() else 0
    return size
