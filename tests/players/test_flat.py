"""A model of the flat env as a player."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from gymnasium import spaces
from numpy.typing import NDArray

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.registration import FLAT_ENV, make_vec_env
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.play.lower import KEPT
from hexwar_sb3.play.match import play_games
from hexwar_sb3.players.flat import FlatPlayer
from hexwar_sb3.players.player import make_player
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.tasks.records import MAX_TASKS
from hexwar_sb3.tasks.route import N_ANSWERS


class Flat:
    """Model: an action by what the row says, one in three of them a direction."""

    observation_space = spaces.Box(-1.0, 1.0, (257 + MAX_TASKS * 36,))  # on plain

    def predict(self, rows: NDArray[Any], deterministic: bool = False) -> tuple[NDArray[np.int64], None]:
        assert deterministic
        numbers = (1000 * np.abs(rows).sum(axis=1)).astype(np.int64)
        return (1 + numbers % 5) * N_ANSWERS + np.where(numbers % 3 == 0, numbers % N_ANSWERS, 1), None


class Teller:
    """Player: stops, and tells these answers."""

    def __init__(self, answers: NDArray[Any]) -> None:
        self.answers = answers

    def reset(self) -> None: ...

    def act(self, obs: Any) -> NDArray[np.int64]:
        return np.zeros(obs["alive"].shape, np.int64)


def test_a_model_that_reads_one_vector_is_a_flat_player() -> None:
    assert isinstance(make_player(Flat()), FlatPlayer)


def test_an_action_is_a_task_and_an_answer_and_dead_pieces_are_not_asked() -> None:
    class Counter(Flat):
        def predict(self, rows: NDArray[Any], deterministic: bool = False) -> tuple[NDArray[np.int64], None]:
            return N_ANSWERS * (1 + np.arange(len(rows))) + 2, None

    alive = np.array([[1.0, 0.0], [1.0, 1.0]])
    player = FlatPlayer(Counter())
    tasks = player.act({"alive": alive, "obs": np.zeros((2, 2, 3)), "tasks": np.zeros((2, 2, MAX_TASKS, 4))})
    assert tasks.tolist() == [[1, 0], [2, 3]]
    assert player.answers.tolist() == [[2, 0], [2, 2]]


def test_a_model_plays_a_match_as_it_plays_in_its_env() -> None:
    """The same dice, tasks and directions, on both sides."""
    model, games = Flat(), 2
    for side, red, blue in (("red", model, "nearest"), ("blue", "nearest", model)):
        match = play_games(red, blue, games, seed=5)
        env = make_vec_env(FLAT_ENV, games, seed=5, side=side, opponent="nearest")
        obs: Any = env.reset()
        margins: dict[int, float] = {}
        while len(margins) < games:
            actions, _ = model.predict(obs, deterministic=True)
            obs, _, dones, infos = env.step(actions)
            margins |= {int(b): infos[b]["margin"] for b in np.flatnonzero(dones) if b not in margins}
        assert [margins[b] for b in range(games)] == match.margins[:, int(side == "blue")].tolist()
        assert match.margins.any()


@pytest.mark.parametrize("answers", [np.zeros((1, 3), int), np.full((1, 7), N_ANSWERS), np.full((1, 7), -1)])
def test_answers_that_are_none_are_refused(answers: NDArray[Any]) -> None:
    with pytest.raises(ConfigError, match=r"must be whole numbers of shape|answers must be in 0\.\.6"):
        play_games(Teller(answers), "MA1", 1)


def test_kept_answers_outlast_a_restore() -> None:
    world = load_world("plain")
    arena, other = Arena(world, 1, Terms()), Arena(world, 1, Terms())
    for one in (arena, other):
        one.begin(0, 1, None, None)
    arena.keep_answers(np.array([0]), np.array([1]), np.full((1, 7), 3))
    other.restore(arena.snapshot())
    assert other.drives.lower[0].tolist() == [0, KEPT]
    assert other.drives.kept[0, world.side(1)].tolist() == [3] * 7
