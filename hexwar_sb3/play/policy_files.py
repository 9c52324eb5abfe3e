"""Policy folders: `config.json` + `weights.safetensors`. Nothing in them is run; everything is checked."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import safetensors.numpy
from numpy.typing import NDArray
from safetensors import SafetensorError

from hexwar_sb3.errors import PolicyFileError
from hexwar_sb3.files import replacing

CONFIG_FILE, WEIGHTS_FILE = "config.json", "weights.safetensors"
MAX_CONFIG_BYTES, MAX_WEIGHTS_BYTES = 1 << 16, 1 << 24
MAX_SIZE = 4096  # of any axis

Weights = Mapping[str, NDArray[np.float32]]
Sizes = dict[str, int]


@dataclass(frozen=True)
class PolicyFormat:
    """What a kind of policy is made of."""

    name: str
    version: int
    layers: Mapping[str, tuple[str, ...]]  # weight -> its axes, [output, input] as in torch
    numbers: tuple[str, ...] = ()  # further whole numbers of config.json, from 1 to MAX_SIZE

    @property
    def axes(self) -> set[str]:
        """Names of all axes."""
        return {axis for axes in self.layers.values() for axis in axes}

    def sizes(self, weights: Weights) -> Sizes:
        """Length of each named axis, from the first weight that has it."""
        found: Sizes = {}
        for name, axes in self.layers.items():
            for axis, size in zip(axes, weights[name].shape, strict=False):
                found.setdefault(axis, size)
        return found

    def why_unusable(self, weights: Weights, sizes: Mapping[str, int]) -> str | None:
        """Say what is wrong with the weights, or None."""
        for name, axes in self.layers.items():
            shape = tuple(sizes.get(axis) for axis in axes)
            if weights[name].shape != shape:
                return f"{name} has the shape {weights[name].shape}, expected {shape}"
            if not np.isfinite(weights[name]).all():
                return f"{name} holds numbers that are not finite"
        return None

    def save(self, folder: Path, weights: Weights, about: Mapping[str, str], numbers: Sizes) -> None:
        """Write the two files, each at once or not at all."""
        data = safetensors.numpy.save(dict(weights))
        config = {
            "format": self.name,
            "version": self.version,
            **numbers,
            "sizes": self.sizes(weights),
            "weights_sha256": hashlib.sha256(data).hexdigest(),
            "about": dict(about),
        }
        for name, content in ((WEIGHTS_FILE, data), (CONFIG_FILE, json.dumps(config, indent=2).encode())):
            with replacing(folder / name) as temporary:
                temporary.write_bytes(content)

    def load(self, folder: Path) -> tuple[dict[str, Any], dict[str, NDArray[np.float32]]]:
        """Read config and weights.

        Raises:
            PolicyFileError: a file is missing, too large or broken, or its numbers do not fit together.
        """
        config = self._read_config(folder / CONFIG_FILE)
        return config, self._read_weights(folder / WEIGHTS_FILE, config)

    def _read_config(self, path: Path) -> dict[str, Any]:
        data = _read(path, MAX_CONFIG_BYTES)
        try:
            config = json.loads(data)
        except (ValueError, RecursionError) as error:
            raise PolicyFileError(path, "text", found=str(error), expected="JSON") from error
        named = (config.get("format"), config.get("version")) if isinstance(config, dict) else None
        if named != (self.name, self.version):
            expected = f"{self.name!r}, version {self.version}"
            raise PolicyFileError(path, "format", found="something else", expected=expected)
        self._check_config(path, config)
        return dict(config)

    def _check_config(self, path: Path, config: dict[str, Any]) -> None:
        sizes = config.get("sizes")
        if not isinstance(sizes, dict) or set(sizes) != self.axes:
            raise PolicyFileError(path, "sizes", found=repr(sizes), expected=f"the axes {sorted(self.axes)}")
        for name, value in {**sizes, **{name: config.get(name) for name in self.numbers}}.items():
            if type(value) is not int or not 1 <= value <= MAX_SIZE:
                expected = f"a whole number from 1 to {MAX_SIZE}"
                raise PolicyFileError(path, name, found=repr(value), expected=expected)
        about = config.get("about")
        if not isinstance(about, dict) or not all(isinstance(value, str) for value in about.values()):
            raise PolicyFileError(path, "about", found=repr(about), expected="texts by name")

    def _read_weights(self, path: Path, config: dict[str, Any]) -> dict[str, NDArray[np.float32]]:
        data = _read(path, MAX_WEIGHTS_BYTES)
        if hashlib.sha256(data).hexdigest() != config.get("weights_sha256"):
            expected = "those that config.json was written with"
            raise PolicyFileError(path, "sha256", found="other weights", expected=expected)
        try:
            weights: dict[str, NDArray[np.float32]] = safetensors.numpy.load(data)
        except (SafetensorError, ValueError, KeyError) as error:
            raise PolicyFileError(path, "file", found=str(error), expected="safetensors") from error
        if set(weights) != set(self.layers):
            raise PolicyFileError(
                path, "arrays", found=str(sorted(weights)), expected=str(sorted(self.layers))
            )
        problem = self.why_unusable(weights, config["sizes"])
        if problem:
            expected = "the shapes of config.json, finite numbers"
            raise PolicyFileError(path, "arrays", found=problem, expected=expected)
        return weights


def _read(path: Path, limit: int) -> bytes:
    try:
        size = path.stat().st_size
        if size > limit:
            raise PolicyFileError(path, "file size", found=f"{size} bytes", expected=f"at most {limit}")
        return path.read_bytes()
    except OSError as error:
        raise PolicyFileError(path, "file", found=str(error), expected="a readable file") from error


def remove_policy(folder: Path) -> None:
    """Remove the two files of a policy folder, and the folder if nothing else is in it; nothing if there is none."""
    for name in (CONFIG_FILE, WEIGHTS_FILE):
        (folder / name).unlink(missing_ok=True)
    if folder.is_dir() and not any(folder.iterdir()):
        folder.rmdir()
