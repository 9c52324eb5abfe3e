"""The first start: kernels are compiled side by side in processes of their own, and kept."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path

from filelock import FileLock, Timeout

from hexwar_sb3.cache import cache
from hexwar_sb3.kernels import compiles, source_hash, sources_of, toolchain
from hexwar_sb3.version import __version__

_BEGIN = "from hexwar_sb3.engine.world import load_world; load_world('plain').eta"
_PART = "from hexwar_sb3.envs.prepare import compile_part; compile_part({!r})"
_END_WITH_PARENT = (
    "import os, threading; "
    "threading.Thread(target=lambda: os.read(0, 1) or os._exit(1), daemon=True).start(); "
)
LOCK = "{}.lock"  # in the cache folder, one for each compiler: who waits will use what is made
_PARTS = ("play", "look")  # about 80 and 25 s of one core


def prepare(say: Callable[[str], object]) -> None:
    """Compile what games and envs need, unless it was done before.

    Nothing depends on it: a kernel that is missing later is compiled where it is called. But here two
    cores share the work, and the gigabyte that the compiler takes is given back.

    Args:
        say: called with one line for the user if there is something to do.
    """
    if not compiles():
        return
    if not _is_prepared():
        place = cache().place
        if place is None:
            say("compiling the game for this process alone: about two minutes")
            return
        with _alone(place / LOCK.format(toolchain()), say):
            if not _is_prepared():  # who held the lock may have done it
                say("compiling the game for this machine and this Python, once: about two minutes")
                if _compile():
                    cache().keep(toolchain(), _marker(), "\n".join([_made_for(), *_kernels()]).encode())
    cache().prune()


@contextmanager
def _alone(path: Path, say: Callable[[str], object]) -> Iterator[None]:
    """Wait until no other process compiles: two of them would need twice as long, each for the same."""
    lock = FileLock(path)
    try:
        lock.acquire(blocking=False)
    except Timeout:
        say("another process is compiling the game; waiting for it")
        lock.acquire()
    try:
        yield
    finally:
        lock.release()


def _marker() -> str:
    """Name of the list of the kernels that were compiled ahead."""
    return f"prepared-{source_hash(Path(__file__))}.list"


def _is_prepared() -> bool:
    """Whether all was compiled ahead by this very Python from these sources, and still lies there."""
    kernels = cache().read(toolchain(), _marker())
    return kernels is not None and cache().use(toolchain(), kernels.decode().splitlines()[1:])


def _made_for() -> str:
    """First line of the list: what a person would know of the versions."""
    packages = ", ".join(f"{name} {version(name)}" for name in ("numba", "numpy"))
    return f"hexwar_sb3 {__version__}, Python {platform.python_version()}, {packages}"


def _kernels() -> list[str]:
    """Names of the files of all kernels that lie there, of these sources."""
    sources = {source_hash(path) for path in sources_of(Path(__file__))}
    return [name for name in cache().names(toolchain()) if sources & set(name.split("-"))]


def _compile() -> bool:
    """Compile all parts, side by side; whether it went well."""
    return _run([_BEGIN]) and _run([_PART.format(part) for part in _PARTS])


def _run(codes: list[str]) -> bool:
    """Run pieces of code side by side; whether all of them ended well."""
    workers = [start(code) for code in codes]
    try:
        ended = [worker.wait() for worker in workers]
    finally:
        for worker in workers:
            worker.kill()
            with worker:  # closes its pipe
                pass
    return not any(ended)


def start(code: str) -> subprocess.Popen[bytes]:
    """Run code in a process of its own, with the same package and the same cache; it ends with this one."""
    path = os.pathsep.join(str(Path(entry).absolute()) for entry in sys.path)  # "" is where we are
    env = {**os.environ, "PYTHONPATH": path, "HEXWAR_CACHE": str(cache().place)}
    command = [sys.executable, "-P", "-c", _END_WITH_PARENT + code]
    return subprocess.Popen(command, env=env, stdin=subprocess.PIPE)  # noqa: S603  our own code


def compile_part(part: str) -> None:
    """Compile one of the parts by using it; the process ends badly if it could not be kept."""
    from hexwar_sb3.envs.registration import ROUTE_ENV, make_vec_env
    from hexwar_sb3.play.match import play_games

    if part == "play":
        play_games("MA1", "MA2", 1)
    else:
        make_vec_env(n_envs=1, seed=0, privileged_state=True).reset()
        make_vec_env(ROUTE_ENV, n_envs=1, seed=0).reset()
    if cache().lost:
        sys.exit(1)
