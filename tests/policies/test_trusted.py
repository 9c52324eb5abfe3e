"""A network's own file, a pickle, is read for those only who trust it."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch
from stable_baselines3.common.policies import BaseModel

from hexwar_sb3.algorithms.masked_dqn import MaskedDQN, MaskedQRDQN
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import ROUTE_ENV, make_vec_env
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.policies import masked, task_policy
from hexwar_sb3.policies.trusted import TrustedFiles

CLASSES = [
    one
    for module in (masked, task_policy)
    for one in vars(module).values()
    if isinstance(one, type) and issubclass(one, BaseModel) and one.__module__ == module.__name__
]


class Payload:
    """Leaves a mark when it is unpickled."""

    ran = False

    def __reduce__(self) -> tuple[object, tuple[type[Payload], str, bool]]:
        return setattr, (Payload, "ran", True)


@pytest.mark.parametrize("cls", CLASSES)
def test_nothing_is_unpickled_unasked(cls: type[BaseModel], tmp_path: Path) -> None:
    torch.save(Payload(), tmp_path / "policy.pth")
    with pytest.raises(ConfigError, match=r"policy\.pth: .* unpickled, which can run code: .*trust=True"):
        cls.load(str(tmp_path / "policy.pth"))
    assert not Payload.ran


@pytest.mark.parametrize("algorithm", [QMIX, MaskedDQN, MaskedQRDQN])
def test_who_trusts_it_gets_the_network(
    algorithm: type[QMIX | MaskedDQN | MaskedQRDQN], tmp_path: Path
) -> None:
    env = make_vec_env() if algorithm is QMIX else make_vec_env(ROUTE_ENV)
    policy = algorithm("MultiInputPolicy", env, buffer_size=10, device="cpu").policy
    assert isinstance(policy, TrustedFiles)
    policy.save(str(tmp_path / "policy.pth"))
    again = type(policy).load(str(tmp_path / "policy.pth"), device="cpu", trust=True)
    torch.testing.assert_close(again.state_dict(), policy.state_dict(), rtol=0, atol=0)
