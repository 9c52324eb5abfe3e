"""The one module that owns numba: `kernel` compiles a function and caches it safely.

numba's own cache looks only at the file that holds the compiled function, so a change in
another file leaves a stale kernel behind. Here the cache folder is named by the hash of every
source that the file imports, near or far: a stale kernel cannot be loaded, a second start is
fast, and an edit leaves alone what does not depend on it.
Without compilation (`NUMBA_DISABLE_JIT=1`) every kernel runs as plain Python.
"""

from __future__ import annotations

import ast
import hashlib
import os
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias, TypeVar, cast

import numba
import numpy as np
from numba.core import types
from numba.extending import overload

Function = TypeVar("Function", bound=Callable[..., object])

Row: TypeAlias = Any  # one record of a record array; numpy cannot type its fields
Rows: TypeAlias = Any  # a record array

_PACKAGE = Path(__file__).parent


def cache_root() -> Path:
    """Folder for everything that can be made again: compiled kernels, distance fields.

    `HEXWAR_CACHE` names it; otherwise it lies in the user's cache folder.
    """
    named = os.environ.get("HEXWAR_CACHE")
    if named:
        return Path(named)
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "hexwar_sb3"


@lru_cache
def imports_of(path: Path) -> frozenset[Path]:
    """Files of this package that a file imports from, itself included, one step far."""
    found = {path}
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == _PACKAGE.name:
            base = _PACKAGE.parent.joinpath(*str(node.module).split("."))
            named = [base / f"{alias.name}.py" for alias in node.names]
            files = named if named[0].is_file() else [base.with_suffix(".py"), base / "__init__.py"]
            found.update(file for file in files if file.is_file())
    return frozenset(found)


@lru_cache
def source_hash(path: Path) -> str:
    """Hash of numba's version and of every source that a kernel of this file may depend on."""
    closure: set[Path] = set()
    rest = {path, Path(__file__)}
    while rest:
        file = rest.pop()
        closure.add(file)
        rest |= imports_of(file) - closure
    digest = hashlib.sha256(numba.__version__.encode())
    for file in sorted(closure):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def compiles() -> bool:
    """Whether kernels are compiled at all; plain Python with `NUMBA_DISABLE_JIT=1`."""
    return not numba.config.DISABLE_JIT  # type: ignore[attr-defined]


if not compiles():
    np.seterr(over="ignore")  # the dice wrap around 2^64 on purpose; compiled code never warns


@overload(int)
def _int_of_enum(member):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202  # numba compares bare signatures
    """Teach numba `int(Action.MOVE)`, which plain Python knows."""
    if isinstance(member, types.IntEnumMember):
        return lambda member: member.value
    return None


_ARRAY_MAKERS = frozenset({"zeros", "empty", "ones", "full", "arange", "array", "copy"})


def kernel(function: Function) -> Function:
    """Compile `function` on its first call (no fast-math: results are equal to the bit).

    Numba counts the references of every array at every call, which costs more than most of our
    kernels do (measured: the whole drive loop runs twice to three times as fast without). Only a
    kernel that makes arrays needs it, and is known by `np.zeros` and its like; in any other, what
    makes a hidden copy (`rows[i] = rows[j]` of whole rows) stops with "NRT required": write a loop.
    """
    sources = source_hash(Path(function.__code__.co_filename))
    numba.config.CACHE_DIR = str(cache_root() / f"kernels-{sources}")  # type: ignore[attr-defined]  # read by njit
    makes_arrays = not _ARRAY_MAKERS.isdisjoint(function.__code__.co_names)
    options: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": makes_arrays}
    options["no_cfunc_wrapper"] = True  # nobody calls from C: a seventh of the compile time
    return cast("Function", numba.njit(**options)(function))
