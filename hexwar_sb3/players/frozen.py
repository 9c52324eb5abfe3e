"""A policy of the task level without torch: numpy in, numpy out, and a folder that is safe to share."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.errors import ConfigError, PolicyFileError
from hexwar_sb3.players.frozen_lower import FOLDER as LOWER_FOLDER
from hexwar_sb3.players.frozen_lower import HEURISTIC_LOWER, FrozenLower, Lower, make_lower
from hexwar_sb3.players.policy_files import CONFIG_FILE, WEIGHTS_FILE, PolicyFormat, Weights, remove_policy
from hexwar_sb3.players.task_network import Net, best_tasks

HAS_LOWER = "lower"  # in the config: whether `lower/` is a part of the policy
LAYERS: dict[str, tuple[str, ...]] = {  # Fig. 4(b)
    "piece.weight": ("hidden", "obs"),
    "piece.bias": ("hidden",),
    "embed_piece.weight": ("embed", "hidden"),
    "embed_task.weight": ("embed", "task"),
    "embed_task.bias": ("embed",),
    "embed.weight": ("embed", "embed"),
    "embed.bias": ("embed",),
    "context_piece.weight": ("hidden", "hidden"),
    "context_set.weight": ("hidden", "embed"),
    "context_set.bias": ("hidden",),
    "context_task.weight": ("hidden", "embed"),
    "value.weight": ("one", "hidden"),
    "value.bias": ("one",),
}
FORMAT = PolicyFormat("hexwar task policy", 1, LAYERS, numbers=("n_pieces", "n_tasks"))


class FrozenPolicy:
    """Greedy tasks from the network of Fig. 4(b), frozen.

    Args:
        weights: the agent network's arrays by name, [output, input].
        n_pieces: pieces of a camp.
        n_tasks: rows of a task set.
        about: what it was trained on: rules (hash), scenario, command, and so on.
        lower: who leads its pieces on their way: "heuristic", a `FrozenLower`, or a callable (not saved).

    Example:
        >>> policy = make_player("HRL0")  # or FrozenPolicy.load("runs/commander_1/policy")
        >>> policy.led_by("heuristic").save("mine")
        >>> FrozenPolicy.load("mine").sha256 == policy.sha256
        False
    """

    def __init__(
        self,
        weights: Weights,
        *,
        n_pieces: int,
        n_tasks: int,
        about: Mapping[str, str] | None = None,
        lower: Lower = HEURISTIC_LOWER,
    ) -> None:
        self.weights = FORMAT.as_weights(weights)
        self.n_pieces, self.n_tasks, self.about = n_pieces, n_tasks, dict(about or {})
        self.lower = make_lower(lower)
        self.sizes = FORMAT.sizes(self.weights)
        problem = FORMAT.why_unusable(self.weights, self.sizes)
        if problem:
            raise ConfigError(problem)
        self._net = _as_net(self.weights)

    def reset(self) -> None:
        """Nothing to forget: it acts on the present observation alone."""

    def act(self, obs: Mapping[str, NDArray[Any]], deterministic: bool = True) -> NDArray[np.int64]:
        """Pick the best valid task of every piece.

        Args:
            obs: a batch of the task env's observations, keys obs, tasks, action_mask [B, N, ...].
            deterministic: it always is.

        Returns:
            Task indices [B, N].
        """
        return self._run(obs)[0]

    def q_values(self, obs: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
        """Q of every task [B, N, K], in scaled points; invalid rows hold the lowest number there is."""
        return self._run(obs)[1]

    def predict(
        self,
        observation: Mapping[str, NDArray[Any]],
        state: tuple[NDArray[Any], ...] | None = None,
        episode_start: NDArray[Any] | None = None,
        deterministic: bool = True,
    ) -> tuple[NDArray[np.int64], tuple[NDArray[Any], ...] | None]:
        """As Stable-Baselines3's models, so that `evaluate_policy` takes it."""
        if observation["obs"].ndim == 3:
            return self.act(observation), state
        return self.act({key: np.asarray(value)[None] for key, value in observation.items()})[0], state

    def _run(self, obs: Mapping[str, NDArray[Any]]) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
        mask = np.asarray(obs["action_mask"])
        expected = (self.n_pieces, self.n_tasks, self.sizes["obs"], self.sizes["task"])
        found = (*mask.shape[1:], obs["obs"].shape[-1], obs["tasks"].shape[-1])
        if found != expected:
            raise ConfigError(
                f"this policy needs observations of (pieces, tasks, features, task features) {expected}, got {found}"
            )
        n = mask.shape[0] * self.n_pieces
        best, q = np.zeros(n, np.int64), np.zeros((n, self.n_tasks), np.float32)
        rows = np.require(obs["obs"], np.float32, ("C", "W")).reshape(
            n, -1
        )  # a kernel is for one type of array
        tasks = np.require(obs["tasks"], np.float32, ("C", "W")).reshape(n, self.n_tasks, -1)
        best_tasks(rows, tasks, np.require(mask, np.int8, ("C", "W")).reshape(n, -1), self._net, q, best)
        return best.reshape(mask.shape[:2]), q.reshape(mask.shape)

    @property
    def sha256(self) -> str:
        """Hash of the weights of both levels."""
        digest = hashlib.sha256()
        levels = [self.weights, *([self.lower.weights] if isinstance(self.lower, FrozenLower) else [])]
        for weights in levels:
            for name, array in weights.items():
                digest.update(name.encode() + array.tobytes())
        return digest.hexdigest()

    def led_by(self, lower: Lower) -> FrozenPolicy:
        """Give the same tasks with another lower level."""
        sizes = {"n_pieces": self.n_pieces, "n_tasks": self.n_tasks}
        return FrozenPolicy(self.weights, **sizes, about=self.about, lower=lower)

    def packed(self) -> tuple[bytes, bytes]:
        """Config and weights of its own level, as `save` writes them."""
        numbers = {"n_pieces": self.n_pieces, "n_tasks": self.n_tasks}
        return FORMAT.packed(
            self.weights, self.about, {**numbers, HAS_LOWER: isinstance(self.lower, FrozenLower)}
        )

    def save(self, folder: str | Path) -> None:
        """Write the folder `config.json` + `weights.safetensors`, and `lower/` if it has a network of its own."""
        folder = Path(folder)
        if isinstance(self.lower, FrozenLower):
            self.lower.save(folder / LOWER_FOLDER)
        else:
            remove_policy(folder / LOWER_FOLDER)
        FORMAT.save(folder, self.packed())

    @classmethod
    def load(cls, folder: str | Path, rules: str | None = None) -> FrozenPolicy:
        """Read a policy folder; nothing in it is run.

        Args:
            folder: with config.json and weights.safetensors.
            rules: hash of the rules it is to play by; None takes any, as does a policy that names none.

        Raises:
            PolicyFileError: a file is missing, too large or broken, its numbers do not fit together,
                or it was trained under other rules.
        """
        folder = Path(folder)
        config, weights = FORMAT.load(folder)
        check_rules(folder, config, rules)
        has_lower = _has_lower(folder, config)
        lower: Lower = FrozenLower.load(folder / LOWER_FOLDER) if has_lower else HEURISTIC_LOWER
        return cls.unpacked(config, weights, lower)

    @classmethod
    def unpacked(cls, config: Mapping[str, Any], weights: Weights, lower: Lower) -> FrozenPolicy:
        """Make it of what was read and checked."""
        numbers = {name: config[name] for name in FORMAT.numbers}
        return cls(weights, **numbers, about=config["about"], lower=lower)


def check_rules(place: Path, config: Mapping[str, Any], rules: str | None) -> None:
    """Check under which rules a policy was trained, if any are asked for.

    Raises:
        PolicyFileError: under others.
    """
    trained = config["about"].get("rules")
    if rules is not None and trained not in (None, rules):
        found, expected = f"{trained!r}", f"{rules!r}, the rules of this game"
        raise PolicyFileError(place / CONFIG_FILE, "about.rules", found=found, expected=expected)


def _has_lower(folder: Path, config: Mapping[str, Any]) -> bool:
    """Whether the policy has a lower level of its own: its config says so, or, in older folders, a part of one lies there.

    Raises:
        PolicyFileError: config and folder contradict each other.
    """
    place = folder / LOWER_FOLDER
    files = [place / CONFIG_FILE, place / WEIGHTS_FILE] if place.is_dir() else [place]
    lies_there, said = any(map(os.path.lexists, files)), config.get(HAS_LOWER)
    if said is None and HAS_LOWER not in config:
        return lies_there
    if not isinstance(said, bool):
        raise PolicyFileError(folder / CONFIG_FILE, HAS_LOWER, found=repr(said), expected="true or false")
    if lies_there and not said:
        raise PolicyFileError(place, "file", found="a lower level", expected=f"none, as {CONFIG_FILE} says")
    return said


def _as_net(weights: Weights) -> Net:
    """Arrange the weights for the kernels: names with `_`, matrices as [input, output]."""
    return Net(**{name.replace(".", "_"): np.array(weights[name].T, order="C") for name in LAYERS})
