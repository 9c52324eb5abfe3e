"""Mixers as files beside a policy: who learns on from it needs them, who plays does not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch

from hexwar_sb3.errors import PolicyFileError
from hexwar_sb3.play.policy_files import CONFIG_FILE, PolicyFormat
from hexwar_sb3.policies.mixers import Mixer

FOLDER = "mixer"  # within the folder of a policy
FORMAT = PolicyFormat(
    "hexwar mixer",
    1,
    {
        "hyper_w1.0.weight": ("hidden", "state"),
        "hyper_w1.0.bias": ("hidden",),
        "hyper_w1.2.weight": ("pieces_embed", "hidden"),
        "hyper_w1.2.bias": ("pieces_embed",),
        "hyper_b1.weight": ("embed", "state"),
        "hyper_b1.bias": ("embed",),
        "hyper_w2.0.weight": ("hidden", "state"),
        "hyper_w2.0.bias": ("hidden",),
        "hyper_w2.2.weight": ("embed", "hidden"),
        "hyper_w2.2.bias": ("embed",),
        "hyper_b2.0.weight": ("embed", "state"),
        "hyper_b2.0.bias": ("embed",),
        "hyper_b2.2.weight": ("one", "embed"),
        "hyper_b2.2.bias": ("one",),
    },
)


def save_mixer(mixer: Mixer, policy: Path) -> None:
    """Write the mixer into a policy's folder; nothing if it has no weights."""
    weights = {name: tensor.detach().cpu().numpy() for name, tensor in mixer.state_dict().items()}
    if weights:
        FORMAT.save(policy / FOLDER, weights, {}, {})


def load_mixer(mixer: Mixer, policy: Path) -> bool:
    """Take over the mixer from a policy's folder; False if there is none.

    Raises:
        PolicyFileError: it is broken, or of other sizes.
    """
    folder, own = policy / FOLDER, mixer.state_dict()
    if not own or not (folder / CONFIG_FILE).is_file():
        return not own
    _, weights = FORMAT.load(folder)
    for name, array in weights.items():
        if name not in own or own[name].shape != array.shape:
            found, expected = (
                str(array.shape),
                str(tuple(own[name].shape) if name in own else "no such weight"),
            )
            raise PolicyFileError(folder / CONFIG_FILE, name, found=found, expected=expected)
    mixer.load_state_dict({name: torch.from_numpy(np.array(array)) for name, array in weights.items()})
    return True
