"""`hexwar doctor`: what is installed, where things lie, and whether a game runs."""

from __future__ import annotations

import os
import platform
import shutil
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter

from hexwar_sb3 import __version__
from hexwar_sb3.commands.output import compile_first, print_json
from hexwar_sb3.commands.settings import Json

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

        from hexwar_sb3.kernels import cache_root

        root = cache_root()
        root.mkdir(parents=True, exist_ok=True)
        device = torch.cuda.get_device_name(0) if torch.cuda.is_available() else "none, the CPU trains"
        return {
            "cores": str(os.cpu_count()),
            "gpu": device,
            "cache": f"{root} ({'writable' if os.access(root, os.W_OK) else 'NOT writable'})",
            "cache size": f"{_size(root) / 1e6:.0f} MB (compiled kernels and maps; may be deleted, is made again)",
            "free disk": f"{shutil.disk_usage(root).free / 1e9:.1f} GB",
        }

    def _game(self) -> dict[str, str]:
        from hexwar_sb3.evaluation.matches import play_match

        compile_first()
        start = perf_counter()
        play_match("MA1", "MA2", games=1)
        first, start = perf_counter() - start, perf_counter()
        play_match("MA1", "MA2", games=20)
        return {
            "first game": f"{first:.1f} s (reads the compiled kernels)",
            "games": f"{20 / (perf_counter() - start):.0f} a second, MA1 against MA2",
        }


def _size(folder: Path) -> int:
    """Bytes of all files below a folder."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
