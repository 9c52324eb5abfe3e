"""Processes that end with the one that started them, however it ends."""

from __future__ import annotations

import ctypes
import os
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cache
from time import sleep
from typing import Any, NoReturn

PARENT = "HEXWAR_PARENT"  # environment of a process that ends with its parent: the parent's number
POLL_S = 0.5
ORPHANED = 1  # exit code

if sys.platform == "win32":
    import _winapi

    OWN_GROUP: dict[str, Any] = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
else:
    OWN_GROUP: dict[str, Any] = {"process_group": 0}


_KEPT = 1 << 30  # bytes; more is taken from the system, and given back at once
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # of glibc's mallopt


@cache
def keep_memory() -> None:
    """Let the C library keep what arrays free: else every update of a network asks the system for it again.

    For a process that is ours alone, since it holds for all of it. Measured: an update is 7 % faster.
    """
    if not sys.platform.startswith("linux"):
        return
    with suppress(OSError, AttributeError):  # of another C library
        mallopt = ctypes.CDLL(None).mallopt
        for option in (_TRIM_THRESHOLD, _MMAP_THRESHOLD):
            mallopt(option, _KEPT)


def start_python(
    arguments: Sequence[str], environment: Mapping[str, str] | None = None, **how: Any
) -> subprocess.Popen[bytes]:
    """Start Python in a process of its own group: the terminal's Ctrl-C is its parent's.

    Args:
        arguments: of Python; what runs there calls `end_with_parent` as it begins.
        environment: beside that of this process.
        how: further arguments of `subprocess.Popen`.
    """
    return subprocess.Popen(  # noqa: S603  # our own modules
        [sys.executable, *arguments],
        stdin=subprocess.DEVNULL,
        env={**os.environ, **(environment or {}), PARENT: str(os.getpid())},
        **OWN_GROUP,
        **how,
    )


def end_with_parent() -> None:
    """Let this process end soon after the one that started it by `start_python`; one that another started goes on."""
    parent = os.environ.pop(PARENT, "")  # not for processes that this one starts
    if parent.isdecimal():
        end_with(int(parent))


@cache
def end_with(parent: int) -> None:
    """Let this process end soon after its parent, which may have ended already."""
    threading.Thread(target=_end_after, args=(parent,), daemon=True, name="end with parent").start()


def _end_after(parent: int) -> NoReturn:
    if sys.platform == "win32":  # the number of the parent stays there when it is gone
        try:
            handle = _winapi.OpenProcess(_winapi.SYNCHRONIZE, False, parent)
            _winapi.WaitForSingleObject(handle, _winapi.INFINITE)
        except OSError:
            pass
    else:
        while os.getppid() == parent:
            sleep(POLL_S)
    os._exit(ORPHANED)
