"""Policies: how they are loaded, and what must then be right."""

from __future__ import annotations

import hashlib
import json
import os
import struct
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tests.attack import valid
from tests.attack.oracle import Attempt, check, check_said, finite, play, said
from tests.attack.tricks import Case, byte_tricks, copied_over, of_file, place_cases, swapped
from tests.attack.tricks_json import json_tricks
from tests.attack.tricks_weights import safetensors_tricks
from tests.attack.valid import ONE_FILE, POLICY, WEIGHTS


def policy_cases(folder: Path, part: str = "") -> Iterator[Case]:
    config, weights = f"{part}{POLICY}", f"{part}{WEIGHTS}"
    yield from of_file(config, byte_tricks, folder)
    yield from of_file(config, json_tricks, folder)
    yield from of_file(weights, byte_tricks, folder)
    for tricks in (byte_tricks, safetensors_tricks):
        for case in of_file(weights, tricks, folder):
            yield Case(case.family, f"{case.name}, hash mended", partial(_mended, case, config, weights))
    yield from place_cases(config)
    yield from place_cases(weights)
    others = folder.parent / "others" / "policy"
    yield copied_over("weights of another policy", others / WEIGHTS, weights)
    yield copied_over("config of another policy", others / POLICY, config)
    yield swapped("config and weights in each other's place", config, weights)


def _mended(case: Case, config: str, weights: str, folder: Path) -> None:
    """Let the config name the weights as they are now."""
    case.change(folder)
    values = json.loads((folder / config).read_bytes())
    values["weights_sha256"] = hashlib.sha256((folder / weights).read_bytes()).hexdigest()
    (folder / config).write_text(json.dumps(values), encoding="utf-8")


def levels_cases(folder: Path) -> Iterator[Case]:
    yield from policy_cases(folder)
    yield from policy_cases(folder, "lower/")
    for name in (POLICY, WEIGHTS):
        yield Case("place", f"lower/ without {name}", lambda at, name=name: (at / "lower" / name).unlink())  # type: ignore[misc]
        for here, there in (("", "lower/"), ("lower/", "")):
            source = folder / f"{here}{name}"
            yield copied_over(f"{there}{name} is the other level's", source, f"{there}{name}")
    yield Case("place", "lower is a file", _lower_is_file)
    yield Case("place", "lower is a link to the upper level", _lower_is_link)
    yield Case(
        "place",
        "lower/ in other letters",
        lambda at: (at / "lower" / POLICY).rename(at / "lower" / "Config.json"),
    )


def _lower_is_file(folder: Path) -> None:
    (folder / "lower").rename(folder / "lower.old")
    (folder / "lower").write_text("x", encoding="utf-8")


def _lower_is_link(folder: Path) -> None:
    (folder / "lower").rename(folder / "lower.old")
    (folder / "lower").symlink_to(".")


def one_file_cases(folder: Path) -> Iterator[Case]:
    for tricks in (byte_tricks, safetensors_tricks):
        yield from of_file(ONE_FILE, tricks, folder)
    yield from place_cases(ONE_FILE)
    yield copied_over("weights of a folder", folder.parent / "policy" / WEIGHTS, ONE_FILE)


def one_file_attempt(_: Path) -> Attempt:
    from hexwar_sb3.players.policy_file import load_policy_file

    obs = {key: value.copy() for key, value in valid.new_games(2).reset().items()}

    def attempt(folder: Path) -> None:
        policy = load_policy_file(folder / ONE_FILE)
        words = weights_said(folder / ONE_FILE)
        levels = {"policy": policy.weights, "lower": getattr(policy.lower, "weights", {})}
        found = {f"{level}/{name}": array for level, own in levels.items() for name, array in own.items()}
        check(set(found) == set(words), "other arrays than the file's")
        for name, array in found.items():
            check(finite(array) and bool((array == words[name]).all()), f"{name} is not as in the file")
        policy.q_values(obs)

    return attempt


def weights_said(path: Path) -> dict[str, Any]:
    """Arrays of a safetensors file, read to the letter."""
    data = path.read_bytes()
    (size,) = struct.unpack("<Q", data[:8])
    head, body = said(data[8 : 8 + size]), data[8 + size :]
    found = {}
    for name, one in head.items():
        if name != "__metadata__":
            check(one["dtype"] == "F32", f"{name} of the type {one['dtype']} was taken")
            start, end = one["data_offsets"]
            found[name] = np.frombuffer(body[start:end], "<f4").reshape(one["shape"])
    return found


def policy_attempt(_: Path) -> Attempt:
    from hexwar_sb3.players.frozen import FrozenPolicy
    from hexwar_sb3.players.frozen_lower import FrozenLower

    env = valid.new_games(2)
    obs = {key: value.copy() for key, value in env.reset().items()}

    def attempt(folder: Path) -> None:
        from hexwar_sb3.evaluation.matches import play_match
        from hexwar_sb3.players.terms import trained_terms

        policy = FrozenPolicy.load(folder)
        config = said((folder / POLICY).read_bytes())
        check(
            config["weights_sha256"] == hashlib.sha256((folder / WEIGHTS).read_bytes()).hexdigest(),
            "other weights",
        )
        _check_weights(policy.weights, folder / WEIGHTS)
        check_said({"n_pieces": config["n_pieces"], "n_tasks": config["n_tasks"]}, vars(policy))
        check_said(config["about"], policy.about)
        check_said(config["sizes"], policy.sizes)
        lower = folder / "lower"
        if os.path.lexists(lower):
            check(isinstance(policy.lower, FrozenLower), "there is a lower level, and the heuristic leads")
            _check_weights(policy.lower.weights, lower / WEIGHTS)  # type: ignore[union-attr]
            said((lower / POLICY).read_bytes())
        policy.q_values(obs)
        terms = trained_terms(folder)
        check(
            type(terms.decision_ticks) is int and type(terms.spots) is int,
            "terms are no numbers",
        )
        play_match(folder, "MA1", games=1, scenario=valid.SCENARIO)

    return attempt


def _check_weights(weights: Mapping[str, Any], path: Path) -> None:
    words = weights_said(path)
    check(set(words) == set(weights), "other arrays than the file's")
    for name, array in weights.items():
        check(array.dtype == np.float32 and finite(array), f"{name} is not finite, or no float32")
        check(
            array.shape == words[name].shape and bool((array == words[name]).all()),
            f"{name} is not as in the file",
        )


def lower_attempt(_: Path) -> Attempt:
    def attempt(folder: Path) -> None:
        from hexwar_sb3.players.frozen_lower import FrozenLower, make_lower

        lower = make_lower(folder)
        check(isinstance(lower, FrozenLower), "no lower level came")
        _check_weights(lower.weights, folder / WEIGHTS)  # type: ignore[union-attr]
        about = said((folder / POLICY).read_bytes())["about"]
        check_said(about, lower.about)  # type: ignore[union-attr]
        play(valid.new_games(1, lower=lower), steps=3)

    return attempt
