"""A member of a league: a policy's folder, and beside the policy the model that learns on."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hexwar_sb3.algorithms.model_zip import read_file, read_zip
from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.algorithms.tensors import checked_weights, pack, unpack
from hexwar_sb3.errors import CheckpointError
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.policies.task_policy import TaskPolicy
from hexwar_sb3.reading import read_bytes
from hexwar_sb3.rules.ruleset import default_rules

CAMPS = ("red", "blue")
BOTH = "both"
NETWORKS = "networks.safetensors"
BEST_MODEL = "best_model.zip"  # of a run
MEAN = "agent_mean."  # what a policy plays by, among the networks
MOST_BYTES = 1 << 26
HASH = "networks"  # in the policy's config: the file's sha256


@dataclass(frozen=True)
class Member:
    """A model of one camp or of both, in the league's folder."""

    camp: str  # that it plays here
    name: str
    folder: Path

    def policy(self) -> FrozenPolicy:
        """Read it.

        Raises:
            PolicyFileError: it is broken, or plays by other rules.
        """
        return FrozenPolicy.load(self.folder, rules=default_rules().hash)

    @property
    def networks(self) -> Path:
        """File of all that learns on, mixer and targets included; models that the league begins with have none."""
        return self.folder / NETWORKS


def as_member(model: QMIX, **about: str) -> FrozenPolicy:
    """What a model plays by."""
    return model.policy.freeze(rules=default_rules().hash, **about)


def leave(model: QMIX, folder: Path, **about: str) -> None:
    """Write a member's folder: the policy, which is a mean of the last updates, and what learns on."""
    data = pack(model.policy.state_dict())
    told = {**about, HASH: hashlib.sha256(data).hexdigest()}
    model.policy.freeze(rules=default_rules().hash, **told).save(folder)
    (folder / NETWORKS).write_bytes(data)


def leave_copy(policy: FrozenPolicy, origin: Path, folder: Path, like: TaskPolicy) -> None:
    """Write the folder of a model that a league begins with; of a run's best model, with what learns on beside the policy.

    Args:
        policy: it.
        origin: folder that it comes from. In a run's, `best_model.zip` lies beside it.
        folder: gets the copy.
        like: the league's models: networks of another width or mixer stay behind, then the mixer begins anew.

    Raises:
        CheckpointError: the run's model is broken.
    """
    path, data = origin.parent / BEST_MODEL, b""
    if path.is_file():
        tensors = read_zip(*read_file(path)).weights.get("policy", {})
        is_own = all(
            np.array_equal(tensors.get(MEAN + name, ()), own) for name, own in policy.weights.items()
        )
        shapes = {name: tuple(one.shape) for name, one in like.state_dict().items()}
        if is_own and shapes == {name: one.shape for name, one in tensors.items()}:
            data = pack(tensors)
            policy.about[HASH] = hashlib.sha256(data).hexdigest()
    policy.save(folder)
    if data:
        (folder / NETWORKS).write_bytes(data)


def read_networks(member: Member, policy: TaskPolicy) -> None:
    """Take over all networks that `leave` wrote.

    Raises:
        PolicyFileError: the policy beside them is broken.
        CheckpointError: they are, or they are of another model.
    """
    path = member.networks
    data = read_bytes(path, MOST_BYTES, CheckpointError, "networks as safetensors")
    if hashlib.sha256(data).hexdigest() != member.policy().about.get(HASH):
        raise CheckpointError(
            path, "sha256", found="other networks", expected="those that the policy's config names"
        )
    tensors = unpack(data, path, "networks")
    policy.load_state_dict(checked_weights(policy, tensors, path, "networks"))
