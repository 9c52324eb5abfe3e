"""The one module that owns numba: `kernel` compiles a function and keeps what was compiled.

numba's own cache looks only at the file that holds the compiled function, so a change in another file leaves a stale
kernel behind; it lies where the whole process' settings say; and a damaged file in it ends the program. Here a kernel
is filed under the hash of every source that its file imports, near or far: a stale kernel cannot be loaded, a second
start is fast, and an edit leaves alone what does not depend on it. The folder is named by all else that it depends on.
Without compilation (`NUMBA_DISABLE_JIT=1`) every kernel runs as plain Python.
"""

from __future__ import annotations

import ast
import hashlib
import pickle
import sys
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias, TypeVar, cast

import llvmlite  # type: ignore[import-untyped]  # comes with numba
import numba
import numpy as np
from numba.core import types
from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.registry import cpu_target
from numba.core.serialize import dumps
from numba.extending import overload

from hexwar_sb3.cache import cache

Function = TypeVar("Function", bound=Callable[..., object])

Row: TypeAlias = Any  # one record of a batch that Python walks; kernels name the record's class (records.py)
Rows: TypeAlias = Any  # an array, or records, of a batch

READ, COMPILED = "read", "compiled"
counts: Counter[str] = Counter()  # of kernels in this process: read from the cache, compiled

_PACKAGE = Path(__file__).parent
_NO_KERNELS = frozenset({_PACKAGE / "cache.py"})  # no kernel reads what it says
_BROKEN = (
    pickle.UnpicklingError,
    ArithmeticError,
    AttributeError,
    EOFError,
    ImportError,
    LookupError,
    RuntimeError,
    TypeError,
    ValueError,
)
_SETTINGS = ("OPT", "BOUNDSCHECK", "DEBUGINFO_DEFAULT", "ENABLE_AVX", "LOOP_VECTORIZE", "SLP_VECTORIZE")


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
    return frozenset(found - _NO_KERNELS)


@lru_cache
def source_hash(path: Path) -> str:
    """Hash of every source that a kernel of this file may depend on."""
    digest = hashlib.sha256()
    for file in sorted(sources_of(path)):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def sources_of(path: Path) -> frozenset[Path]:
    """Every source that a kernel of this file may depend on, itself included."""
    closure: set[Path] = set()
    rest = {path, Path(__file__)}
    while rest:
        file = rest.pop()
        closure.add(file)
        rest |= imports_of(file) - closure
    return frozenset(closure)


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
    makes_arrays = not _ARRAY_MAKERS.isdisjoint(function.__code__.co_names)
    options: dict[str, Any] = {"nogil": True, "error_model": "numpy", "_nrt": makes_arrays}
    options["no_cfunc_wrapper"] = True  # nobody calls from C: a seventh of the compile time
    compiled = numba.njit(**options)(function)
    if compiles():
        compiled._cache = Kept(function)  # noqa: SLF001  the place of numba's own, without its settings
    return cast("Function", compiled)


@lru_cache
def toolchain() -> str:
    """Part of the cache for kernels of this Python, these packages, this processor and these settings of numba."""
    versions = numba.__version__, llvmlite.__version__, np.__version__, sys.implementation.cache_tag
    processor = cpu_target.target_context.codegen().magic_tuple()
    settings = [str(getattr(numba.config, name, None)) for name in _SETTINGS]
    return f"kernels-{hashlib.sha256(repr((versions, processor, settings)).encode()).hexdigest()[:16]}"


class Kept(NullCache):
    """Files of one kernel, one a signature: numba looks here before it compiles, and hands over what it compiled."""

    def __init__(self, function: Callable[..., object]) -> None:
        source = Path(function.__code__.co_filename)
        name = f"{source.stem}.{function.__qualname__}-{source_hash(source)}"
        self.name = name.replace("<", "").replace(">", "")  # as Windows wants it
        cells = [cell.cell_contents for cell in function.__closure__ or ()]  # of a function made by another
        self.made_of = dumps((function.__code__.co_code, cells)) if cells else b""  # type: ignore[no-untyped-call]
        self.cache = cache()

    def _file(self, signature: object) -> str:
        key = hashlib.sha256(str(signature).encode() + self.made_of).hexdigest()[:16]
        return f"{self.name}-{key}.kernel"

    def load_overload(self, signature: object, context: Any) -> CompileResult | None:
        """The kernel of a signature; None: it must be compiled."""
        context.refresh()
        kept = self.cache.read(toolchain(), self._file(signature))
        if kept is not None:
            with suppress(*_BROKEN):
                result = CompileResult._rebuild(context, *pickle.loads(kept))  # type: ignore[no-untyped-call]  # noqa: S301, SLF001  our own file
                counts[READ] += 1
                return result
        counts[COMPILED] += 1
        _ = self.cache.place  # if there is none, that is said before the wait
        return None

    def save_overload(self, signature: object, result: Any) -> None:
        """File what was compiled, unless it holds addresses of this process."""
        if self.cache.place and not result.library.has_dynamic_globals:
            self.cache.keep(toolchain(), self._file(signature), dumps(result._reduce()))  # type: ignore[no-untyped-call]  # noqa: SLF001
