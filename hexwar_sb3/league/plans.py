"""Plans: which standing order a policy had better follow against opponents that it can tell apart, and from when on.

A policy learns to follow an order against one opponent and not against another only where the two look different. So
it plays freely, and what it sees at a few times divides the opponents into groups of those who look alike; an order
that begins at such a time is for a whole group. The best order against each opponent by itself, which nobody can
know in time, would be better on paper: a student of it takes one opponent for another and has neither.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.envs.settings import check_share
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.panel import Terms
from hexwar_sb3.evaluation.seeds import seed_for
from hexwar_sb3.league.work import Opponents, env_settings, env_steps, job_seed
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.play.standing_orders import LedPolicy, StandingOrder, standing_orders, ticks_left
from hexwar_sb3.rules.enums import Camp

Group = tuple[int, ...]  # places of opponents


@dataclass(frozen=True, kw_only=True)
class Planning:
    """How plans are found."""

    times: tuple[int, ...] = (300, 450)  # ticks from a game's start at which orders may begin
    trials: tuple[tuple[int, int], ...] = ((16, 10), (48, 3), (120, 1))  # games, how many orders go on
    gain: float = 0.03  # in win rate, that an order must bring
    enough: float = 0.95  # win rate that needs none
    sights: int = 32  # games in which it is seen who looks alike
    told_apart: float = 0.9  # share of them that must look more like another game against the same opponent

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            ConfigError: one is out of its range.
        """
        for time in self.times:
            check_whole("time of an order", time, least=1)
        if list(self.times) != sorted(set(self.times)):
            raise ConfigError(f"times of orders must rise, got {self.times}")
        for games, left in self.trials:
            check_whole("games of a trial", games, least=1)
            check_whole("candidates after a trial", left, least=1)
        check_whole("sights", self.sights, least=2)
        for name in ("gain", "enough", "told_apart"):
            check_share(name, getattr(self, name))


@dataclass(frozen=True)
class Plan:
    """An order or none against each of some opponents, and what it wins."""

    orders: tuple[StandingOrder | None, ...]
    win_rates: tuple[float, ...]

    def worth(self, weights: Sequence[float]) -> float:
        """Average win rate."""
        return float(np.average(self.win_rates, weights=weights))


Choices = Mapping[int, tuple[StandingOrder | None, float]]  # by opponent


@dataclass(frozen=True)
class Planner:
    """Finds the plan of a policy.

    Args:
        policy: who is to be led.
        camp: "red" or "blue".
        opponents: players of the other camp, with weights.
        planning: how.
        terms: of the games; their number and seed are the trials'.
    """

    policy: FrozenPolicy
    camp: str
    opponents: Opponents
    planning: Planning
    terms: Terms

    def plan(self) -> Plan:
        """Find it: at each time a group's order, if that is better than to wait and see."""
        everybody = tuple(range(len(self.opponents)))
        choices = self._wait(everybody, self._times)
        return Plan(*zip(*(choices[k] for k in everybody), strict=True))

    @property
    def _times(self) -> tuple[int, ...]:
        return tuple(time for time in self.planning.times if time < self._game_ticks)

    @property
    def _game_ticks(self) -> int:
        return load_world(self.terms.scenario).scenario.game_ticks

    def _wait(self, group: Group, times: tuple[int, ...]) -> Choices:
        """What is best against opponents if nothing is ordered before the first of these times."""
        if not times or self._mean(self._free, group) >= self.planning.enough:
            return {k: (None, self._free[k]) for k in group}
        found: dict[int, tuple[StandingOrder | None, float]] = {}
        for alike in self._alike(group, times[0]):
            waiting, ordered = self._wait(alike, times[1:]), self._order(alike, times[0])
            rates = [
                self._mean({k: rate for k, (_, rate) in one.items()}, alike) for one in (waiting, ordered)
            ]
            found |= ordered if rates[1] >= rates[0] + self.planning.gain else waiting
        return found

    def _order(self, group: Group, time: int) -> Choices:
        """Return the best order from this time on against a group: the better ones of each trial go on to the next."""
        scenario = load_world(self.terms.scenario).scenario
        orders = standing_orders(
            scenario, Camp[self.camp.upper()], len(scenario.points) + self.terms.spots, time
        )
        best: dict[int, float] = {}
        for part, (games, left) in enumerate(self.planning.trials):
            each = -(-games // len(group))
            played = [(self._play(LedPolicy(self.policy, one), group, each, part), one) for one in orders]
            played.sort(key=lambda found: self._mean(found[0], group), reverse=True)
            orders, best = [one for _, one in played[:left]], played[0][0]
        return {k: (orders[0], best[k]) for k in group}

    @cached_property
    def _free(self) -> dict[int, float]:
        """Win rate of the policy by itself, by opponent."""
        trials = self.planning.trials
        return self._play(self.policy, tuple(range(len(self.opponents))), trials[-1][0], len(trials))

    def _play(self, player: object, group: Group, games: int, part: int) -> dict[int, float]:
        terms = replace(self.terms, games=games, seed=job_seed(self.terms.seed, part))
        results = {k: terms.play_as(self.camp, player, self.opponents[k][0]) for k in group}
        return {k: result.win_rate.value for k, result in results.items()}

    def _mean(self, rates: Mapping[int, float], group: Group) -> float:
        return float(np.average([rates[k] for k in group], weights=[self.opponents[k][1] for k in group]))

    def _alike(self, group: Group, time: int) -> list[Group]:
        """Divide opponents into groups of those who look alike at a time."""
        place = self._times.index(time)
        parts: list[list[int]] = []
        for k in group:
            own = self._sights[k][place]
            near = [
                part
                for part in parts
                if any(tell_apart(own, self._sights[j][place]) < self.planning.told_apart for j in part)
            ]
            parts = [part for part in parts if part not in near]
            parts.append([*(j for part in near for j in part), k])
        return [tuple(sorted(part)) for part in parts]

    @cached_property
    def _sights(self) -> list[NDArray[np.float32]]:
        """What all pieces observe, by opponent: [time, game, feature], of the policy by itself."""
        return [self._look(opponent) for opponent, _ in self.opponents]

    def _look(self, opponent: object) -> NDArray[np.float32]:
        games = self.planning.sights
        settings = {**env_settings(self.terms, games), "side": self.camp, "lower": self.policy.lower}
        seed = seed_for(self.terms.purpose, self.terms.seed)
        env = make_vec_env("HexWarTask-v0", seed=seed, opponent=opponent, **settings)
        left = np.array([self._game_ticks - time for time in self._times])
        obs: Any = env.reset()
        seen = np.zeros((len(left), games), bool)
        found = np.zeros((len(left), games, obs["obs"][0].size), np.float32)
        for _ in range(2 * env_steps(settings, 1)):  # twice, as decisions may come early
            new = (ticks_left(obs) <= left[:, None]) & ~seen
            found[new] = np.broadcast_to(obs["obs"].reshape(games, -1), found.shape)[new]
            seen |= new
            if seen.all():
                break
            obs, _, _, _ = env.step(self.policy.act(obs))
        return found


def tell_apart(some: NDArray[np.float32], others: NDArray[np.float32]) -> float:
    """Share of games whose nearest neighbour is of its own kind: 0.5 by chance, 1 if all can be told apart.

    Args:
        some: sights of one kind [game, feature].
        others: of another.
    """

    def distances(a: NDArray[np.float32], b: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.array([((b - row) ** 2).sum(axis=1) for row in a])

    across, right = distances(some, others), []
    for own, other in ((distances(some, some), across), (distances(others, others), across.T)):
        np.fill_diagonal(own, np.inf)
        near, far = own.min(axis=1), other.min(axis=1)
        right.append((near < far) + 0.5 * (near == far))
    return float(np.concatenate(right).mean())
