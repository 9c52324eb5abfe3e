"""Level-based foraging; a stand-in takes the place of lbforaging, which is no dependency."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any, cast

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.experiments.foraging import make_game, train

GAME = "StandIn-v0"


class StandIn(gymnasium.Env[Any, Any]):
    """Two players; both must load (5) for a food worth 0.5 to each; three steps at most."""

    def __init__(self) -> None:
        self.players = [object(), object()]
        self.action_space: Any = spaces.Tuple([spaces.Discrete(6)] * 2)
        self.observation_space: Any = spaces.Tuple([spaces.Box(-1.0, 1.0, (2,))] * 2)
        self.field = np.ones((1, 1))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        self.field, self.moment = np.ones((1, 1)), 0
        return (np.zeros(2, np.float32), np.ones(2, np.float32)), {}

    def step(self, action: Any) -> Any:
        self.moment += 1
        loaded = list(action) == [5, 5]
        if loaded:
            self.field[:] = 0
        seen = np.zeros(2, np.float32), np.ones(2, np.float32)
        return seen, [0.5 * loaded] * 2, loaded or self.moment == 3, False, {}


@pytest.fixture(autouse=True)
def stand_in(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "lbforaging", ModuleType("lbforaging"))
    if GAME not in gymnasium.registry:
        gymnasium.register(GAME, entry_point=cast("Any", StandIn))


def test_an_episode_out_of_time_is_cut_short_and_an_eaten_field_ends_it() -> None:
    env = make_game(GAME)
    env.reset(seed=0)
    ends = [env.step(np.array([0, 0]))[2:4] for _ in range(3)]
    assert ends == [(False, False), (False, False), (False, True)]

    env.reset()
    assert env.step(np.array([5, 5]))[1:4] == (1.0, True, False)  # the sum of both players' rewards


def test_a_training_gives_its_figures() -> None:
    figures = train(GAME, steps=400, seed=0, n_envs=2)

    assert figures["env_steps"] == 400
    assert 0.0 <= figures["greedy_return"] <= 1.0
    assert figures["settings"]["n_envs"] == 2


def test_without_lbforaging_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "lbforaging", None)

    with pytest.raises(ConfigError, match="pip install lbforaging"):
        make_game(GAME)
