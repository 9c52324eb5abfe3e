"""The names that PettingZoo's envs have, under its own tests."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, render_test, seed_test
from pettingzoo.test.state_test import state_test

from hexwar_sb3.envs import hexwar_task_v0
from hexwar_sb3.envs.foreign import make_joint

SHORT = 300  # Delta-t: a game is six decisions long


# PettingZoo recommends Boxes, but for masked games of its own, which it knows by name; and "player_0" as a name of agents.
@pytest.mark.filterwarnings("ignore:Observation", "ignore:We recommend agents to be named")
@pytest.mark.parametrize("camps", ["red", "both"])
def test_pettingzoo_finds_nothing_wrong_with_the_aec_view(camps: str) -> None:
    api_test(hexwar_task_v0.env(camps=camps, decision_ticks=SHORT), num_cycles=60)


def test_pettingzoo_finds_nothing_wrong_with_the_parallel_view() -> None:
    parallel_api_test(hexwar_task_v0.parallel_env(decision_ticks=SHORT), num_cycles=8)


def test_a_seed_is_a_game() -> None:
    seed_test(lambda: hexwar_task_v0.env(decision_ticks=SHORT), num_cycles=5)
    parallel_seed_test(lambda: hexwar_task_v0.parallel_env(decision_ticks=SHORT), num_cycles=5)


def test_the_state_lies_in_its_space() -> None:
    env, parallel = (
        make(camps="red", decision_ticks=SHORT) for make in (hexwar_task_v0.env, hexwar_task_v0.parallel_env)
    )
    state_test(env, parallel)
    assert parallel.state_space.shape == parallel.state().shape
    assert parallel.state_space.dtype == parallel.state().dtype


def test_every_mode_renders(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pygame", reason="the extra human is not installed")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    monkeypatch.setattr("hexwar_sb3.envs.screen.FPS", 1000)
    render_test(lambda render_mode: hexwar_task_v0.env(decision_ticks=SHORT, render_mode=render_mode))


def test_a_picture_is_what_the_first_camp_knows() -> None:
    frames: dict[str, Any] = {}
    for camps in ("red", "both", "blue"):
        env = hexwar_task_v0.parallel_env(camps=camps, render_mode="rgb_array")
        env.reset(seed=0)
        frames[camps] = env.render()
    assert np.array_equal(frames["red"], frames["both"])
    assert not np.array_equal(frames["red"], frames["blue"])
    silent = hexwar_task_v0.parallel_env()
    silent.reset(seed=0)
    assert silent.render() is None


def test_the_module_is_a_game_by_name_for_qmix() -> None:
    """`hexwar learn hexwar_sb3.envs.hexwar_task_v0` and `make_joint` find it like an env of PettingZoo's."""
    joint = make_joint("hexwar_sb3.envs.hexwar_task_v0", {"camps": "red"}, privileged_state=False)
    obs, _ = joint.reset(seed=0)
    assert obs["action_mask"].shape == (7, 40)
