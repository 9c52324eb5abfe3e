"""A pool of one's own past, for QMIX and for stock MaskablePPO."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sb3_contrib import MaskablePPO
from stable_baselines3.common.vec_env import VecEnv, VecMonitor, VecNormalize

from hexwar_sb3.algorithms.checkpoint import load_checkpoint, save_checkpoint
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.callbacks.self_play import SelfPlayCallback, frozen_copy
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation.matches import play_match
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.frozen_lower import fastest_way_network

SMALL: dict[str, Any] = {"learning_starts": 0, "buffer_size": 200, "batch_size": 8, "seed": 0}


def games(**settings: Any) -> VecEnv:
    return make_vec_env(n_envs=2, seed=3, **settings)


def qmix() -> QMIX:
    return QMIX("TaskPolicy", games(privileged_state=True), **SMALL)


def rivals(model: Any) -> list[object]:
    return list(model.get_env().get_attr("games")[0].rivals)


def test_opponents_are_copies_of_the_learner() -> None:
    model, pool = qmix(), SelfPlayCallback(48)
    first = model.policy.freeze().sha256
    model.learn(24 * 2 * 4, callback=pool)

    assert len(pool.pool) == 5  # at 0, 48, 96, 144 and 192, the end
    hashes = [copy.sha256 for copy in pool.pool if isinstance(copy, FrozenPolicy)]
    assert hashes[0] == first
    assert len(set(hashes)) == len(hashes)
    assert all(rival in pool.pool for rival in rivals(model))


def test_shares_are_those_that_were_asked_for() -> None:
    pool = SelfPlayCallback(10, pool_size=3, share=0.6, others=[("MA1", 3), "MA2"])
    pool.pool = [qmix().policy.freeze() for _ in range(5)]

    assert [weight for _, weight in pool.opponents()] == pytest.approx([0.3, 0.1, 0.2, 0.0, 0.0, 0.2, 0.2])


@pytest.mark.parametrize("size", [1, 2, 3, 4])
def test_a_pool_holds_as_many_copies_as_it_may(size: int) -> None:
    pool = SelfPlayCallback(10, pool_size=size)
    pool.pool = [qmix().policy.freeze() for _ in range(4)]
    weights = [weight for _, weight in pool.opponents()]

    assert sum(weight > 0 for weight in weights) == size
    assert sum(weights) == pytest.approx(1.0)


def test_a_copy_that_beats_the_learner_is_met_more_often() -> None:
    model, pool = (
        QMIX("TaskPolicy", games(privileged_state=True, priority=1.0), **SMALL),
        SelfPlayCallback(48),
    )
    model.learn(24 * 2 * 4, callback=pool)
    core = model.get_env().get_attr("games")[0]  # type: ignore[union-attr]
    core.encounters.rates[:] = [1.0, 0.0, 0.5, 1.0, 1.0]

    drawn = [core.mixture.draw(0, episode, core.encounters.urgency) for episode in range(400)]
    met = np.bincount(drawn, minlength=5) / 400
    assert met == pytest.approx(np.array([0.1, 1.0, 0.5, 0.1, 0.1]) / 1.8, abs=0.06)


def test_maskable_ppo_plays_against_its_past() -> None:
    env = VecMonitor(games(lower=fastest_way_network()))
    model = MaskablePPO("MultiInputPolicy", env, n_steps=24, batch_size=16, n_epochs=1, seed=0)
    pool = SelfPlayCallback(48)
    model.learn(96, callback=pool)

    assert len(pool.pool) == 3
    assert all(rival in pool.pool for rival in rivals(model))
    match = play_match(pool.pool[0], pool.pool[-1], games=2)
    assert match.games == 2


def test_a_model_of_normalised_observations_has_no_copy() -> None:
    """In play it would get them as they are."""
    env = VecNormalize(games(), norm_obs_keys=["obs"])
    model = MaskablePPO("MultiInputPolicy", env, n_steps=24, batch_size=16)

    with pytest.raises(ConfigError, match="leave VecNormalize's norm_obs out"):
        frozen_copy(model)


def test_a_copy_stays_while_the_model_learns() -> None:
    model = MaskablePPO(
        "MultiInputPolicy", games(), n_steps=24, batch_size=16, n_epochs=4, learning_rate=0.1, seed=0
    )
    copy = frozen_copy(model)
    before = [play_match(copy, "MA1", games=3).red.margins, play_match(model, "MA1", games=3).red.margins]
    model.learn(48)
    after = [play_match(copy, "MA1", games=3).red.margins, play_match(model, "MA1", games=3).red.margins]

    assert np.array_equal(before[0], after[0])
    assert not np.array_equal(before[1], after[1])


def test_a_pool_in_a_folder_is_gone_on_with(tmp_path: Path) -> None:
    model = qmix()
    model.learn(48, callback=SelfPlayCallback(48, folder=tmp_path))
    pool = SelfPlayCallback(48, folder=tmp_path)
    model.learn(48, callback=pool, reset_num_timesteps=False)

    assert sorted(int(path.name) for path in tmp_path.iterdir()) == [0, 48, 96]
    assert len(pool.pool) == 3


def test_a_training_goes_on_from_a_checkpoint_with_the_opponents_of_its_games(tmp_path: Path) -> None:
    model, place = qmix(), tmp_path / "pool"
    model.learn(72, callback=SelfPlayCallback(24, folder=place))  # in the midst of the second games
    save_checkpoint(model, tmp_path / "checkpoint.npz")
    model.learn(48, callback=SelfPlayCallback(24, folder=place), reset_num_timesteps=False)

    env, pool = games(privileged_state=True), SelfPlayCallback(24, folder=place)
    with pytest.raises(ConfigError, match=r"saved with 2 opponents or more, this env has 1: set them first"):
        load_checkpoint(tmp_path / "checkpoint.npz", env)
    pool.seat(env)
    again = load_checkpoint(tmp_path / "checkpoint.npz", env)
    again.learn(48, callback=pool, reset_num_timesteps=False)

    assert again.policy.freeze().sha256 == model.policy.freeze().sha256


def test_a_pool_is_of_one_training(tmp_path: Path) -> None:
    qmix().learn(2, callback=SelfPlayCallback(48, folder=tmp_path))
    with pytest.raises(ConfigError, match="holds the pool of another training"):
        qmix().learn(2, callback=SelfPlayCallback(48, folder=tmp_path))
    with pytest.raises(ConfigError, match="there is no pool in"):
        SelfPlayCallback(48, folder=tmp_path / "none").seat(games())


def test_a_wrong_share_is_named() -> None:
    with pytest.raises(ConfigError, match=r"share must be in 0\.\.1"):
        SelfPlayCallback(10, share=2.0, others=["MA1"])
    with pytest.raises(ConfigError, match="the weights of others need a positive sum"):
        SelfPlayCallback(10, others=[("MA1", 0.0)])
    with pytest.raises(ConfigError, match=r"an opponent is a player or \(player, weight\)"):
        SelfPlayCallback(10, others=[("MA1", "often")])
