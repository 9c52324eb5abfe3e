"""TorchRL takes the envs as they are: its own checks, action masks, vector envs and the PettingZoo view."""

from __future__ import annotations

import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from hexwar_sb3.envs import hexwar_task_v0
from hexwar_sb3.envs.registration import ENVS, FLAT_ENV, ROUTE_ENV, TASK_ENV

SHORT: dict[str, Any] = {"decision_ticks": 300}
pytestmark = pytest.mark.filterwarnings("ignore")  # of TorchRL's own, which others' versions bring


@pytest.fixture(scope="module")
def torchrl() -> Any:
    """Where it is installed; its import warns."""
    pytest.importorskip("torchrl", reason="torchrl is not installed")
    return import_module("torchrl.envs")


def check_masks(steps: Any, action: Any = "action", mask: Any = "action_mask") -> None:
    assert steps[mask].gather(-1, steps[action].long().unsqueeze(-1)).all()


@pytest.mark.parametrize("env_id", ENVS)
@pytest.mark.parametrize("categorical", [True, False])
def test_torchrl_finds_nothing_wrong(torchrl: Any, env_id: str, categorical: bool) -> None:
    torchrl.check_env_specs(torchrl.GymEnv(env_id, categorical_action_encoding=categorical))


@pytest.mark.parametrize("env_id", [TASK_ENV, ROUTE_ENV])
def test_masks_reach_the_action_spec(torchrl: Any, env_id: str) -> None:
    """`ActionMask` reads `action_mask` of the observation: no random action breaks the rules."""
    env = torchrl.TransformedEnv(
        torchrl.GymEnv(env_id, categorical_action_encoding=True), torchrl.ActionMask()
    )
    env.set_seed(0)
    check_masks(env.rollout(40, break_when_any_done=False))


def test_the_flat_env_gets_its_mask_by_a_wrapper_of_gymnasiums(torchrl: Any) -> None:
    env = with_mask(gymnasium.make(FLAT_ENV, **SHORT))
    env = torchrl.TransformedEnv(
        torchrl.GymWrapper(env, categorical_action_encoding=True), torchrl.ActionMask()
    )
    env.set_seed(0)
    check_masks(env.rollout(60, break_when_any_done=False))


def with_mask(env: Any) -> Any:
    """As docs/recipes.md has it."""
    spaces = gymnasium.spaces
    mask = spaces.Box(0, 1, (int(env.action_space.n),), np.int8)
    return gymnasium.wrappers.TransformObservation(
        env,
        lambda seen: {"observation": seen, "action_mask": env.unwrapped.action_masks().astype(np.int8)},
        spaces.Dict({"observation": env.observation_space, "action_mask": mask}),
    )


def test_the_batched_engine_is_one_env_with_many_games(torchrl: Any) -> None:
    """What is stored as the next observation of a game that ended is its last one, not the next game's first."""
    venv = gymnasium.make_vec(TASK_ENV, num_envs=3, vectorization_mode="vector_entry_point", **SHORT)
    env = torchrl.GymWrapper(venv, categorical_action_encoding=True)
    env.set_seed(0)
    steps = env.rollout(8, break_when_any_done=False)
    assert tuple(steps.shape) == (3, 8)
    assert steps["next", "done"].sum() == 3
    ended = steps["next", "done"].squeeze(-1)
    at = ended.nonzero()[0]
    last, first = steps["next", "obs"][tuple(at)], steps["obs"][at[0], at[1] + 1]
    assert not np.allclose(last.numpy(), first.numpy())


def test_the_pettingzoo_view_has_groups_masks_and_state(torchrl: Any) -> None:
    env = hexwar_task_v0.parallel_env(camps="both", **SHORT)
    groups = {camp: [one for one in env.possible_agents if one.startswith(camp)] for camp in ("red", "blue")}
    options = {"use_mask": True, "categorical_actions": True, "return_state": True, "group_map": groups}
    wrapped = torchrl.PettingZooWrapper(env, **options)
    torchrl.check_env_specs(wrapped)
    steps = wrapped.rollout(8)
    for camp in groups:
        check_masks(steps, (camp, "action"), (camp, "action_mask"))
    assert steps["state"].shape[-1] == env.state_space.shape[0]


@pytest.mark.slow
def test_benchmarl_trains_on_the_pettingzoo_view(tmp_path: Path) -> None:
    pytest.importorskip("benchmarl", reason="benchmarl is not installed")
    script = Path(__file__).parents[2] / "examples" / "benchmarl_qmix.py"
    command = [sys.executable, "-W", "ignore", str(script)]
    subprocess.run(command, check=True, capture_output=True, cwd=tmp_path, timeout=500)
