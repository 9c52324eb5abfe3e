"""Level-based foraging (learning.md, section 4): the same QMIX on a game that is not ours.

`pip install lbforaging`, then `python -m hexwar_sb3.experiments.foraging --seed 0 --output results/foraging`.
"""

from __future__ import annotations

import argparse
import json
import sys
from importlib import import_module
from pathlib import Path
from time import process_time
from typing import Any, cast

import gymnasium
import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor

from hexwar_sb3.algorithms.neutral import NEUTRAL
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.joint_action import JointActionEnv
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.files import replacing

GAME = "Foraging-5x5-2p-1f-v3"
GREEDY_GAMES = 200  # in which the trained policy is measured, on seeds of their own
GREEDY_SEED = 1_000_000
SETTINGS: dict[str, Any] = {**NEUTRAL, "reward_scale": 1.0}
"""Arguments of `QMIX`; what is not named is its default."""


class OutOfTime(gymnasium.Wrapper[Any, Any, Any, Any]):
    """A foraging env of lbforaging says of any episode that it ended; one that is out of time is truncated."""

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Let all players act."""
        seen, rewards, over, _, info = self.env.step(action)
        cut = bool(over and cast("Any", self.env.unwrapped).field.any())
        return seen, rewards, bool(over and not cut), cut, info


def make_game(game: str = GAME) -> JointActionEnv:
    """Make a foraging game; the team's reward is the sum of its players'.

    Args:
        game: Gymnasium's id.

    Raises:
        ConfigError: lbforaging is not installed.
    """
    try:
        import_module("lbforaging")  # registers the ids
    except ImportError as error:
        raise ConfigError("this needs lbforaging: pip install lbforaging") from error
    env: Any = gymnasium.make(game, disable_env_checker=True).unwrapped
    return JointActionEnv(OutOfTime(env), team_reward="sum")


def make_games(game: str, n_envs: int, seed: int) -> VecMonitor:
    """Make some games side by side."""
    venv = DummyVecEnv([lambda: make_game(game)] * n_envs)
    venv.seed(seed)
    return VecMonitor(venv)


def train(game: str, steps: int, seed: int, n_envs: int = 8) -> dict[str, Any]:
    """Train QMIX and measure it: figures for JSON. `steps` counts env steps of all games."""
    torch.set_num_threads(1)
    env = make_games(game, n_envs, seed)
    exploring: dict[str, Any] = {"exploration_episodes": steps // 60}  # of up to 50 steps each
    model = QMIX("TaskPolicy", env, seed=seed, **SETTINGS, **exploring)
    start = process_time()
    model.learn(steps)
    seconds = process_time() - start
    returns = greedy_returns(model, game)
    return {
        "game": game,
        "seed": seed,
        "env_steps": steps,
        "greedy_return": float(returns.mean()),
        "greedy_games": GREEDY_GAMES,
        "env_steps_per_s": steps / seconds,
        "settings": {**SETTINGS, **exploring, "n_envs": n_envs},
    }


def greedy_returns(model: QMIX, game: str) -> NDArray[np.float64]:
    """Return of each of GREEDY_GAMES greedy episodes."""
    env = make_game(game)
    returns = np.zeros(GREEDY_GAMES)
    for k in range(GREEDY_GAMES):
        obs, _ = env.reset(seed=GREEDY_SEED + k)
        over = False
        while not over:
            action, _ = model.predict(obs, deterministic=True)
            obs, reward, ended, cut, _ = env.step(action)
            returns[k] += reward
            over = ended or cut
    return returns


def main() -> None:
    """Train on one game with one seed, print the figures and keep them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--game", default=GAME)
    parser.add_argument("--steps", type=int, default=300_000, help="env steps")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, default=None, help="folder for GAME-SEED.json")
    options = parser.parse_args()
    figures = train(options.game, options.steps, options.seed)
    text = json.dumps(figures, indent=2) + "\n"
    sys.stdout.write(text)
    if options.output is not None:
        with replacing(options.output / f"{options.game}-{options.seed}.json") as temporary:
            temporary.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
