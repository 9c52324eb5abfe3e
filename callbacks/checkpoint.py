"""Checkpoints from which a run goes on as if it had never stopped, and a Ctrl-C that makes one."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import cast

from hexwar_sb3.algorithms.checkpoint import save_checkpoint
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.every import EverySteps

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Checkpoint(EverySteps):
    """Saves everything that a resumed run needs, between two vector steps.

    Args:
        every: env steps between two checkpoints.
        path: the checkpoint's file; each one replaces the one before.
    """

    def __init__(self, every: int, path: Path) -> None:
        super().__init__(every)
        self.path = path
        self._asked = False

    def now(self) -> int:
        """Env steps of all levels: a lower level may train for long while the upper one stands still."""
        return int(getattr(self.model, "env_steps", self.model.num_timesteps))

    def fire(self) -> None:
        """Save."""
        save_checkpoint(cast("QMIX", self.model), self.path)

    def _on_rollout_start(self) -> None:
        if self._asked:
            self.fire()
            raise KeyboardInterrupt
        super()._on_rollout_start()

    @contextmanager
    def on_signal(self) -> Iterator[None]:
        """While this block runs, Ctrl-C and SIGTERM save first; a second one stops at once.

        Raises:
            KeyboardInterrupt: after saving.
        """
        handlers = {number: signal.signal(number, self._ask) for number in SIGNALS}
        try:
            yield
        finally:
            for number, handler in handlers.items():
                signal.signal(number, handler)

    def _ask(self, number: int, frame: FrameType | None) -> None:
        if self._asked:
            raise KeyboardInterrupt
        self._asked = True
