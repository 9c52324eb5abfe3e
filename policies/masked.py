"""Policies of DQN and QR-DQN that value only the valid actions of an action mask."""

from __future__ import annotations

from typing import Any

from gymnasium import spaces
from jaxtyping import Float
from sb3_contrib.qrdqn.policies import QRDQNPolicy, QuantileNetwork
from stable_baselines3.common.torch_layers import CombinedExtractor
from stable_baselines3.common.type_aliases import PyTorchObs
from stable_baselines3.dqn.policies import DQNPolicy, QNetwork
from torch import Tensor, nn

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.players.frozen_lower import FrozenLower
from hexwar_sb3.policies.activations import RELU, activation_of
from hexwar_sb3.policies.trusted import TrustedFiles

MASK = "action_mask"
MASKED_VALUE = -1e9  # of an invalid action; finite, so that no mean, difference or product of it is NaN


def check_masked_spaces(observation_space: spaces.Space[Any], action_space: spaces.Space[Any]) -> None:
    """Check that observations carry a mask of the actions, and something else to learn from.

    Raises:
        ConfigError: they do not.
    """
    if not isinstance(action_space, spaces.Discrete) or action_space.start != 0:
        raise ConfigError(f"actions must be Discrete and count from 0, got {action_space}")
    if not isinstance(observation_space, spaces.Dict) or MASK not in observation_space.spaces:
        raise ConfigError(f"the observation must be a Dict with the key {MASK!r}, got {observation_space}")
    found, expected = observation_space[MASK].shape, (int(action_space.n),)
    if found != expected:
        raise ConfigError(f"the shape of {MASK!r} must be {expected}, one number an action; got {found}")
    if len(observation_space.spaces) == 1:
        raise ConfigError(f"the observation holds nothing beside {MASK!r} to learn from")


def fill_masked(
    values: Float[Tensor, "*any action"], mask: Float[Tensor, "*any action"]
) -> Float[Tensor, "*any action"]:
    """Give invalid actions a large negative value without gradient; a mask of zeros alone masks nothing."""
    valid = mask > 0
    return values.masked_fill(~valid & valid.any(dim=-1, keepdim=True), MASKED_VALUE)


class MaskedExtractor(CombinedExtractor):
    """SB3's features of everything but the mask."""

    def __init__(self, observation_space: spaces.Dict, **options: Any) -> None:
        parts = [(key, space) for key, space in observation_space.items() if key != MASK]
        super().__init__(spaces.Dict(parts), **options)


class MaskedQNetwork(TrustedFiles, QNetwork):
    """Q of every action [B, A]."""

    def forward(self, obs: PyTorchObs) -> Tensor:
        """Value the valid actions."""
        return fill_masked(super().forward(obs), obs[MASK])  # type: ignore[index]  # a Dict's tensors


class MaskedQuantileNetwork(TrustedFiles, QuantileNetwork):
    """Quantiles of the return of every action [B, quantile, A]."""

    def forward(self, obs: PyTorchObs) -> Tensor:
        """Value the valid actions."""
        return fill_masked(super().forward(obs), obs[MASK].unsqueeze(1))  # type: ignore[index]  # a Dict's tensors


class MaskedDQNPolicy(TrustedFiles, DQNPolicy):
    """DQN's policy over valid actions; so the targets of SB3's own `train` are masked too.

    The observation space is a Dict with an "action_mask" of 0 and 1 [A] for Discrete(A); the mask is no feature.

    Args:
        args: as SB3's DQNPolicy: observation space, action space, learning rate as a function of SB3's progress.
        options: further arguments of it, as net_arch (default [64, 64]) and activation_fn (a class, or a name such as
            "tanh"); a features_extractor_class of your own must leave the mask out.
    """

    is_normalised = False  # what it sees was changed by a VecNormalize

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **_with_classes(options))

    def make_q_net(self) -> QNetwork:
        """Make a network with a features extractor of its own; the model moves it to its device."""
        options = self._update_features_extractor(self.net_args, features_extractor=None)
        return MaskedQNetwork(**options)


def _with_classes(options: dict[str, Any]) -> dict[str, Any]:
    """Arguments of SB3's policy: our extractor, and a class where a function between layers is named."""
    return {
        "features_extractor_class": MaskedExtractor,
        **options,
        "activation_fn": activation_of(options.get("activation_fn", RELU)),
    }


def freeze_lower(
    policy: MaskedDQNPolicy, *, ways: bool, tie: float = 0.0, network: QNetwork | None = None, **about: str
) -> FrozenLower:
    """Copy the network of a DQN that learned in the route env into one for the drive loop, without torch.

    Args:
        policy: with the default layers, 64 and 64.
        ways: the env's setting.
        tie: of `FrozenLower`.
        network: of the policy's two, the target or the online one; None takes the online one.
        about: what it was trained on.

    Raises:
        ConfigError: it has other layers, or other functions between them, a features extractor of its own, or learned
            from normalised observations.
    """
    if policy.is_normalised:
        raise ConfigError(
            "it learned from what VecNormalize made of the observations: in play it would see others"
        )
    if policy.activation_fn is not nn.ReLU:
        raise ConfigError(f"a lower level has ReLU between its layers, got {policy.activation_fn.__name__}")
    chosen = policy.q_net if network is None else network
    if type(chosen.features_extractor) is not MaskedExtractor:
        found = type(chosen.features_extractor).__name__
        raise ConfigError(f"a lower level reads the features as they are (MaskedExtractor), got {found}")
    layers = [layer for layer in chosen.q_net if isinstance(layer, nn.Linear)]
    if len(layers) != 3:
        raise ConfigError(f"a lower level has two hidden layers, got {len(layers) - 1}")
    weights = {
        f"layer{k}.{name}": tensor.detach().cpu().numpy().copy()
        for k, layer in enumerate(layers, 1)
        for name, tensor in layer.state_dict().items()
    }
    return FrozenLower(weights, ways=ways, tie=tie, about=about)


class MaskedQRDQNPolicy(TrustedFiles, QRDQNPolicy):
    """QR-DQN's policy over valid actions; arguments as those of `MaskedDQNPolicy`, and n_quantiles."""

    is_normalised = False  # as in MaskedDQNPolicy

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **_with_classes(options))

    def make_quantile_net(self) -> QuantileNetwork:
        """Make a network with a features extractor of its own; the model moves it to its device."""
        options = self._update_features_extractor(self.net_args, features_extractor=None)
        return MaskedQuantileNetwork(**options)
