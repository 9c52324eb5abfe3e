"""A second core for what does not wait for the rest of an update."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from typing import Any, ParamSpec, TypeVar

import torch

P = ParamSpec("P")
T = TypeVar("T")


class Here(Executor):
    """Computes at once, in the thread that asks."""

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Call the function now."""
        future: Future[T] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


def executor(cores: int) -> Executor:
    """Who computes beside the main thread, so that results have the same bits on one core and on two.

    torch's own threads cut sums into as many parts as there are threads, and a sum of other parts has other bits.

    Args:
        cores: 1 computes in the thread that asks; more start one further thread.
    """
    if cores < 2:
        return Here()
    init: dict[str, Any] = {"initializer": torch.set_num_threads, "initargs": (1,)}
    return ThreadPoolExecutor(1, "beside the update", **init)
