"""A policy of the task level without torch: numpy in, numpy out, and a folder that is safe to share."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import safetensors.numpy
from numpy.typing import NDArray
from safetensors import SafetensorError

from hexwar_sb3.errors import ConfigError, PolicyFileError
from hexwar_sb3.files import replacing
from hexwar_sb3.play.network import Net, best_tasks

FORMAT, VERSION = "hexwar task policy", 1
CONFIG_FILE, WEIGHTS_FILE = "config.json", "weights.safetensors"
MAX_CONFIG_BYTES, MAX_WEIGHTS_BYTES = 1 << 16, 1 << 24
MAX_SIZE = 4096  # of any axis

# Weight -> its axes, [output, input] as in torch (Fig. 4b)
LAYERS: dict[str, tuple[str, ...]] = {
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

Weights = Mapping[str, NDArray[np.float32]]


class FrozenPolicy:
    """Greedy tasks from the network of Fig. 4(b), frozen.

    Args:
        weights: the agent network's arrays by name, [output, input].
        n_pieces: pieces of a camp.
        n_tasks: rows of a task set.
        about: what it was trained on: rules (hash), scenario, command, and so on.
    """

    def __init__(
        self, weights: Weights, *, n_pieces: int, n_tasks: int, about: Mapping[str, str] | None = None
    ) -> None:
        self.weights = {name: np.asarray(weights[name], dtype=np.float32) for name in LAYERS}
        self.n_pieces, self.n_tasks, self.about = n_pieces, n_tasks, dict(about or {})
        self.sizes = _sizes(self.weights)
        problem = _why_unusable(self.weights, self.sizes)
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
        rows = np.ascontiguousarray(obs["obs"], np.float32).reshape(n, -1)
        tasks = np.ascontiguousarray(obs["tasks"], np.float32).reshape(n, self.n_tasks, -1)
        best_tasks(rows, tasks, np.ascontiguousarray(mask, np.int8).reshape(n, -1), self._net, q, best)
        return best.reshape(mask.shape[:2]), q.reshape(mask.shape)

    def save(self, folder: str | Path) -> None:
        """Write the folder `config.json` + `weights.safetensors`, each file at once or not at all."""
        folder = Path(folder)
        data = safetensors.numpy.save(dict(self.weights))
        config = {
            "format": FORMAT,
            "version": VERSION,
            "n_pieces": self.n_pieces,
            "n_tasks": self.n_tasks,
            "sizes": self.sizes,
            "weights_sha256": hashlib.sha256(data).hexdigest(),
            "about": self.about,
        }
        for name, content in ((WEIGHTS_FILE, data), (CONFIG_FILE, json.dumps(config, indent=2).encode())):
            with replacing(folder / name) as temporary:
                temporary.write_bytes(content)

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
        path = Path(folder) / CONFIG_FILE
        config = _read_config(path)
        trained = config["about"].get("rules")
        if rules is not None and trained not in (None, rules):
            raise PolicyFileError(
                path, "about.rules", found=f"{trained!r}", expected=f"{rules!r}, the rules of this game"
            )
        weights = _read_weights(Path(folder) / WEIGHTS_FILE, config)
        return cls(weights, n_pieces=config["n_pieces"], n_tasks=config["n_tasks"], about=config["about"])


def _sizes(weights: Weights) -> dict[str, int]:
    """Length of each named axis, from the layers that define it."""
    return {
        "obs": weights["piece.weight"].shape[-1],
        "task": weights["embed_task.weight"].shape[-1],
        "hidden": weights["piece.weight"].shape[0],
        "embed": weights["embed_task.weight"].shape[0],
        "one": 1,
    }


def _why_unusable(weights: Weights, sizes: Mapping[str, int]) -> str | None:
    for name, axes in LAYERS.items():
        shape = tuple(sizes[axis] for axis in axes)
        if weights[name].shape != shape:
            return f"{name} has the shape {weights[name].shape}, expected {shape}"
        if not np.isfinite(weights[name]).all():
            return f"{name} holds numbers that are not finite"
    return None


def _as_net(weights: Weights) -> Net:
    """Arrange the weights for the kernels: names with `_`, matrices as [input, output]."""
    return Net(**{name.replace(".", "_"): np.ascontiguousarray(weights[name].T) for name in LAYERS})


def _read(path: Path, limit: int) -> bytes:
    try:
        size = path.stat().st_size
        if size > limit:
            raise PolicyFileError(path, "file size", found=f"{size} bytes", expected=f"at most {limit}")
        return path.read_bytes()
    except OSError as error:
        raise PolicyFileError(path, "file", found=str(error), expected="a readable file") from error


def _read_config(path: Path) -> dict[str, Any]:
    try:
        config = json.loads(_read(path, MAX_CONFIG_BYTES))
    except ValueError as error:
        if isinstance(error, PolicyFileError):
            raise
        raise PolicyFileError(path, "text", found=str(error), expected="JSON") from error
    if not isinstance(config, dict) or (config.get("format"), config.get("version")) != (FORMAT, VERSION):
        raise PolicyFileError(
            path, "format", found="something else", expected=f"{FORMAT!r}, version {VERSION}"
        )
    _check_config(path, config)
    return config


def _check_config(path: Path, config: dict[str, Any]) -> None:
    sizes = config.get("sizes")
    names = {axis for axes in LAYERS.values() for axis in axes}
    if not isinstance(sizes, dict) or set(sizes) != names:
        raise PolicyFileError(path, "sizes", found=repr(sizes), expected=f"the axes {sorted(names)}")
    for name, value in {
        **sizes,
        "n_pieces": config.get("n_pieces"),
        "n_tasks": config.get("n_tasks"),
    }.items():
        if type(value) is not int or not 1 <= value <= MAX_SIZE:
            raise PolicyFileError(
                path, name, found=repr(value), expected=f"a whole number from 1 to {MAX_SIZE}"
            )
    about = config.get("about")
    if not isinstance(about, dict) or not all(isinstance(value, str) for value in about.values()):
        raise PolicyFileError(path, "about", found=repr(about), expected="texts by name")


def _read_weights(path: Path, config: dict[str, Any]) -> dict[str, NDArray[np.float32]]:
    data = _read(path, MAX_WEIGHTS_BYTES)
    if hashlib.sha256(data).hexdigest() != config.get("weights_sha256"):
        raise PolicyFileError(
            path, "sha256", found="other weights", expected="those that config.json was written with"
        )
    try:
        weights = safetensors.numpy.load(data)
    except (SafetensorError, ValueError, KeyError) as error:
        raise PolicyFileError(path, "file", found=str(error), expected="safetensors") from error
    if set(weights) != set(LAYERS):
        raise PolicyFileError(path, "arrays", found=str(sorted(weights)), expected=str(sorted(LAYERS)))
    problem = _why_unusable(weights, config["sizes"])
    if problem:
        raise PolicyFileError(
            path, "arrays", found=problem, expected="the shapes of config.json, finite numbers"
        )
    return weights
