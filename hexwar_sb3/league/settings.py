"""What a league can be told, checked once; it is written down in the league's folder."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from hexwar_sb3.algorithms.preset_file import is_plain, kinds_of
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.algorithms.ranges import check_settings
from hexwar_sb3.bots.registry import BOTS, is_bot
from hexwar_sb3.checks import check_whole
from hexwar_sb3.envs.settings import check_share
from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.league.distil import Lessons
from hexwar_sb3.league.plans import Planning
from hexwar_sb3.league.school import School

LEARNER: dict[str, Any] = {
    "learning_rate": 1e-3,  # of the first iteration
    "learning_starts": 0,
    "tau": 0.005,  # a model plays as the mean of its last updates
    "buffer_size": 17_000,  # a group's games
    "stickiness": 0.97,  # a random task lasts for most of a game
    "exploration_initial_eps": 0.01,
    "exploration_final_eps": 0.002,
}
"""Arguments of QMIX for a model that learns on; epsilon falls over the first 60 % of its games, with those of the refit."""

EXPLORING_SHARE = 0.6
LEARNS_BY = (
    *("learning_rate", "batch_size", "buffer_size", "learning_starts", "gradient_steps", "tau", "gamma"),
    *("mixer", "n_steps", "td_lambda", "double_q", "loss", "reward_scale", "stickiness", "max_grad_norm"),
    *("exploration_initial_eps", "exploration_final_eps", "exploration_episodes", "exploration_every"),
)
"""Arguments of QMIX that a league may set; none of them names a file."""
MOST = {"buffer_size": 1_000_000, "batch_size": 65_536, "gradient_steps": 1_000, "n_steps": 1_000}
"""Limits of those that cost memory or time."""
MOST_TRIALS = 100_000
SURVIVORS = (10, 3, 1)  # of the orders that are tried, after each of the trials
RANGES = {
    "iterations": (0, 1_000),
    "keep": (1, 16),
    "games": (1, 1_000_000),
    "rounds": (1, 1_000),
    "refit_games": (0, 100_000),
    "school_rounds": (0, 1_000),
    "school_games": (1, 100_000),
    "school_updates": (1, 1_000_000),
    "trial_games": (1, 100_000),
    "match_games": (1, 100_000),
    "warm_up_games": (1, 100_000),
    "seed": (0, 999_999),
    "n_envs": (1, 1_024),
    "hidden": (1, 1_024),
    "embed": (1, 1_024),
}


@dataclass(frozen=True, kw_only=True)
class LeagueSettings:
    """Grouped self-play as in III-C and IV-A; beside it school, opponents of the past and bots."""

    iterations: int = 10
    keep: int = 4  # models of each colour that an iteration keeps; keep * keep groups train
    school_rounds: int = 1  # of lessons, for those that were kept; 0: none, as in the paper
    school_games: int = 64  # of a round, against each opponent of the school
    school_updates: int = 1_200  # of a round
    school_trials: tuple[int, ...] = (16, 48, 120)  # games in which an order is tried
    games: int = 200  # that each of the two models of a group then learns from by itself
    rounds: int = 2  # parts of them: red and blue learn in turn
    anchor: float = 0.1  # weight of staying near what entered the group; 0: as in the paper
    partner_share: float = 0.2  # of these games against the partner
    past_share: float = 0.3  # against the best of the iterations before; half of them are the very first's
    # of these games the rest; the worst result against one of them weighs as much in the average that selects
    bots: tuple[str, ...] = ("MA1", "MA2", "all-main")
    refit_games: int = 50  # before them, in which the mixer alone learns: it is new, the replay empty
    cooling: float = 0.85  # an iteration's learning rate, as part of that before it
    trial_games: int = 60  # of a version against each of its rivals; the best is the group's
    match_games: int = 50  # of each pairing in the round robin that selects
    warm_up_games: int = 400  # against each of MA1 and MA2, to choose the first models
    scenario: str = "plain"
    seed: int = 0
    n_envs: int = 32
    hidden: int = 64  # width of the agent networks; narrower ones that the league begins with are widened
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
        for name in ("partner_share", "past_share", "cooling"):
            check_share(name, check_number(name, getattr(self, name)))
        if not 0.0 <= check_number("anchor", self.anchor) < float("inf"):
            raise ConfigError(f"anchor must be finite and at least 0, got {self.anchor}")
        named: tuple[object, ...] = (self.scenario, *self.bots)
        if not all(isinstance(name, str) for name in named):
            raise ConfigError(f"scenario and bots are names, got {self.scenario!r} and {self.bots!r}")
        for bot in self.bots:
            if not is_bot(bot):
                raise UnknownNameError("bot", bot, BOTS)
        if len(set(self.bots)) < len(self.bots):
            raise ConfigError(f"each of the bots is named once, got {self.bots!r}")
        total = self.partner_share + self.past_share
        if total > 1.0:
            raise ConfigError(f"partner_share and past_share must add up to at most 1, got {total}")
        if total < 1.0 and not self.bots:
            raise ConfigError("without bots, partner_share and past_share must add up to 1")
        if not 1 <= len(self.school_trials) <= len(SURVIVORS):
            raise ConfigError(f"school_trials are 1 to {len(SURVIVORS)} numbers, got {self.school_trials}")
        for games in self.school_trials:
            check_whole("games of school_trials", games, least=1, most=MOST_TRIALS)
        self._check_learner()

    @property
    def bots_share(self) -> float:
        """Of the games, against bots."""
        return 1.0 - self.partner_share - self.past_share if self.bots else 0.0

    @property
    def school(self) -> School:
        """Of models that were kept."""
        lessons = Lessons(games=self.school_games, epsilon=0.03, updates=self.school_updates, batch_size=64)
        trials = tuple(zip(self.school_trials, SURVIVORS, strict=False))
        return School(lessons=lessons, rounds=self.school_rounds, planning=Planning(trials=trials))

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
