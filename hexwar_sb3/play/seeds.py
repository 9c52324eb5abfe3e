"""Seeds of episodes: the game of an episode depends on its number, never on its slot."""

from __future__ import annotations

import secrets

import numpy as np

from hexwar_sb3.checks import check_whole

SEEDS = 1_000_000  # that are drawn from where nobody gives one
MOST_SEED = 2**63 - 1  # a checkpoint's counters have 64 bits, one of them for the sign


def check_seed(seed: object) -> int:
    """Return the seed.

    Raises:
        ConfigError: it is no integer in 0..MOST_SEED.
    """
    return check_whole("seed", seed, least=0, most=MOST_SEED)


def chosen_seed(seed: object) -> int:
    """The seed, or one that is drawn where it is None.

    Raises:
        ConfigError: it is neither None nor an integer in 0..MOST_SEED.
    """
    return secrets.randbelow(SEEDS) if seed is None else check_seed(seed)


def game_seed(seed: int, episode: int) -> int:
    """Seed of one game's dice, 64 bits."""
    return int(np.random.SeedSequence([seed, episode]).generate_state(1, np.uint64)[0])


def episode_draw(seed: int, episode: int, stream: int) -> np.random.Generator:
    """Random numbers of an episode that are not dice; one stream a purpose."""
    return np.random.default_rng([seed, episode, stream])
