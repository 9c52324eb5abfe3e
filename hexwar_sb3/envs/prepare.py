"""The first start: kernels are compiled side by side in processes of their own, and kept."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from hexwar_sb3.kernels import cache_root, compiles, source_hash

_BEGIN = "from hexwar_sb3.engine.world import load_world; load_world('plain').eta"
_PART = "from hexwar_sb3.envs.prepare import compile_part; compile_part({!r})"
_PARTS = ("play", "look")  # about 80 and 25 s of one core


def prepare(say: Callable[[str], object]) -> None:
    """Compile what games and envs need, unless it was done before.

    Nothing depends on it: a kernel that is missing later is compiled where it is called. But here two
    cores share the work, and the gigabyte that the compiler takes is given back.

    Args:
        say: called with one line for the user if there is something to do.
    """
    done = cache_root() / f"prepared-{source_hash(Path(__file__))}"
    if done.exists() or not compiles():
        return
    say("compiling the game for this machine, once: about two minutes")
    start(_BEGIN).wait()
    workers = [start(_PART.format(part)) for part in _PARTS]
    try:
        codes = [worker.wait() for worker in workers]
    finally:
        for worker in workers:
            worker.kill()
    if not any(codes):
        done.touch()


def start(code: str) -> subprocess.Popen[bytes]:
    """Run code in a process of its own."""
    return subprocess.Popen([sys.executable, "-c", code])  # noqa: S603  our own code


def compile_part(part: str) -> None:
    """Compile one of the parts by using it."""
    from hexwar_sb3.envs.registration import ROUTE_ENV, make_vec_env
    from hexwar_sb3.play.match import play_games

    if part == "play":
        play_games("MA1", "MA2", 1)
    else:
        make_vec_env(n_envs=1, seed=0, privileged_state=True).reset()
        make_vec_env(ROUTE_ENV, n_envs=1, seed=0).reset()
