"""Whatever legal scenario is played, every observation lies in its space, to the last one of a game."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from gymnasium import spaces
from numpy.typing import NDArray

from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.flat_env import FlatEnv
from hexwar_sb3.envs.parallel import parallel_env
from hexwar_sb3.envs.registration import FLAT_ENV, TASK_ENV, make_vec_env
from hexwar_sb3.envs.route_env import RouteEnv
from hexwar_sb3.envs.task_env import TaskEnv
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.tasks.spots import SPOTS, max_spots

DECISIONS, HOPS = 6, 25  # of a game; of a route env
Rng = np.random.Generator


def valid(rng: Rng, mask: NDArray[Any]) -> NDArray[np.int64]:
    """Any valid action of each, [..., K] -> [...]."""
    assert mask.any(axis=-1).all(), "somebody has nothing to do"
    return np.asarray((rng.random(mask.shape) * mask).argmax(axis=-1))


def settings(scenario: Scenario, rng: Rng, **more: Any) -> dict[str, Any]:
    ticks = max(2, -(-scenario.game_ticks // DECISIONS))
    side = ("red", "blue")[rng.integers(2)]
    opponent = ("MA1", "MA2")[rng.integers(2)]
    spots = min(SPOTS, max_spots(load_world(scenario)))
    terms = {
        "scenario": scenario,
        "side": side,
        "opponent": opponent,
        "decision_ticks": ticks,
        "spots": spots,
    }
    return {**terms, **more}


def of_task(scenario: Scenario, rng: Rng) -> Iterator[tuple[spaces.Space[Any], Any]]:
    dtype = ("float32", "float16")[rng.integers(2)]
    env = TaskEnv(**settings(scenario, rng, dtype=dtype, privileged_state=True))
    obs, _ = env.reset(seed=0)
    yield env.observation_space, obs
    over = False
    while not over:
        obs, _, over, _, _ = env.step(valid(rng, obs["action_mask"]))
        yield env.observation_space, obs
    obs, reward, over, _, _ = env.step(valid(rng, obs["action_mask"]))
    assert (reward, over) == (0.0, True)
    yield env.observation_space, obs


def of_flat(scenario: Scenario, rng: Rng) -> Iterator[tuple[spaces.Space[Any], Any]]:
    env = FlatEnv(**settings(scenario, rng))
    obs, _ = env.reset(seed=0)
    yield env.observation_space, obs
    over = False
    while not over:
        obs, _, over, _, _ = env.step(np.int64(valid(rng, env.action_masks())))
        yield env.observation_space, obs


def of_route(scenario: Scenario, rng: Rng) -> Iterator[tuple[spaces.Space[Any], Any]]:
    env = RouteEnv(**settings(scenario, rng))
    stuck = None
    try:
        obs, _ = env.reset(seed=0)
    except ConfigError as error:
        stuck = error
    if stuck is not None:
        assert "no piece of the learner's camp has a way out of its cell" in str(stuck)
        return
    yield env.observation_space, obs
    for _ in range(HOPS):
        obs, _, ended, cut, _ = env.step(np.int64(valid(rng, obs["action_mask"])))
        yield env.observation_space, obs
        if ended or cut:
            obs, _ = env.reset()
            yield env.observation_space, obs


def of_parallel(scenario: Scenario, rng: Rng) -> Iterator[tuple[spaces.Space[Any], Any]]:
    terms = settings(scenario, rng)
    env = parallel_env(scenario, decision_ticks=terms["decision_ticks"], spots=terms["spots"])
    seen, _ = env.reset(seed=0)
    while env.agents:
        picked = {agent: int(valid(rng, seen[agent]["action_mask"])) for agent in env.agents}
        seen, *_ = env.step(picked)
        yield from ((env.observation_space(agent), obs) for agent, obs in seen.items())
        assert np.abs(env.state()).max() <= 16.0


def of_batch(scenario: Scenario, rng: Rng) -> Iterator[tuple[spaces.Space[Any], Any]]:
    """Native VecEnvs: also what is left of ended games."""
    for env_id in (TASK_ENV, FLAT_ENV):
        env: Any = make_vec_env(env_id, n_envs=2, seed=0, **settings(scenario, rng)).unwrapped
        obs = env.reset()
        for _ in range(2 * DECISIONS):
            masks = (
                env.action_masks().reshape(2, -1, *env.action_space.nvec[:1])
                if env_id == TASK_ENV
                else env.action_masks()
            )
            obs, _, _, infos = env.step(valid(rng, masks))
            for b in range(2):
                yield env.observation_space, _row(obs, b)
                if "terminal_observation" in infos[b]:
                    yield env.observation_space, infos[b]["terminal_observation"]


def _row(obs: Any, b: int) -> Any:
    return {key: value[b] for key, value in obs.items()} if isinstance(obs, dict) else obs[b]


@pytest.mark.parametrize("seed", range(15))
@pytest.mark.parametrize("play", [of_task, of_flat, of_route, of_parallel, of_batch])
def test_every_observation_lies_in_its_space(
    odd: Callable[[int], Scenario], play: Callable[..., Any], seed: int
) -> None:
    scenario = odd(seed)
    for space, obs in play(scenario, np.random.default_rng(seed)):
        assert space.contains(obs)
