"""Settings of the route env, checked once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.checks import check_choice, check_flag, check_number, check_share
from hexwar_sb3.envs.settings import TaskSettings
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps.scenario import ScenarioLike
from hexwar_sb3.players.terms import USUAL, checked_settings

RANDOM_UPPER = "random"
BETA_PER = ("base_hop", "hop")


@dataclass(frozen=True, kw_only=True)
class RouteSettings:
    """What `HexWarRoute-v0` can be told; every value is checked here. Equation (5): r_L = r_task + alpha r_Sigma - beta."""

    scenario: ScenarioLike | Sequence[ScenarioLike] = (
        "plain"  # name, file or object; of several, the games are dealt out in turn
    )
    side: str = "both"  # the learner's camp; "both": red in even games, blue in odd ones
    opponent: object = "MA1"  # a player, a list of them, or a list of (player, weight)
    decision_ticks: int = USUAL.decision_ticks  # Delta-t, ticks
    upper: object = RANDOM_UPPER  # gives the tasks: random valid ones, or a policy of the task level
    keep_task: float = (
        0.9  # probability that a piece keeps its task at a decision, whatever the upper level says
    )
    wander: float = (
        0.5  # probability that a new task is a walk to a random cell: tasks alone lead to few places
    )
    lower: object = "heuristic"  # leads the camp's other pieces: "heuristic", or a network's folder or object
    ways: bool = (
        True  # the fastest ways over the known map are part of the state; else the six neighbours alone
    )
    alpha: float = 0.01  # weight of the camp's reward; >= 0 (IV)
    gain_limit: float = (
        3.0  # points: r_Sigma of a step is cut off here, or the fall of a point drowns ten hops
    )
    beta: float = 0.05  # cost of a step; in [0, 1) (IV)
    beta_per: str = (
        "base_hop"  # a step is the type's hop on open ground, in ticks; "hop": one answer, to the letter
    )
    shaping: float = (
        0.99  # discount of a base hop in the potential of the reward, see `potential`; 0: no potential
    )
    reward: str = "net"  # r_Sigma: own minus enemy, or "paper": the margin by eq. (1)
    decisions: str = USUAL.decisions  # "event": tasks are also given after an own loss or an ended task
    spots: int = USUAL.spots  # k of G^L(k): cells that tasks lead to beside the control points
    fog: bool = USUAL.fog  # False: lights on, for debugging

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            ConfigError: a setting is out of its range.
            UnknownNameError: a choice that does not exist.
        """
        if not self.fields:
            raise ConfigError("name at least one scenario")
        for field in self.fields:
            self.task_settings(field)  # which checks what it takes from here
        check_choice("beta_per", self.beta_per, BETA_PER)
        check_share("keep_task", self.keep_task)
        check_share("wander", self.wander)
        check_share("shaping", self.shaping)
        if not check_number("gain_limit", self.gain_limit) > 0.0:
            raise ConfigError(f"gain_limit must be above 0 points, got {self.gain_limit!r}")
        check_alpha_beta(self.alpha, self.beta)
        check_flag("ways", self.ways)

    @property
    def fields(self) -> tuple[ScenarioLike, ...]:
        """The scenarios, one or more."""
        several = isinstance(self.scenario, list | tuple)
        return tuple(self.scenario) if several else (self.scenario,)  # type: ignore[arg-type, return-value]

    def potential(self, hops: NDArray[np.float64]) -> NDArray[np.float64]:
        """What the fastest way is worth by eq. (5) alone: its end brings 1, each base hop costs beta [n].

        With it the reward becomes r_L + shaping^hops * potential(after) - potential(before), and what is left to learn is
        what a hop loses against the fastest way. The best policy is that of r_L under a discount of `shaping`, if the
        learner has that discount too (Ng, Harada, Russell 1999); under a lower one it is the best way hop by hop.

        Args:
            hops: base hops of the fastest way [n].
        """
        if not self.is_shaped:
            return np.zeros_like(hops)
        left = self.shaping**hops
        paid = hops if self.shaping == 1.0 else (1.0 - left) / (1.0 - self.shaping)
        return left - self.beta * paid

    @property
    def is_shaped(self) -> bool:
        """The reward has a potential: it needs the fastest ways and a cost by time."""
        return self.shaping > 0.0 and self.ways and self.beta_per == "base_hop"

    def task_settings(self, scenario: ScenarioLike) -> TaskSettings:
        """Settings of the games of one scenario."""
        shared = {
            name: getattr(self, name) for name in vars(self) if name in TaskSettings.__dataclass_fields__
        }
        return TaskSettings(**{**shared, "scenario": scenario})


def check_alpha_beta(alpha: float, beta: float) -> None:
    """Check the coefficients of eq. (5).

    Raises:
        ConfigError: one is out of its range.
    """
    check_number("alpha", alpha)
    check_number("beta", beta)
    if not 0.0 <= alpha < float("inf"):
        raise ConfigError(f"alpha must be finite and at least 0 by eq. (5), got {alpha!r}")
    if not 0.0 <= beta < 1.0:
        raise ConfigError(f"beta must be in [0, 1) by eq. (5), got {beta!r}")


def route_settings(settings: dict[str, Any]) -> RouteSettings:
    """Settings from keywords.

    Raises:
        UnknownSettingError: no such setting.
    """
    return checked_settings(RouteSettings, settings)
