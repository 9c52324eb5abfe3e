"""Seeds of episodes: the game of an episode depends on its number, never on its slot."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.checks import check_whole


def check_seed(seed: object) -> int:
    """Return the seed.

    Raises:
        ConfigError: it is no integer >= 0.
    """
    return check_whole("seed", seed, least=0)


def game_seed(seed: int, episode: int) -> int:
    """Seed of one game's dice, 64 bits."""
    return int(np.random.SeedSequence([seed, episode]).generate_state(1, np.uint64)[0])


def episode_draw(seed: int, episode: int, stream: int) -> np.random.Generator:
    """Random numbers of an episode that are not dice; one stream a purpose."""
    return np.random.default_rng([seed, episode, stream])
