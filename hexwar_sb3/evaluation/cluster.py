"""Where jobs are done: on this machine, or on the machines of a Ray cluster."""

from __future__ import annotations

import logging
import socket
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from threading import Lock
from typing import Any

from joblib import parallel_config, register_parallel_backend
from joblib.parallel import BACKENDS, ParallelBackendBase, get_active_backend

from hexwar_sb3.errors import ClusterError, ConfigError, shortened

RAY = "hexwar-ray"  # name of the backend
ANSWER_S = 5.0
RETRIES = 3  # of a job whose machine or process was lost
HERE = frozenset(BACKENDS[name] for name in ("loky", "threading", "multiprocessing", "sequential"))


@contextmanager
def working_on(address: str | None, jobs: int | None = None) -> Iterator[int]:
    """Let `run_jobs` hand its jobs to a Ray cluster while the block runs, and give how many are done side by side.

    Args:
        address: of the cluster, "HOST:PORT" as `ray start --head` says it; this is one of its machines. None: the jobs
            stay on this machine.
        jobs: side by side; None: one, or as many as the cluster has processors.

    Raises:
        ConfigError: Ray is not installed, or this is no address.
        ClusterError: nothing answers there, or, while the block runs, the cluster is lost.

    Example:
        >>> with working_on(None) as jobs:  # or "10.0.0.1:6379"
        ...     print(jobs)
        1
    """
    if address is None:
        yield 1 if jobs is None else jobs
        return
    if find_spec("ray") is None:
        raise ConfigError('a cluster needs ray: pip install "hexwar-sb3[ray]"')
    _check_answers(address)
    ray = import_module("ray")
    with _ray_errors(ray, address):
        ray.init(address=address, log_to_driver=False, logging_level=logging.ERROR)
    try:
        side_by_side = jobs or max(1, int(ray.cluster_resources().get("CPU", 1)))
        register_parallel_backend(RAY, RayTasks)
        with _ray_errors(ray, address), parallel_config(RAY, ray=ray, side_by_side=side_by_side):
            yield side_by_side
    finally:
        ray.shutdown()


def _check_answers(address: str) -> None:
    """Look whether somebody listens there: Ray itself would try for minutes.

    Raises:
        ConfigError: it is no address.
        ClusterError: nobody does.
    """
    host, _, port = address.rpartition(":")
    if not host or "/" in host or not port.isdecimal() or not 0 < int(port) < 1 << 16:
        raise ConfigError(f"a cluster's address is HOST:PORT, got {shortened(repr(address))}")
    try:
        socket.create_connection((host.strip("[]"), int(port)), ANSWER_S).close()
    except OSError as error:
        raise ClusterError(f"the cluster at {shortened(address)}: {error}") from error


@contextmanager
def _ray_errors(ray: Any, address: str) -> Iterator[None]:
    """Say in one line what a cluster does not do.

    Raises:
        ClusterError: it cannot be reached, or a job was lost with its machine too often.
    """
    try:
        yield
    except (ConnectionError, ray.exceptions.RayError) as error:
        lines = [line for line in str(error).splitlines() if line.strip()] or [type(error).__name__]
        said = lines[-1 if isinstance(error, ray.exceptions.RayTaskError) else 0]  # a traceback ends with it
        raise ClusterError(f"the cluster at {address}: {said}") from error


def is_elsewhere() -> bool:
    """Whether jobs are done by processes that need not see this machine's files: joblib's active backend is not its own."""
    return type(get_active_backend()[0]) not in HERE


class RayTasks(ParallelBackendBase):  # type: ignore[misc]  # joblib has no types
    """joblib's jobs as tasks of Ray: each goes to a processor that is free, and to another when its machine is lost.

    Ray's own backend for joblib hands jobs to its processes in turn, free or not, gives no result before all are there,
    and loses what a lost process was to do.

    Args:
        ray: the module.
        side_by_side: jobs that are handed over at a time.
        how: further arguments of joblib's backends.
    """

    supports_retrieve_callback = True

    def __init__(self, ray: Any = None, side_by_side: int = 1, **how: Any) -> None:
        super().__init__(**how)
        self.ray, self.side_by_side = ray, side_by_side
        self._running: set[Any] = set()
        self._lock = Lock()

    def effective_n_jobs(self, n_jobs: int) -> int:
        """Jobs that joblib keeps under way; one alone it would do in this process."""
        return max(2, n_jobs)

    def start_call(self) -> None:
        """Begin: a thread a job waits for it."""
        self._task = self.ray.remote(num_cpus=1, max_retries=RETRIES)(_call)
        self._has_ended = False
        self._waiting = ThreadPoolExecutor(self.side_by_side, "waits for a job")

    def submit(self, func: Callable[[], Any], callback: Callable[[Future[Any]], Any]) -> Future[Any]:
        """Hand a job over, as soon as a thread is free."""
        future = self._waiting.submit(self._do, func)
        future.add_done_callback(callback)
        return future

    def retrieve_result_callback(self, out: Future[Any]) -> Any:
        """What a job returned, or the error that it ended with."""
        return out.result()

    def _do(self, func: Callable[[], Any]) -> Any:
        with self._lock:
            if self._has_ended:
                raise CancelledError
            task = self._task.remote(func)
            self._running.add(task)
        try:
            return self.ray.get(task)
        finally:
            self._running.discard(task)

    def abort_everything(self, ensure_ready: bool = True) -> None:
        """End what runs: after an error, or Ctrl-C."""
        with self._lock:
            self._has_ended = True
            for task in list(self._running):
                self.ray.cancel(task, force=True)
        self.terminate()
        if ensure_ready:
            self.start_call()

    def terminate(self) -> None:
        """Wait until the threads have ended: one that asked Ray later, when it is shut down, would end this process."""
        self._waiting.shutdown(cancel_futures=True)


def _call(func: Callable[[], Any]) -> Any:
    return func()
