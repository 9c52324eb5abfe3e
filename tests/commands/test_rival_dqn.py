"""The flat DQN with the means of the hierarchy, small: what it values, explores and learns from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from stable_baselines3.common.callbacks import CallbackList

from hexwar_sb3.commands.rival_dqn import RivalDQN, RivalDqn
from hexwar_sb3.commands.run_folder import RunFolder
from hexwar_sb3.play.match import play_games
from hexwar_sb3.policies.masked import MASKED_VALUE

SMALL = RivalDqn(
    games=4, n_envs=2, buffer_size=1000, learning_games=1, eval_freq=2, eval_games=1, final_games=1
)


def played(steps: int, **settings: Any) -> RivalDQN:
    """A model after some turns of every game, and its own exploration alone."""
    made = RivalDqn(**{**vars(SMALL), "games": 100, **settings})
    return made.new_model().learn(2 * steps, callback=CallbackList(made.watchers()))


def stored(model: RivalDQN) -> NDArray[np.int64]:
    """Actions in the replay [turn, game]."""
    assert model.replay_buffer is not None
    return np.asarray(model.replay_buffer.actions[:, :, 0])


def test_only_tasks_that_there_are_are_valued() -> None:
    model = SMALL.new_model()
    env = model.get_env()
    assert env is not None
    obs = torch.as_tensor(np.asarray(env.reset()), dtype=torch.float32)
    with torch.no_grad():
        valued = model.q_net(obs) > MASKED_VALUE
    games = env.get_attr("games")[0]

    tasks = games.sight.obs["action_mask"][:, 0] != 0
    assert valued.reshape(2, -1, 7).all(dim=2).tolist() == tasks.tolist()
    assert not valued.all()


def test_a_random_action_is_kept_at_the_pieces_next_turn() -> None:
    """All explore, and all stick while they can: the same answer at two turns in a row."""
    kept = []
    for stickiness in (0.0, 0.999):
        model = played(
            24 * 7,
            stickiness=stickiness,
            demo_share=0.0,
            exploration_initial_eps=1.0,
            exploration_final_eps=1.0,
        )
        answers = stored(model)[: 7 * 23].reshape(-1, 7, 2) % 7
        kept.append(float((answers[1:] == answers[:-1]).mean()))

    assert kept[0] < 0.4
    assert kept[1] > kept[0] + 0.3


def test_what_a_bot_did_is_stored() -> None:
    turns = 24 * 7  # of a game, the first of which is the learner's
    model = played(turns + 20, demo_share=1.0)
    games, actions = model._games(), stored(model)[: turns + 20].T

    assert games.demos.all()
    shown = games.picked * 7 + games.answers
    for b, acting in enumerate(games.acting):
        assert actions[b, actions.shape[1] - acting :].tolist() == shown[b, :acting].tolist()
    assert games.acting.any()


def test_a_training_ends_with_a_model_that_plays(tmp_path: Path) -> None:
    model = SMALL.new_model()
    SMALL.learn(model, RunFolder(tmp_path))

    best = RivalDQN.load(tmp_path / "best_model.zip")
    assert play_games(best, "nearest", 2).margins.shape == (2, 2)


def test_another_bot_shows_if_one_is_named() -> None:
    with pytest.raises(Exception, match="unknown bot, replay or folder 'MA3'"):
        RivalDqn(**{**vars(SMALL), "demo": ("MA3",)}).new_model()
