"""Where networks are trained: the device that a command was asked for."""

from __future__ import annotations

from hexwar_sb3.errors import ConfigError


def check_device(name: str) -> None:
    """Check that torch knows a device, and has it.

    Raises:
        ConfigError: it does not.
    """
    import torch  # seconds, which only a training needs

    try:
        torch.zeros(1, device="cpu" if name == "auto" else name)
    except (RuntimeError, AssertionError) as error:
        reason = str(error).splitlines()[0]
        raise ConfigError(f"device {name!r} cannot be used: {reason}") from error
