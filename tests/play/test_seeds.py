"""Seeds of episodes."""

from __future__ import annotations

import pytest

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.play.seeds import check_seed, episode_draw, game_seed

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
