"""Seeds of episodes: the game of an episode depends on its number, never on its slot."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.errors import ConfigError


def check_seed(seed: object) -> int:
    """Return the seed.

    Raises:
        ConfigError: it is no integer >= 0.
    """
    return check_whole("seed", seed, least=0)


def check_whole(setting: str, value: object, least: int) -> int:
    """Return a whole number.

    Raises:
        ConfigError: it is no integer, or below `least`.
    """
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise ConfigError(f"{setting} must be an integer >= {least}, got {value!r}")
    return int(value)


def game_seed(seed: int, episode: int) -> int:
    """Seed of one game's dice, 64 bits."""
    return int(np.random.SeedSequence([seed, episode]).generate_state(1, np.uint64)[0])


def episode_draw(seed: int, episode: int, stream: int) -> np.random.Generator:
    """Random numbers of an episode that are not dice; one stream a purpose."""
    return np.random.default_rng([seed, episode, stream])
