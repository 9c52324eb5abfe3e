"""A player that was made for other games is refused where it enters, with sizes and name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from gymnasium import spaces
from numpy.typing import NDArray

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.parallel import parallel_env
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.envs.route_env import RouteEnv
from hexwar_sb3.envs.task_env import TaskEnv
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.matches import play_match
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.play.match import play_games
from hexwar_sb3.play.recording import record_game
from hexwar_sb3.players.fit import why_unfit
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.player import POLICIES, make_player
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.tasks.features import sizes
from hexwar_sb3.tasks.records import MAX_TASKS
from hexwar_sb3.tasks.route import N_ANSWERS

OBS, ROW = sizes(7, 7, 2).obs, sizes(7, 7, 2).row
SHAPES = {"obs": (7, OBS), "tasks": (7, MAX_TASKS, ROW), "action_mask": (7, MAX_TASKS), "alive": (7,)}


def duel() -> Scenario:
    return Game.from_text("map plain-9x5\nred tank 0103\nblue tank 0403").world.scenario


def boxes(**shapes: tuple[int, ...]) -> spaces.Dict:
    parts: dict[str, spaces.Space[Any]] = {
        key: spaces.Box(-1.0, 1.0, shape) for key, shape in {**SHAPES, **shapes}.items()
    }
    return spaces.Dict(parts)


class Model:
    """Has a model's spaces, and stops."""

    def __init__(self, observation_space: Any, action_space: Any) -> None:
        self.observation_space, self.action_space = observation_space, action_space

    def predict(self, obs: Any, deterministic: bool = False) -> tuple[NDArray[np.int64], None]:
        if isinstance(obs, dict):
            return np.zeros(obs["alive"].shape, np.int64), None
        return np.zeros(len(obs), np.int64), None


def policy() -> FrozenPolicy:
    return FrozenPolicy.load(POLICIES["HRL0"])


TASKS = spaces.MultiDiscrete([MAX_TASKS] * 7)
FLAT = spaces.Box(-1.0, 1.0, (OBS + MAX_TASKS * ROW,))
FIT: dict[str, Callable[[], object]] = {
    "HRL0": lambda: "HRL0",
    "FrozenPolicy": policy,
    "Model": lambda: Model(boxes(), TASKS),
    "Model of the flat env": lambda: Model(FLAT, spaces.Discrete(MAX_TASKS * N_ANSWERS)),
}
UNFIT: dict[str, Callable[[], object]] = {
    "other actions": lambda: Model(boxes(), spaces.MultiDiscrete([MAX_TASKS] * 6)),
    "plain actions": lambda: Model(boxes(), spaces.Discrete(MAX_TASKS)),
    "stacked frames": lambda: Model(boxes(obs=(7, 4 * OBS)), TASKS),
    "another key": lambda: Model(boxes(weather=(3,)), TASKS),
    "the mixer's state": lambda: Model(boxes(state=(133,)), TASKS),
    "a picture": lambda: Model(spaces.Box(0.0, 1.0, (3, 84, 84)), TASKS),
    "another row": lambda: Model(spaces.Box(-1.0, 1.0, (4,)), spaces.Discrete(MAX_TASKS * N_ANSWERS)),
    "flat, other actions": lambda: Model(FLAT, spaces.Discrete(MAX_TASKS)),
}
ENTRANCES: dict[str, Callable[[Any, Scenario | str], object]] = {
    "red": lambda player, where: play_games(player, "MA1", 1, Terms(scenario=where)),
    "blue": lambda player, where: play_match("MA1", player, 1, scenario=where),
    "record": lambda player, where: record_game(player, "MA1", Terms(scenario=where)),
    "opponent": lambda player, where: TaskEnv(scenario=where, opponent=player),
    "mixture": lambda player, where: TaskEnv(scenario=where, opponent=[["MA1", 9], [player, 0.001]]),
    "set_opponent": lambda player, where: TaskEnv(scenario=where).set_opponent(["MA1", player]),
    "flat": lambda player, where: make_vec_env("HexWarFlat-v0", scenario=where, opponent=player),
    "route": lambda player, where: RouteEnv(scenario=where, opponent=player),
    "upper": lambda player, where: RouteEnv(scenario=where, upper=player),
    "parallel": lambda player, where: parallel_env(where, "red", opponent=player),
}


@pytest.mark.parametrize("entrance", ENTRANCES)
@pytest.mark.parametrize("player", FIT)
def test_a_player_of_another_line_up_is_refused_wherever_it_enters(player: str, entrance: str) -> None:
    with pytest.raises(ConfigError, match=r"cannot play (red|blue) of scenario .*expected .*, found "):
        ENTRANCES[entrance](FIT[player](), duel())


@pytest.mark.parametrize("player", UNFIT)
def test_a_player_that_fits_no_scenario_of_this_kind_is_refused(player: str) -> None:
    world = load_world("plain")
    assert why_unfit(make_player(UNFIT[player]()), world) is not None
    with pytest.raises(ConfigError, match="cannot play blue of scenario 'plain'"):
        TaskEnv(opponent=UNFIT[player]())


@pytest.mark.parametrize("player", FIT)
def test_a_player_that_fits_plays(player: str) -> None:
    made = FIT[player]()
    assert why_unfit(make_player(made), load_world("plain")) is None
    assert play_games(made, "random", 1, Terms(decision_ticks=600)).ticks.tolist() == [1800]


def test_our_own_models_play_without_the_mixers_state() -> None:
    model: Any = Model(boxes(state=(133,)), TASKS)
    model.policy = policy()  # as a TaskPolicy it has a lower level
    assert why_unfit(make_player(model), load_world("plain")) is None


def test_a_policy_is_called_by_the_name_that_was_given() -> None:
    with pytest.raises(ConfigError, match=r"player 'HRL0' cannot play red .*\(7, 40, 257, 36\)"):
        play_games("HRL0", "MA1", 1, Terms(scenario=duel()))


class Says:
    """Player: answers with what it was told, a row a game."""

    def __init__(self, answer: Callable[[int], object]) -> None:
        self.answer = answer

    def act(self, obs: Any) -> Any:
        return self.answer(len(obs["alive"]))


class Predicts(Says):
    """The same as a model; flat ones read one vector."""

    act = None  # type: ignore[assignment]

    def __init__(self, answer: Callable[[int], object], space: Any = None) -> None:
        super().__init__(answer)
        self.observation_space = space

    def predict(self, obs: Any, deterministic: bool = False) -> Any:
        return self.answer(len(obs["alive"] if isinstance(obs, dict) else obs))


ANSWERS: dict[str, Callable[[int], object]] = {
    "too few": lambda n: np.zeros((n, 6), np.int64),
    "one row": lambda _: np.zeros(7, np.int64),
    "numbers with a point": lambda n: np.full((n, 7), 2.9),
    "not a number": lambda n: np.full((n, 7), np.nan),
    "texts": lambda n: [["1"] * 7] * n,
    "flags": lambda n: np.ones((n, 7), np.bool_),
    "ragged": lambda _: [[1], [1, 2]],
    "nothing": lambda _: None,
    "too large": lambda n: np.full((n, 7), MAX_TASKS),
    "below 0": lambda n: np.full((n, 7), -1),
    "huge": lambda n: [[2**70] * 7] * n,
}


@pytest.mark.parametrize("answer", ANSWERS)
def test_what_a_player_picks_is_checked(answer: str) -> None:
    with pytest.raises(ConfigError, match=r"player 'Says': (actions must be whole numbers|tasks must be in)"):
        play_games("MA1", Says(ANSWERS[answer]), 1)
    with pytest.raises(ConfigError, match=r"player 'Predicts': (actions must be|tasks must be)"):
        play_games(Predicts(lambda n: (ANSWERS[answer](n), None)), "MA1", 1)


@pytest.mark.parametrize("answer", [np.zeros(3, np.int64), None, ((), (), ())])
def test_a_model_that_predicts_in_another_form_is_refused(answer: object) -> None:
    with pytest.raises(ConfigError, match=r"Predicts.predict must return \(actions, state\)"):
        play_games(Predicts(lambda _: answer), "MA1", 1)


@pytest.mark.parametrize("answer", [2.9, np.nan, "2", True, 10**6])
def test_what_a_flat_model_picks_is_checked(answer: object) -> None:
    with pytest.raises(ConfigError, match=r"Predicts.predict must give|player 'Predicts': tasks must be in"):
        play_games(Predicts(lambda n: (np.full(n, answer), None), FLAT), "MA1", 1)
