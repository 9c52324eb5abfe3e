"""`hexwar doctor`: what is installed, where things lie, and whether a game runs."""

from __future__ import annotations

import os
import platform
import shutil
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter

from packaging.specifiers import SpecifierSet

from hexwar_sb3.commands.output import compile_first, print_json
from hexwar_sb3.commands.settings import Json
from hexwar_sb3.version import __version__

GAMES = 20
PROBLEM, WARNING = "problem", "warning"
Found = Iterator[tuple[str, str]]  # what was looked at, and what was found


@dataclass(frozen=True, kw_only=True)
class Doctor:
    """Say what is installed, what lies in the cache, and whether a game can be played here.

    Ends with 1 where a package is missing or of a version that is not expected.
    """

    json: Json = False
    clean: bool = False
    """delete kernels from the cache that this copy of hexwar_sb3 under this Python does not use: those of other versions"""
    _said: list[tuple[str, str]] = field(default_factory=list, init=False)  # problems and warnings

    def run(self) -> int:
        """Print the findings as they come, what is wrong last."""
        findings: dict[str, object] = {}
        for looked in (self._versions(), self._extras(), self._machine(), self._cache(), self._game()):
            for name, value in looked:
                findings[name] = value
                if not self.json:
                    print(f"{name:<20} {value}", flush=True)
        if self.json:
            kinds = {kind: [text for one, text in self._said if one == kind] for kind in (PROBLEM, WARNING)}
            print_json({**findings, "problems": kinds[PROBLEM], "warnings": kinds[WARNING]})
        else:
            for kind, text in self._said:
                print(f"\n{kind}: {text}")
        return int(any(kind == PROBLEM for kind, _ in self._said))

    def _versions(self) -> Found:
        from hexwar_sb3.commands.installed import NAME, expected_python, fits, found_version, versions

        yield NAME, __version__
        if found_version(NAME) != __version__:
            known = found_version(NAME) or "not at all"
            self._warn(f"{NAME} is installed as {known}, but {__version__} is imported: install it again")
        python, expected = platform.python_version(), expected_python()
        yield "python", python
        if not SpecifierSet(expected).contains(python, prereleases=True):
            self._problem(f"Python is {python}, expected {expected}")
        for name, found, expected in versions():
            yield name, found or "not installed"
            if not fits(name, expected):
                self._problem(f"{name} is {found or 'not installed'}, expected {expected}")

    def _extras(self) -> Found:
        from hexwar_sb3.commands.installed import extras

        for extra, state in extras():
            yield f"extra {extra}", state

    def _machine(self) -> Found:
        from hexwar_sb3.commands.installed import torch_build

        yield "cores", cores()
        yield "memory", memory()
        try:
            import torch
        except (ImportError, OSError) as error:
            self._problem(f"PyTorch cannot be imported: {error}")
            return
        has_gpu = torch.cuda.is_available()
        build, warning = torch_build(torch.version.cuda, has_gpu)
        yield "torch build", build
        yield "gpu", torch.cuda.get_device_name(0) if has_gpu else "none, the CPU trains"
        if warning:
            self._warn(warning)

    def _cache(self) -> Found:
        from hexwar_sb3.cache import cache
        from hexwar_sb3.commands.caches import clean, describe

        root = cache()
        instead = f"NOT usable: {root.trouble}; instead {root.place or 'nothing is kept'}"
        yield "cache", f"{root.named} ({instead if root.trouble else 'writable'})"
        if root.place is not None:
            if self.clean:
                yield "deleted", f"{clean(root.place) / 1e6:.0f} MB"
            yield from describe(root, root.place)
            yield "free disk", f"{shutil.disk_usage(root.place).free / 1e9:.1f} GB"

    def _game(self) -> Found:
        from hexwar_sb3.evaluation.matches import play_match
        from hexwar_sb3.kernels import COMPILED, counts

        compile_first()
        compiled, start = counts[COMPILED], perf_counter()
        play_match("MA1", "MA2", games=1)
        first, compiled = perf_counter() - start, counts[COMPILED] - compiled
        missing = f"compiled {compiled} kernels, which were not in the cache"
        yield "first game", f"{first:.1f} s ({missing if compiled else 'reads the compiled kernels'})"
        start = perf_counter()
        play_match("MA1", "MA2", games=GAMES)
        yield "games", f"{GAMES / (perf_counter() - start):.0f} a second, MA1 against MA2"

    def _problem(self, text: str) -> None:
        self._said.append((PROBLEM, text))

    def _warn(self, text: str) -> None:
        self._said.append((WARNING, text))


def cores() -> str:
    """How many cores this process may use, and of how many."""
    every = os.cpu_count() or 1
    own = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else every
    return str(every) if own == every else f"{own} of {every}"


def memory() -> str:
    """How much memory this machine has and how much programs can still get, where the system tells."""
    try:
        lines = Path("/proc/meminfo").read_text("ascii").splitlines()
        sizes = {name: int(value.split()[0]) / 1e6 for name, value in (line.split(":") for line in lines)}
        return f"{sizes['MemTotal']:.1f} GB, {sizes['MemAvailable']:.1f} GB of it available"
    except (OSError, LookupError, ValueError):
        return "not known"
