"""A Ray cluster of three machines on one: each node has its own working folder, home, temporary folder and cache."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from time import monotonic, sleep

from hexwar_sb3.cache import cache

JOB = "hexwar_sb3-job-*"  # temporary folder of a job that a worker does
START_S = 180
STORE_BYTES = 100_000_000


class Node:
    """One of them."""

    def __init__(self, folder: Path, *how: str) -> None:
        self.folder = folder
        for name in ("work", "home", "tmp"):
            (folder / name).mkdir(parents=True)
        shutil.copytree(str(cache().place), folder / "cache", copy_function=link)  # nobody compiles again
        own = {
            "HOME": folder / "home",
            "TMPDIR": folder / "tmp",
            "HEXWAR_CACHE": folder / "cache",
            "RAY_raylet_start_wait_time_s": str(START_S),
        }
        settings = [
            "--num-cpus=1",
            f"--object-store-memory={STORE_BYTES}",
            "--disable-usage-stats",
            "--block",
        ]
        with (folder / "said").open("wb") as said:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "ray.scripts.scripts", "start", *settings, *how],
                env={**os.environ, **{name: str(value) for name, value in own.items()}},
                cwd=folder / "work",
                stdout=said,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def wait(self) -> None:
        """Wait until it has begun."""
        try:
            until(self._has_begun, START_S)
        except AssertionError as error:
            raise AssertionError((self.folder / "said").read_text(encoding="utf-8")) from error

    def _has_begun(self) -> bool:
        assert self.process.poll() is None
        return b"Ray runtime started" in (self.folder / "said").read_bytes()

    def jobs(self) -> set[Path]:
        """Folders of the jobs that it does, and of those that were ended by force."""
        return set((self.folder / "tmp").glob(JOB))

    def kill(self) -> None:
        """Let it die with all its processes, without a word."""
        for pid in [self.process.pid, *descendants(self.process.pid)]:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        self.process.wait()


def link(source: str, target: str) -> None:
    """Give a file a second name, or, on another file system, a copy."""
    try:
        os.link(source, target)
    except OSError:
        shutil.copyfile(source, target)


def descendants(pid: int) -> list[int]:
    """Processes that a process has started, and theirs."""
    found: list[int] = []
    with suppress(OSError):
        for children in Path(f"/proc/{pid}/task").glob("*/children"):
            for child in map(int, children.read_text(encoding="ascii").split()):
                found += [child, *descendants(child)]
    return found


def until(what: Callable[[], bool], seconds: float) -> None:
    """Wait until a function says yes."""
    end = monotonic() + seconds
    while not what():
        assert monotonic() < end
        sleep(0.05)


@contextmanager
def three_nodes() -> Iterator[tuple[str, list[Node]]]:
    """Start them; the address, and the nodes, of which the first is the head."""
    folder = Path(tempfile.mkdtemp(prefix="hw-ray-"))  # a short name: Ray's sockets lie below
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port = one.getsockname()[1]
    address = f"127.0.0.1:{port}"
    nodes: list[Node] = []
    try:
        own = ("--head", "--node-ip-address=127.0.0.1", f"--port={port}", "--include-dashboard=false")
        nodes.append(Node(folder / "head", *own))
        nodes[0].wait()
        for name in (
            "second",
            "third",
        ):  # one after the other: on one machine they would be in each other's way
            nodes.append(
                Node(folder / name, f"--address={address}", f"--node-ip-address=127.0.0.{len(nodes) + 1}")
            )
            nodes[-1].wait()
        yield address, nodes
    finally:
        for node in reversed(nodes):
            node.kill()
        shutil.rmtree(folder, ignore_errors=True)
