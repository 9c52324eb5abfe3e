"""Files that Stable-Baselines3 writes of a network alone: pickles, read for those only who trust them."""

from __future__ import annotations

from typing import Self

import torch
from stable_baselines3.common.policies import BaseModel

from hexwar_sb3.errors import ConfigError


class TrustedFiles(BaseModel):
    """A network of Stable-Baselines3 whose `load` unpickles nothing unasked. To share a policy, share its folder."""

    @classmethod
    def load(cls, path: str, device: torch.device | str = "auto", trust: bool = False) -> Self:
        """Read what `save` wrote.

        Args:
            path: of the file.
            device: for the network.
            trust: unpickle it; that can run code.

        Raises:
            ConfigError: it is not trusted.
        """
        if not trust:
            raise ConfigError(
                f"{path}: a network's own file is unpickled, which can run code: share model.policy.freeze().save(folder),"
                " or pass trust=True"
            )
        return super().load(path, device)
