"""A policy as one file, to send and to keep: safetensors with the arrays of both levels, and their configs in its header.

It holds what the folder holds, byte for byte (docs/formats/policy.md, "One file"), and nothing in it is run.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import safetensors.numpy

from hexwar_sb3.errors import PolicyFileError
from hexwar_sb3.files import replacing
from hexwar_sb3.players.frozen import FORMAT, HAS_LOWER, FrozenPolicy, check_rules
from hexwar_sb3.players.frozen_lower import FOLDER as LOWER
from hexwar_sb3.players.frozen_lower import FORMAT as LOWER_FORMAT
from hexwar_sb3.players.frozen_lower import HEURISTIC_LOWER, FrozenLower, Lower
from hexwar_sb3.players.policy_files import (
    CONFIG_FILE,
    MAX_CONFIG_BYTES,
    MAX_WEIGHTS_BYTES,
    WEIGHTS_FILE,
    PolicyFormat,
    Weights,
    arrays_of,
    header_of,
)
from hexwar_sb3.reading import read_bytes

SUFFIX = ".safetensors"
UPPER = "policy"  # what its level is called in the file


def save_policy_file(policy: FrozenPolicy, path: str | Path) -> None:
    """Write a policy as one file, whole or not at all.

    A lower level that is a callable is left behind, as by `FrozenPolicy.save`: the heuristic leads.

    Args:
        policy: a frozen one.
        path: ends in .safetensors.

    Example:
        >>> policy = make_player("HRL0")  # or FrozenPolicy.load("runs/commander_1/policy")
        >>> save_policy_file(policy, "mine.safetensors")
        >>> load_policy_file("mine.safetensors").sha256 == policy.sha256
        True
    """
    levels = {UPPER: policy.packed()}
    if isinstance(policy.lower, FrozenLower):
        levels[LOWER] = policy.lower.packed()
    arrays = {
        f"{level}/{name}": array
        for level, (_, data) in levels.items()
        for name, array in safetensors.numpy.load(data).items()
    }
    configs = {level: config.decode() for level, (config, _) in levels.items()}
    with replacing(Path(path)) as temporary:
        temporary.write_bytes(safetensors.numpy.save(arrays, metadata=configs))


def load_policy_file(path: str | Path, rules: str | None = None) -> FrozenPolicy:
    """Read a policy that is one file; nothing in it is run.

    Args:
        path: of the file.
        rules: hash of the rules it is to play by; None takes any.

    Raises:
        PolicyFileError: it is missing, too large or broken, or was trained under other rules.
    """
    place = Path(path)
    data = read_bytes(place, 2 * MAX_WEIGHTS_BYTES, PolicyFileError)
    header, configs = header_of(place, data)
    if not isinstance(configs, dict) or UPPER not in configs:
        raise PolicyFileError(place, "metadata", found=_short(configs), expected=f"a config called {UPPER!r}")
    arrays = arrays_of(place, data)
    levels = {name.partition("/")[0] for name in header}
    if levels != set(configs) or not levels <= {UPPER, LOWER}:
        expected = f"arrays of {UPPER!r} or of {UPPER!r} and {LOWER!r}, each with its config"
        raise PolicyFileError(place, "levels", found=_short(sorted({*levels, *configs})), expected=expected)
    config, weights = _level(FORMAT, place, configs[UPPER], arrays, UPPER)
    check_rules(place, config, rules)
    if config.get(HAS_LOWER) is not (LOWER in configs):
        expected = "true if it holds a lower level, else false"
        raise PolicyFileError(
            place / CONFIG_FILE, HAS_LOWER, found=repr(config.get(HAS_LOWER)), expected=expected
        )
    lower: Lower = HEURISTIC_LOWER
    if LOWER in configs:
        lower = FrozenLower.unpacked(
            place / LOWER, *_level(LOWER_FORMAT, place / LOWER, configs[LOWER], arrays, LOWER)
        )
    return FrozenPolicy.unpacked(config, weights, lower)


def _level(
    kind: PolicyFormat, place: Path, text: Any, arrays: Weights, level: str
) -> tuple[dict[str, Any], Mapping[str, Any]]:
    """Config and arrays of one level, checked as if they lay in its folder."""
    if not isinstance(text, str) or len(text) > MAX_CONFIG_BYTES:
        raise PolicyFileError(place / CONFIG_FILE, "file", found=_short(text), expected="a config's text")
    config = kind.read_config(place / CONFIG_FILE, text.encode("utf-8", "surrogatepass"))
    own = {name.partition("/")[2]: array for name, array in arrays.items() if name.startswith(f"{level}/")}
    return config, kind.read_weights(place / WEIGHTS_FILE, safetensors.numpy.save(own), config)


def _short(value: object) -> str:
    return repr(value)[:80]
