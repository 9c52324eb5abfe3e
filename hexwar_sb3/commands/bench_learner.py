"""How long an update of QMIX takes, as it is and in the literal form of Fig. 4(b)."""

from __future__ import annotations

from time import process_time

import torch
from torch import Tensor

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env

GAMES = 32  # side by side, as `hexwar train`
STEPS = 1_600  # env steps that fill the replay buffer
UPDATES = 10  # of a round


def learner_figures(scenario: str, rounds: int) -> dict[str, float]:
    """Measure an update of 128 transitions: milliseconds of process time, and MB kept for its gradient."""
    torch.set_num_threads(1)
    figures = {}
    for name, network in (("qmix_update", "additive"), ("qmix_update_literal", "literal")):
        model = _filled(scenario, network)
        figures[f"{name}_ms"] = update_ms(model, rounds)
        figures[f"{name}_kept_mb"] = kept_mb(model)
    return figures


def _filled(scenario: str, network: str) -> QMIX:
    """Make a learner whose replay is full enough, and that has made no update yet."""
    env = make_vec_env(
        "HexWarTask-v0", n_envs=GAMES, seed=0, scenario=scenario, side="both", privileged_state=True
    )
    model = QMIX(
        "TaskPolicy",
        env,
        learning_starts=STEPS,
        train_freq=(STEPS // GAMES, "step"),
        seed=0,
        policy_kwargs={"network": network},
    )
    return model.learn(STEPS)  # collects only


def update_ms(model: QMIX, rounds: int) -> float:
    """Best round of UPDATES updates, one of them, in ms."""
    times = []
    for _ in range(rounds):
        start = process_time()
        model.train(UPDATES, model.batch_size)
        times.append(1000 * (process_time() - start) / UPDATES)
        model.num_timesteps += STEPS  # the next updates are due
    return min(times)


def kept_mb(model: QMIX) -> float:
    """MB of tensors that an update keeps until its gradient is computed, each storage once."""
    kept: dict[int, Tensor] = {}  # keeps them alive, so that no address is used twice

    def keep(tensor: Tensor) -> Tensor:
        kept[tensor.untyped_storage().data_ptr()] = tensor
        return tensor

    with torch.autograd.graph.saved_tensors_hooks(keep, lambda tensor: tensor):
        next(model.updates(1, model.batch_size))
    return sum(tensor.untyped_storage().nbytes() for tensor in kept.values()) / 1e6
