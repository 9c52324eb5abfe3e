"""An update on two cores has the bits of one on one core."""

from __future__ import annotations

from typing import Any

import pytest

from hexwar_sb3.algorithms.beside import executor
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env


@pytest.mark.parametrize(
    "options", [{}, {"double_q": False}, {"td_lambda": 0.8}, {"policy_kwargs": {"hidden": 128}}]
)
def test_of_two_cores(options: dict[str, Any]) -> None:
    found = []
    for cores in (1, 2):
        env = make_vec_env("HexWarTask-v0", n_envs=8, seed=0, reward="net", privileged_state=True)
        model = QMIX("TaskPolicy", env, seed=0, learning_starts=100, **options)
        model.beside = executor(cores)
        model.learn(8 * 72)
        found.append([tensor.numpy().tobytes() for tensor in model.policy.state_dict().values()])

    assert found[0] == found[1]


def test_what_goes_wrong_there_goes_wrong_here() -> None:
    for cores in (1, 2):
        with pytest.raises(ZeroDivisionError):
            executor(cores).submit(lambda: 1 / 0).result()
