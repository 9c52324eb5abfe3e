"""Seeds of episodes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.play.seeds import MOST_SEED, check_seed, chosen_seed, episode_draw, game_seed

EPISODES = 200


def test_every_episode_has_its_own_game() -> None:
    seeds = {game_seed(seed, episode) for seed in range(3) for episode in range(EPISODES)}
    assert len(seeds) == 3 * EPISODES


def test_streams_of_an_episode_are_independent() -> None:
    assert episode_draw(0, 1, 1).random() != episode_draw(0, 1, 2).random()
    assert episode_draw(0, 1, 1).random() == episode_draw(0, 1, 1).random()


@pytest.mark.parametrize("seed", [-1, 0.5, "one", True])
def test_a_seed_is_a_whole_number(seed: object) -> None:
    with pytest.raises(ConfigError, match="seed"):
        check_seed(seed)


@pytest.mark.parametrize("seed", [2**63, 2**64, 10**30, float("nan"), None, [0], np.float64(1)])
def test_a_seed_that_no_checkpoint_can_hold_is_refused_at_once(seed: object) -> None:
    with pytest.raises(ConfigError, match="seed"):
        check_seed(seed)


@pytest.mark.parametrize("seed", [0, MOST_SEED, np.int64(5), np.uint8(3)])
def test_any_other_whole_number_is_a_seed(seed: Any) -> None:
    assert check_seed(seed) == chosen_seed(seed) == int(seed)
    assert np.array([check_seed(seed)], np.int64)[0] == seed


def test_where_nobody_gives_a_seed_one_is_drawn() -> None:
    assert len({chosen_seed(None) for _ in range(20)}) > 1
