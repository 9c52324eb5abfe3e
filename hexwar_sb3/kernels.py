"""The one module that owns numba: `kernel` compiles a function and caches it safely.

numba's own cache looks only at the file that holds the compiled function, so a change in
another file leaves a stale kernel behind. Here the cache folder is named by the hash of every
kernel source: a stale kernel cannot be loaded, and a second start is fast.
Without compilation (`NUMBA_DISABLE_JIT=1`) every kernel runs as plain Python.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
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
_KERNEL_LAYERS = ("rules", "maps", "engine", "tasks", "bots", "play")


def cache_root() -> Path:
    """Folder for everything that can be made again: compiled kernels, distance fields.

    `HEXWAR_CACHE` names it; otherwise it lies in the user's cache folder.
    """
    named = os.environ.get("HEXWAR_CACHE")
    if named:
        return Path(named)
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "hexwar_sb3"


def source_hash() -> str:
    """Hash of every source file that a kernel may come from, and of numba's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    digest.update(Path(__file__).read_bytes())
    for layer in _KERNEL_LAYERS:
        for path in sorted((_PACKAGE / layer).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


# numba.config makes its names at run time
numba.config.CACHE_DIR = str(cache_root() / f"kernels-{source_hash()}")  # type: ignore[attr-defined]

if numba.config.DISABLE_JIT:
    np.seterr(over="ignore")  # the dice wrap around 2^64 on purpose; compiled code never warns


@overload(int)
def _int_of_enum(member):  # type: ignore[no-untyped-def]  # numba compares the bare signatures
    """Teach numba `int(Action.MOVE)`, which plain Python knows."""
    if isinstance(member, types.IntEnumMember):
        return lambda member: member.value
    return None


def kernel(function: Function) -> Function:
    """Compile `function` on its first call (no fast-math: results are equal to the bit)."""
    return cast("Function", numba.njit(cache=True, nogil=True, error_model="numpy")(function))
