"""Who can be seated, and how opponents are drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hexwar_sb3.errors import ConfigError, PolicyFileError, UnknownNameError
from hexwar_sb3.players.player import (
    ActingPlayer,
    BotPlayer,
    ModelPlayer,
    Observation,
    make_mixture,
    make_player,
)

N_PIECES, N_TASKS = 3, 4


class FirstTask:
    """Player: always task 0."""

    def reset(self) -> None: ...

    def act(self, obs: Observation) -> NDArray[np.int64]:
        return np.zeros(obs["action_mask"].shape[:2], np.int64)


class MaskedModel:
    """Model in the manner of MaskablePPO: keeps the masks that it was given."""

    masks: NDArray[Any] | None = None

    def predict(
        self, obs: Observation, deterministic: bool = False, action_masks: NDArray[Any] | None = None
    ) -> tuple[NDArray[np.int64], None]:
        self.masks = action_masks
        return np.full(obs["action_mask"].shape[:2], int(deterministic)), None


def test_a_bots_name_is_a_compiled_player() -> None:
    assert isinstance(make_player("MA1"), BotPlayer)


def test_a_wrong_name_says_which_one_was_meant() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'MA"):
        make_player("MA7")


def test_a_folder_without_a_policy_is_told_what_it_lacks(tmp_path: Path) -> None:
    with pytest.raises(
        PolicyFileError, match=r"config.json: found nothing; expected a policy folder, a run folder"
    ):
        make_player(tmp_path)


def test_a_run_folder_plays_its_policy(tmp_path: Path) -> None:
    """Its own config.json holds the settings of the training."""
    (tmp_path / "config.json").write_text("{}", encoding="utf-8")
    (tmp_path / "policy").mkdir()
    (tmp_path / "policy" / "config.json").write_text("{}", encoding="utf-8")
    with pytest.raises(PolicyFileError, match=r"policy/config.json: format"):
        make_player(tmp_path)


def test_an_object_that_only_acts_needs_no_reset() -> None:
    class Actor:
        def act(self, obs: Observation) -> NDArray[np.int64]:
            return np.zeros(obs["action_mask"].shape[:2], np.int64)

    player = make_player(Actor())
    assert isinstance(player, ActingPlayer)
    player.reset()
    assert player.act({"action_mask": np.ones((2, N_PIECES, N_TASKS))}).shape == (2, N_PIECES)


def test_a_class_is_no_player() -> None:
    with pytest.raises(ConfigError, match=r"got the class FirstTask, perhaps for FirstTask\(\)"):
        make_player(FirstTask)


def test_an_object_that_acts_is_a_player_as_it_is() -> None:
    player = FirstTask()
    assert make_player(player) is player


def test_a_model_plays_greedily_and_gets_flat_masks() -> None:
    model = MaskedModel()
    player = make_player(model)
    assert isinstance(player, ModelPlayer)

    actions = player.act({"action_mask": np.ones((2, N_PIECES, N_TASKS), np.int8)})

    assert (actions == 1).all()
    assert model.masks is not None
    assert model.masks.shape == (2, N_PIECES * N_TASKS)


def test_an_object_that_cannot_play_is_refused() -> None:
    with pytest.raises(ConfigError, match="act"):
        make_player(3)


def test_a_mixture_draws_by_weight_and_by_episode_alone() -> None:
    mixture = make_mixture([("MA1", 3), ("MA2", 1)])
    draws = [mixture.draw(seed=5, episode=k) for k in range(400)]

    assert draws == [mixture.draw(seed=5, episode=k) for k in range(400)]
    assert 0.17 < np.mean(draws) < 0.33


def test_opponents_without_weights_are_equally_likely() -> None:
    assert make_mixture(["MA1", "MA2"]).weights == (1.0, 1.0)


NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize(
    "opponent",
    [
        [],
        (),
        [("MA1", -1)],
        [("MA1", 0)],
        [("MA1", NAN)],
        [("MA1", INF)],
        [("MA1", 1), ("MA2", NAN)],
        [("MA1", 1e308), ("MA2", 1e308)],
    ],
)
def test_impossible_weights_are_refused(opponent: object) -> None:
    with pytest.raises(ConfigError, match="weights"):
        make_mixture(opponent)


@pytest.mark.parametrize(
    "opponent",
    [[["MA1", 3], ["MA2", 1]], (["MA1", 3.0], ("MA2", np.int64(1))), [("MA1", np.float32(3)), ["MA2", 1]]],
)
def test_weights_come_as_json_gives_them_too(opponent: object) -> None:
    mixture = make_mixture(opponent)
    assert (mixture.weights, mixture.names) == ((3.0, 1.0), ("MA1", "MA2"))
    assert mixture == make_mixture([("MA1", 3), ("MA2", 1)])


@pytest.mark.parametrize(
    "opponent",
    [[["MA1", "2"]], [("MA1", True)], [("MA1", None)], [["MA1"]], [["MA1", 1, 2]], [[]], [[["MA1", 1]]], ["MA1", 2],
     {"MA1": 2}, None, 3, (name for name in ["MA1"]), [FirstTask]],
)  # fmt: skip
def test_opponents_in_another_form_are_refused_in_words(opponent: object) -> None:
    with pytest.raises(ConfigError, match="player"):
        make_mixture(opponent)
