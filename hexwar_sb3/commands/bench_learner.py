"""How long an update of QMIX takes, as it is and in the literal form of Fig. 4(b)."""

from __future__ import annotations

from time import process_time

import torch

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env

GAMES = 32  # side by side, as `hexwar train`
STEPS = 1_600  # env steps that fill the replay buffer
UPDATES = 10  # of a round


def learner_figures(scenario: str, rounds: int) -> dict[str, float]:
    """Measure milliseconds of process time an update of 128 transitions."""
    torch.set_num_threads(1)
    return {
        "qmix_update_ms": update_ms(scenario, "additive", rounds),
        "qmix_update_literal_ms": update_ms(scenario, "literal", rounds),
    }


def update_ms(scenario: str, network: str, rounds: int) -> float:
    """Best round of UPDATES updates, one of them, in ms."""
    env = make_vec_env("HexWarTask-v0", n_envs=GAMES, scenario=scenario, side="both", privileged_state=True)
    model = QMIX(
        "TaskPolicy",
        env,
        learning_starts=STEPS,
        train_freq=(STEPS // GAMES, "step"),
        seed=0,
        policy_kwargs={"network": network},
    )
    model.learn(STEPS)  # collects only
    times = []
    for _ in range(rounds):
        start = process_time()
        model.train(UPDATES, model.batch_size)
        times.append(1000 * (process_time() - start) / UPDATES)
        model.num_timesteps += STEPS  # the next updates are due
    return min(times)
