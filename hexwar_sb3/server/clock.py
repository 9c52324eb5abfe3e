"""The clock of a game that a person plays: whether it runs, how fast, and how far."""

from __future__ import annotations

from dataclasses import dataclass

from hexwar_sb3.players.terms import DECISION_TICKS

USUAL_SPEED = 8  # ticks a second
MESSAGES_A_SECOND = 8  # at most, while the clock runs
STEP_SPEED, STEP_BATCH = 256, 16  # of a step: ticks a second, and from one message to the next
FINISH_BATCH = 75  # ticks from one message to the next, once nobody gives orders any more


@dataclass
class Clock:
    """When the next ticks are played; what it does depends on what was asked, and on nothing in the game."""

    speed: int = USUAL_SPEED
    running: bool = False
    until: int | None = None  # tick at which a step ends
    to_event: bool = False  # a step ends with the next event
    finishing: bool = False

    def run(self, speed: int) -> None:
        """Run at so many ticks a second, until something stops it."""
        self.stop()
        self.running, self.speed = True, speed

    def step(self, to: str, tick: int) -> None:
        """Run to the next tick, event or decision."""
        self.stop()
        ends = {"tick": tick + 1, "decision": (tick // DECISION_TICKS + 1) * DECISION_TICKS}
        self.running, self.until, self.to_event = True, ends.get(to), to == "event"

    def finish(self) -> None:
        """Run to the end of the game."""
        self.stop()
        self.running = self.finishing = True

    def stop(self) -> None:
        """Stop."""
        self.running = self.to_event = self.finishing = False
        self.until = None

    @property
    def steps(self) -> bool:
        """Whether it runs for a step."""
        return self.to_event or self.until is not None

    @property
    def batch(self) -> int:
        """Ticks from one message to the next."""
        if self.finishing:
            return FINISH_BATCH
        return STEP_BATCH if self.steps else -(-self.speed // MESSAGES_A_SECOND)

    @property
    def seconds(self) -> float:
        """How long a batch takes."""
        if self.finishing:
            return 0.0
        return self.batch / (STEP_SPEED if self.steps else self.speed)
