"""Tiny cooperative games with known solutions, as PettingZoo parallel envs: they check a learner.

Sources: the two-step game is that of Rashid et al. 2018; penalty and climbing are those of Claus and
Boutilier 1998, repeated 25 times as in Papoudakis et al. 2021; the one-step game is that of Son et al. 2019.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

AGENTS = ("row", "column")
PENALTY = ((0, 0, 10), (0, 2, 0), (10, 0, 0))
CLIMBING = ((11, -30, 0), (-30, 7, 6), (0, 0, 5))
ONE_STEP = ((8, -12, -12), (-12, 0, 0), (-12, 0, 0))
TWO_STEP = (((7, 7), (7, 7)), ((0, 1), (1, 8)))  # what is played at 2A and at 2B
ROUNDS = 25  # of a repeated game

Payoffs = Sequence[Sequence[float]]
Features = NDArray[np.float32]
Infos = dict[str, dict[str, Any]]
Step = tuple[dict[str, Features], dict[str, float], dict[str, bool], dict[str, bool], Infos]


class MatrixGame(ParallelEnv[str, Features, int]):  # type: ignore[misc]  # PettingZoo ships no types
    """Two agents that see the same and get the same reward.

    Args:
        n_actions: actions of each.
        n_features: numbers in what they see.
    """

    metadata: ClassVar[dict[str, Any]] = {"name": "matrix_game", "render_modes": []}

    def __init__(self, n_actions: int, n_features: int) -> None:
        self.possible_agents = list(AGENTS)
        self.observation_spaces = {name: spaces.Box(0.0, 1.0, (n_features,)) for name in AGENTS}
        self.action_spaces = {name: spaces.Discrete(n_actions) for name in AGENTS}
        self.agents: list[str] = []

    def observation_space(self, agent: str) -> spaces.Box:
        """The state itself."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Discrete:
        """A row or a column of the table."""
        return self.action_spaces[agent]

    @abstractmethod
    def begin(self) -> None:
        """Go back to the first state."""

    @abstractmethod
    def play(self, row: int, column: int) -> tuple[float, bool]:
        """Reward of both actions, and whether the game is over."""

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Features], Infos]:
        """Start a game."""
        self.agents = list(AGENTS)
        self.begin()
        return {name: self.state() for name in AGENTS}, {name: {} for name in AGENTS}

    def step(self, actions: dict[str, int]) -> Step:
        """Play both actions."""
        reward, over = self.play(*(actions[name] for name in AGENTS))
        self.agents = [] if over else list(AGENTS)
        seen = {name: self.state() for name in AGENTS}
        ends, cuts = dict.fromkeys(AGENTS, over), dict.fromkeys(AGENTS, False)
        return seen, dict.fromkeys(AGENTS, reward), ends, cuts, {name: {} for name in AGENTS}


class TwoStepGame(MatrixGame):
    """The row agent's first action leads to 2A, where all is worth 7, or to 2B with its 8 in the corner."""

    def __init__(self) -> None:
        super().__init__(n_actions=2, n_features=3)
        self.place = 0  # 1, 2A, 2B

    def state(self) -> Features:
        """One-hot of the place."""
        return np.eye(3, dtype=np.float32)[self.place]

    def begin(self) -> None:
        """Go back to state 1."""
        self.place = 0

    def play(self, row: int, column: int) -> tuple[float, bool]:
        """Go to 2A or 2B for nothing, or be paid there."""
        if self.place == 0:
            self.place = 1 + row
            return 0.0, False
        return float(TWO_STEP[self.place - 1][row][column]), True


class RepeatedGame(MatrixGame):
    """One table, played 25 times, or as often as you say.

    Args:
        payoffs: reward of [row action, column action].
        rounds: times that it is played.
    """

    def __init__(self, payoffs: Payoffs, rounds: int = ROUNDS) -> None:
        super().__init__(n_actions=len(payoffs), n_features=1)
        self.payoffs, self.rounds, self.played = payoffs, rounds, 0

    def state(self) -> Features:
        """Share of the rounds that were played."""
        return np.array([self.played / self.rounds], np.float32)

    def begin(self) -> None:
        """Forget the rounds that were played."""
        self.played = 0

    def play(self, row: int, column: int) -> tuple[float, bool]:
        """Be paid; over after the last round."""
        self.played += 1
        return float(self.payoffs[row][column]), self.played == self.rounds


class OwnPayGame(MatrixGame):
    """Once; each is paid for its own action, by a table of its own: [agent][action]."""

    PAY = (1.0, 0.0), (0.0, 3.0)

    def __init__(self) -> None:
        super().__init__(n_actions=2, n_features=1)

    def state(self) -> Features:
        """Nothing to see."""
        return np.zeros(1, np.float32)

    def begin(self) -> None:
        """Nothing to forget."""

    def play(self, row: int, column: int) -> tuple[float, bool]:
        """Over; the pay is in `step`."""
        return 0.0, True

    def step(self, actions: dict[str, int]) -> Step:
        """Pay each for its action."""
        seen, _, ends, cuts, infos = super().step(actions)
        pay = {name: self.PAY[i][actions[name]] for i, name in enumerate(AGENTS)}
        return seen, pay, ends, cuts, infos


class CueGame(MatrixGame):
    """Both see one of two cues, then nothing for a step; both are paid for what the cue said, in the last step alone."""

    STEPS = 3

    def __init__(self) -> None:
        super().__init__(n_actions=2, n_features=3)
        self.random, self.cue, self.moment = np.random.default_rng(0), 0, 0

    def state(self) -> Features:
        """The cue at first, then that it has gone."""
        return np.eye(3, dtype=np.float32)[self.cue if self.moment == 0 else 2]

    def begin(self) -> None:
        """Draw a cue."""
        self.cue, self.moment = int(self.random.integers(2)), 0

    def play(self, row: int, column: int) -> tuple[float, bool]:
        """Be paid for the cue, in the end."""
        self.moment += 1
        over = self.moment == self.STEPS
        return float(over and row == column == self.cue), over
