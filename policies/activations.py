"""Functions between layers by name, so that a file can hold which one it is."""

from __future__ import annotations

from torch import nn

from hexwar_sb3.errors import UnknownNameError

RELU = "relu"
ACTIVATIONS: dict[str, type[nn.Module]] = {
    RELU: nn.ReLU,
    "elu": nn.ELU,
    "gelu": nn.GELU,
    "leaky_relu": nn.LeakyReLU,
    "silu": nn.SiLU,
    "tanh": nn.Tanh,
}


def activation_of(activation: str | type[nn.Module]) -> type[nn.Module]:
    """A function by its name, or a class as it is.

    Raises:
        UnknownNameError: no such name.
    """
    if not isinstance(activation, str):
        return activation
    if activation not in ACTIVATIONS:
        raise UnknownNameError("activation_fn", activation, ACTIVATIONS)
    return ACTIVATIONS[activation]


def named_activation(activation: object) -> object:
    """The name of a function of torch's that has one here; anything else as it is."""
    return next((name for name, kind in ACTIVATIONS.items() if activation is kind), activation)
