"""Seeds of episodes: the game of an episode depends on its number, never on its slot."""

from __future__ import annotations

import json
import secrets
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.fields import check_names, refuse
from hexwar_sb3.errors import CheckpointError
from hexwar_sb3.reading import parse_json

_WORD, _STATE = 2**32, 2**128

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


def text_of(array: Any, place: str) -> str:
    """Take a text from a file.

    Raises:
        CheckpointError: it is none.
    """
    if not isinstance(array, np.ndarray) or array.dtype.kind != "U" or array.ndim:
        refuse(place, "something else", "a text")
    return str(array)


def rng_array(rng: np.random.Generator) -> NDArray[np.str_]:
    """State of a generator, for a file."""
    return np.array(json.dumps(rng.bit_generator.state))


def rng_state(array: Any, place: str) -> dict[str, Any]:
    """Take the state of a generator of numpy's default kind from a file.

    Raises:
        CheckpointError: it is none.
    """
    state = parse_json(text_of(array, place), "snapshot", "a random state", CheckpointError, place)
    return check_rng(state, place)


def check_rng(state: Any, place: str) -> dict[str, Any]:
    """Check the state of a generator of numpy's default kind: other numbers would be drawn for ever, or none.

    Raises:
        CheckpointError: it is none.
    """
    own = np.random.default_rng(0).bit_generator.state
    for found, expected in (
        (state, own),
        (state.get("state") if isinstance(state, dict) else None, own["state"]),
    ):
        if not isinstance(found, dict):
            refuse(place, type(found).__name__, "a random state")
        check_names(found, expected, place)
    if state["bit_generator"] != own["bit_generator"]:
        refuse(place, state["bit_generator"], own["bit_generator"])
    numbers = {"has_uint32": 2, "uinteger": _WORD}
    for number, end in [
        *((state[name], end) for name, end in numbers.items()),
        *((n, _STATE) for n in state["state"].values()),
    ]:
        if type(number) is not int or not 0 <= number < end:
            refuse(place, number, f"0..{end - 1}")
    if state["state"]["inc"] % 2 == 0:
        refuse(place, "an even step", "an odd one, as every generator of this kind has")
    return dict(state)
