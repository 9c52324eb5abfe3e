"""A snapshot may come from a stranger's file: true ones go on to the bit, broken ones are refused or play on in peace."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.bots.drawn_records import CHARACTER
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import CheckpointError, ConfigError
from hexwar_sb3.maps.files import load_scenario
from hexwar_sb3.maps.scenario import PieceStart, Scenario
from hexwar_sb3.rules.enums import PieceType

PROGRAM = Path(__file__).with_name("broken_snapshots.py")
KINDS = ("red", "blue", "both", "recorded", "route", "flat")
TASK, ROUTE, FLAT = "HexWarTask-v0", "HexWarRoute-v0", "HexWarFlat-v0"


def native(name: str, **options: Any) -> Any:
    return make_vec_env(name, **{"n_envs": 2, **options}).unwrapped


def next_step(env: Any, obs: Any, rng: np.random.Generator) -> tuple[Any, Any, Any]:
    mask = obs["action_mask"] if isinstance(obs, dict) else env.action_masks()
    obs, rewards, dones, _ = env.step((rng.random(mask.shape) * (mask != 0)).argmax(axis=-1))
    return obs, rewards, dones


def same(one: Any, other: Any) -> bool:
    if isinstance(one, dict):
        return all(np.array_equal(one[key], other[key]) for key in one)
    return bool(np.array_equal(one, other))


def check_every_step(env: Any, other: Any, steps: int) -> None:
    """After every step the other env takes the snapshot over, and both play the next one alike."""
    rng = np.random.default_rng(0)
    obs = env.reset()
    for _ in range(steps):
        restored = other.restore(env.snapshot())
        assert same(obs, restored)
        state = rng.bit_generator.state
        obs, rewards, dones = next_step(env, obs, rng)
        rng.bit_generator.state = state
        restored, others, other_dones = next_step(other, restored, rng)
        assert same(obs, restored)
        assert rewards.tolist() == others.tolist()
        assert dones.tolist() == other_dones.tolist()


def chariots_first(pieces: list[PieceStart]) -> list[PieceStart]:
    return sorted(pieces, key=lambda piece: piece.kind != PieceType.CHARIOT)


def odd(name: str = "plain") -> list[Scenario]:
    """No control points, one piece against many, a game of a few ticks, nobody's soldiers aboard."""
    plain = load_scenario(name)
    red, blue = ([piece for piece in plain.pieces if piece.camp == camp] for camp in range(2))
    ashore = [replace(piece, aboard=False, kind=piece.kind) for piece in plain.pieces if piece.home is None]
    return [
        replace(plain, name="pointless", points=()),
        replace(plain, name="carried", points=(), pieces=(*chariots_first(red), *chariots_first(blue))),
        replace(plain, name="one", pieces=(red[0], *blue)),
        replace(plain, name="short", game_ticks=130),
        replace(plain, name="ashore", pieces=tuple(ashore), net_score=not plain.net_score),
    ]


@pytest.mark.parametrize(
    ("name", "options", "steps"),
    [
        (TASK, {"side": "both", "opponent": ["MA1", "random"]}, 26),
        (ROUTE, {"opponent": ["MA1", "random"]}, 30),
        (FLAT, {"opponent": "MA2", "side": "blue"}, 30),
        (FLAT, {"opponent": "MA2", "demo": "MA1", "demo_share": 0.5, "side": "both"}, 60),
    ],
)
def test_every_true_snapshot_goes_on_to_the_bit(name: str, options: dict[str, Any], steps: int) -> None:
    check_every_step(native(name, **options), native(name, seed=9, **options), steps)


@pytest.mark.slow
@pytest.mark.parametrize("scenario", ["plain", "hills", "paddy"])
@pytest.mark.parametrize(
    ("name", "options", "steps"),
    [
        (
            TASK,
            {"side": "both", "opponent": ["MA1", "MA2", "random", "nearest", "defender", "two-hold"]},
            120,
        ),
        (TASK, {"side": "blue", "opponent": "HRL0", "decisions": "event", "decision_ticks": 20}, 200),
        (
            TASK,
            {"demo": "MA1", "demo_share": 0.5, "warm_start": 0.7, "fog": False, "dtype": "float16"},
            80,
        ),
        (ROUTE, {"opponent": ["MA1", "random", "HRL0"], "decisions": "event", "n_envs": 3}, 400),
        (FLAT, {"opponent": ["MA1", "random"], "side": "both"}, 400),
        (FLAT, {"opponent": ["MA1", "HRL0"], "side": "both", "demo": "MA2", "demo_share": 0.5}, 400),
    ],
)
def test_every_true_snapshot_of_many_games_goes_on_to_the_bit(
    name: str, options: dict[str, Any], steps: int, scenario: str
) -> None:
    settings = {**options, "scenario": scenario}
    check_every_step(native(name, **settings), native(name, seed=9, **settings), steps)


@pytest.mark.slow
@pytest.mark.parametrize("scenario", odd(), ids=lambda scenario: scenario.name)
@pytest.mark.parametrize(("name", "steps"), [(TASK, 60), (ROUTE, 100), (FLAT, 150)])
def test_true_snapshots_of_odd_scenarios_go_on_to_the_bit(name: str, steps: int, scenario: Scenario) -> None:
    for opponent in ("MA1", "random"):
        settings = {"scenario": scenario, "opponent": opponent, "side": "red"}
        check_every_step(native(name, **settings), native(name, seed=9, **settings), steps)


def try_broken(kind: str, part: int, of: int) -> dict[str, Any]:
    command = [sys.executable, str(PROGRAM), kind, str(part), str(of)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=580)
    assert done.returncode == 0, done.stderr[-2000:]
    return dict(json.loads(done.stdout))


@pytest.mark.parametrize("kind", ["red", "route"])
def test_a_broken_snapshot_is_refused_or_plays_on(kind: str) -> None:
    """In a process of its own, where a crash would be seen; a refused one changes nothing."""
    found = try_broken(kind, 0, 12)

    assert found["wrong"] == []
    assert found["refused"] > 0.9 * found["tried"] > 30


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_every_field_at_both_ends_of_its_type_is_refused_or_plays_on(kind: str) -> None:
    for part in range(2):
        found = try_broken(kind, part, 2)
        assert found["wrong"] == []
        assert found["refused"] > 0.9 * found["tried"] > 250


def test_an_array_and_field_that_are_wrong_are_named() -> None:
    env = native(TASK)
    env.reset()
    snapshot = env.snapshot()
    snapshot["pieces"]["cell"][1, 3] = 6000

    with pytest.raises(
        CheckpointError, match=r"snapshot: pieces\.cell: found 6000 at \[1, 3\]; expected 0\.\."
    ):
        env.restore(snapshot)


def test_of_several_scenarios_the_one_that_is_wrong_is_named() -> None:
    env = native(ROUTE, scenario=["plain", "hills"])
    env.reset()
    snapshot = env.snapshot()
    snapshot["1/games"]["tick"] = 32767

    with pytest.raises(
        CheckpointError, match=r"snapshot: 1/games\.tick: found 32767 at \[0\]; expected 0\.\.1800"
    ):
        env.restore(snapshot)


def test_games_that_have_not_begun_cannot_go_on() -> None:
    env = native(TASK)
    with pytest.raises(CheckpointError, match=r"episodes: found -1 at \[0\]; expected 0\.\."):
        env.restore(env.snapshot())


@pytest.mark.parametrize("name", [TASK, ROUTE, FLAT])
def test_the_largest_seed_comes_back_and_no_larger_one_begins(name: str) -> None:
    env, other = native(name, seed=2**63 - 1), native(name, seed=1)
    obs = env.reset()

    assert same(obs, other.restore(env.snapshot()))
    assert same(env.reset(), other.reset())
    with pytest.raises(ConfigError, match="seed must be at most"):
        native(name, seed=2**63)


def test_a_bot_that_began_a_game_ends_it_and_a_policy_is_not_replaced_by_a_bot() -> None:
    """The opponents of the env may have been changed meanwhile; those that play are known by their seats."""

    class Stop:
        def act(self, obs: Any) -> Any:
            return np.zeros(obs["action_mask"].shape[:2], np.int64)

    bots, policies = native(TASK, opponent="MA2"), native(TASK, opponent=Stop())
    for env in (bots, policies):
        env.reset()
    of_bots, of_policies = bots.snapshot(), policies.snapshot()

    policies.restore(of_bots)
    assert [seat.name for seat in policies.games.rivals] == ["MA2", "MA2"]
    with pytest.raises(ConfigError, match="saved with a policy as opponent 0, this env has MA2"):
        bots.restore(of_policies)


@pytest.mark.parametrize("opponent", ["drawn", "drawn-unseen", "drawn:7"])
def test_what_was_drawn_for_an_opponent_is_what_its_game_draws(opponent: str) -> None:
    env = native(TASK, opponent=opponent)
    obs = env.reset()
    rng = np.random.default_rng(0)
    for _ in range(3):
        obs, *_ = next_step(env, obs, rng)
    env.restore(env.snapshot())
    for path in [[name] for name in CHARACTER.names or () if name != "style"] + [["style", "hunt"]]:
        broken = env.snapshot()
        field = broken["brains"]["drawn"]
        for name in path:
            field = field[name]
        field[0, 1] += 1
        with pytest.raises(CheckpointError, match=r"brains\.drawn\..*expected what the game draws"):
            env.restore(broken)
    of_bots = native(TASK, opponent="MA2")
    of_bots.reset()
    broken = of_bots.snapshot()
    broken["brains"]["drawn"]["member"][0, 1] = 7
    with pytest.raises(CheckpointError, match=r"found 7 at .*; expected 0 but for a family's member"):
        of_bots.restore(broken)
