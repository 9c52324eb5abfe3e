"""Several policies of one camp into one (Fig. 6 (c)): teachers play, the student learns what they would do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from hexwar_sb3.algorithms.distillation import Lesson, learn_from, teach
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.checks import check_share, check_whole
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.league.work import env_steps, job_seed, one_thread
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.policies.task_policy import TaskPolicy


@dataclass(frozen=True, kw_only=True)
class Lessons:
    """How a student is taught."""

    games: int = 400  # that each teacher plays
    epsilon: float = 0.05  # probability of a random task in them
    updates: int = 3_000  # of the student's agent network
    batch_size: int = 128  # situations of the camp
    tau: float = 0.1  # temperature of choices, in scaled points
    learning_rate: float = 1e-3  # falls to 0

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            ConfigError: a number is out of its range.
        """
        for name in ("games", "updates", "batch_size"):
            check_whole(name, getattr(self, name), least=1)
        check_share("epsilon", self.epsilon)
        for name in ("tau", "learning_rate"):
            if not 0.0 < getattr(self, name) < float("inf"):
                raise ConfigError(f"{name} must be finite and above 0, got {getattr(self, name)}")

    def study(
        self, met: Sequence[Lesson], student: TaskPolicy, seed: int, weights: Sequence[float] | None = None
    ) -> list[float]:
        """Let a student learn from what was met, as these settings say; the loss of every update."""
        return learn_from(
            met,
            student,
            updates=self.updates,
            batch_size=self.batch_size,
            tau=self.tau,
            learning_rate=self.learning_rate,
            weights=weights,
            seed=seed,
        )


def distill(
    teachers: Sequence[FrozenPolicy], student: QMIX, env: dict[str, Any], lessons: Lessons, seed: int = 0
) -> list[float]:
    """Teach a model what several policies do; its mixer stays (`QMIX.refit_mixer` fits it again).

    Args:
        teachers: of any widths; the pieces of each are led by its own lower level, those of the student by
            the first one's.
        student: the model that learns.
        env: settings of the games that the teachers play: side, opponent, scenario and so on.
        lessons: how.
        seed: in 0..999999.

    Returns:
        The loss of every update.

    Raises:
        ConfigError: no teacher, other sizes, or a number out of range.
    """
    if not teachers:
        raise ConfigError("distillation needs at least one teacher")
    with one_thread():
        met = []
        for k, teacher in enumerate(teachers):
            own = job_seed(seed, k)
            games = make_vec_env(
                "HexWarTask-v0", seed=seed_for(Purpose.TRAINING, own), **{**env, "lower": teacher.lower}
            )
            settings = games.get_attr("games")[0].settings
            steps = env_steps(vars(settings), lessons.games)
            met.append(teach(teacher, games, steps, lessons.epsilon, own))
        student.lead_with(teachers[0].lower)
        return lessons.study(met, student.policy, seed)
