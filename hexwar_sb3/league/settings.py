"""What a league can be told, checked once; it is written down in the league's folder."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from hexwar_sb3.algorithms.preset_file import is_plain, kinds_of
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.algorithms.ranges import check_settings
from hexwar_sb3.bots.registry import BOTS, is_bot
from hexwar_sb3.checks import check_flag, check_share, check_whole
from hexwar_sb3.envs.settings import check_priority
from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.evaluation.opponents import OPPONENTS, with_weights
from hexwar_sb3.players.player import POLICIES

LEARNER: dict[str, Any] = {
    "learning_rate": 2e-4,
    "final_learning_rate": 3e-5,
    "learning_starts": 0,  # before it all pieces would play at random
    "batch_size": 64,
    "gradient_steps": 2,
    "buffer_size": 100_000,
    "tau": 0.005,
    "exploration_initial_eps": 0.05,
    "exploration_final_eps": 0.005,
    "squad_initial_share": 0.1,
    "squad_final_share": 0.02,
}
"""Arguments of QMIX for a model that learns on, where they differ from its own defaults."""

LEARNS_BY = (
    *(
        "learning_rate",
        "final_learning_rate",
        "batch_size",
        "buffer_size",
        "learning_starts",
        "gradient_steps",
    ),
    *("tau", "gamma"),
    *("mixer", "n_steps", "td_lambda", "double_q", "loss", "reward_scale", "stickiness", "max_grad_norm"),
    *("exploration_initial_eps", "exploration_final_eps", "exploration_episodes", "exploration_every"),
    *("squad_initial_share", "squad_final_share", "squad_episodes"),
)
"""Arguments of QMIX that a league may set; none of them names a file."""
MOST = {"buffer_size": 1_000_000, "batch_size": 65_536, "gradient_steps": 1_000, "n_steps": 1_000}
"""Limits of those that cost memory or time."""
RANGES = {
    "iterations": (0, 1_000),
    "keep": (1, 16),
    "games": (1, 1_000_000),
    "fill_games": (0, 100_000),
    "refit_games": (0, 100_000),
    "match_games": (1, 100_000),
    "warm_up_games": (1, 100_000),
    "seed": (0, 999_999),
    "n_envs": (1, 1_024),
    "hidden": (1, 1_024),
    "embed": (1, 1_024),
}


@dataclass(frozen=True, kw_only=True)
class LeagueSettings:
    """Grouped self-play as in III-C and IV-A; whom a model meets beside its partner is weighed by its losses."""

    iterations: int = 10
    keep: int = 4  # models that an iteration keeps, each of which trains; if split, of each colour, and all pairs train
    split: bool = False  # red and blue models of their own, as in the paper; else each plays both camps
    games: int = 3_200  # that each model of a group learns from
    partner_share: float = (
        0.05  # of the weights, for the partners: all that were kept, or the other of the pair
    )
    past_share: float = 0.05  # for the best of the iterations before; priorities double both
    opponents: tuple[str, ...] = OPPONENTS  # bots and HRL0, NAME or NAME=WEIGHT; for them the rest
    worst_share: float = (
        0.5  # of a model's score that selects: what it is behind the best against one of these, at most
    )
    priority: float = 1.0  # exponent by which those who beat the model are met more often
    fill_games: int = 400  # at first, from which nothing learns: they fill its replay
    refit_games: int = 100  # after them, in which the mixer alone learns
    match_games: int = 100  # of each pairing in the round robin that selects
    warm_up_games: int = 200  # against each opponent, to order the first models
    scenario: str = "plain"
    seed: int = 0
    n_envs: int = 32
    hidden: int = 128  # width of the agent networks; narrower ones that the league begins with are widened
    embed: int = 32  # width of a task's embedding
    learner: dict[str, Any] = field(default_factory=lambda: dict(LEARNER))

    def __post_init__(self) -> None:
        """Check everything: a league's file may come from a stranger.

        Raises:
            ConfigError: a number is out of its range, or a value of another kind.
            UnknownNameError: no such argument of the learner.
        """
        for name, (least, most) in RANGES.items():
            check_whole(name, getattr(self, name), least=least, most=most)
        for name in ("partner_share", "past_share", "worst_share"):
            check_share(name, check_number(name, getattr(self, name)))
        check_flag("split", self.split)
        check_priority(self.priority)
        named: tuple[object, ...] = (self.scenario, *self.opponents)
        if not all(isinstance(name, str) for name in named):
            raise ConfigError(
                f"scenario and opponents are names, got {self.scenario!r} and {self.opponents!r}"
            )
        for name in self.weights:
            if not is_bot(name) and name not in POLICIES:
                raise UnknownNameError("opponent", name, (*BOTS, *POLICIES))
        total = self.partner_share + self.past_share
        if total > 1.0:
            raise ConfigError(f"partner_share and past_share must add up to at most 1, got {total}")
        if total < 1.0 and not self.opponents:
            raise ConfigError("without opponents, partner_share and past_share must add up to 1")
        self._check_learner()

    @property
    def weights(self) -> dict[str, float]:
        """Opponents, and their weights."""
        return with_weights(self.opponents) if self.opponents else {}

    @property
    def opponents_share(self) -> float:
        """Of the weights, for opponents."""
        return 1.0 - self.partner_share - self.past_share if self.opponents else 0.0

    def _check_learner(self) -> None:
        check_number("learning_rate of the learner", self.learner.get("learning_rate", 0.0))
        kinds = kinds_of(QMIX)
        for name, value in self.learner.items():
            if name not in LEARNS_BY:
                raise UnknownNameError("argument of the learner", name, LEARNS_BY)
            if not is_plain(value, kinds[name]):
                raise ConfigError(f"{name} of the learner is a number or a name, got {value!r}")
        for name, most in MOST.items():
            check_whole(f"{name} of the learner", self.learner.get(name, 1), least=1, most=most)
        check_settings(self.learner, QMIX.settings)


def check_number(setting: str, value: object) -> float:
    """Return a number.

    Raises:
        ConfigError: it is none.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigError(f"{setting} must be a number, got {value!r}")
    return value
