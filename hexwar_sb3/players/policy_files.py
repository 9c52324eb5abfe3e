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

from hexwar_sb3.errors import ConfigError, PolicyFileError
from hexwar_sb3.files import replacing
from hexwar_sb3.reading import parse_json, read_bytes

CONFIG_FILE, WEIGHTS_FILE = "config.json", "weights.safetensors"
MAX_CONFIG_BYTES, MAX_HEADER_BYTES, MAX_WEIGHTS_BYTES = 1 << 16, 1 << 16, 1 << 24
CONFIG = "a policy's config"
DTYPE = "F32"  # of all arrays, as safetensors calls it
METADATA = "__metadata__"  # key of its header that names no array
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

    def as_weights(self, weights: Mapping[str, Any]) -> dict[str, NDArray[np.float32]]:
        """The arrays by name as they are saved: float32 of this machine, the last axis fastest.

        Raises:
            ConfigError: one is missing, or holds no real numbers.
        """
        found: dict[str, NDArray[np.float32]] = {}
        for name in self.layers:
            array = np.asarray(weights.get(name))
            if array.dtype.kind not in "fiu":
                raise ConfigError(f"{name} holds {array.dtype}, expected real numbers")
            with np.errstate(over="ignore"):  # what is too large is not finite, and refused
                found[name] = np.asarray(array, np.float32, order="C")
        return found

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

    def save(self, folder: Path, packed: tuple[bytes, bytes]) -> None:
        """Write config and weights as two files, each at once or not at all."""
        config, data = packed
        for name, content in ((WEIGHTS_FILE, data), (CONFIG_FILE, config)):
            with replacing(folder / name) as temporary:
                temporary.write_bytes(content)

    def packed(
        self, weights: Weights, about: Mapping[str, str], more: Mapping[str, int]
    ) -> tuple[bytes, bytes]:
        """Config and weights as they are written.

        Args:
            weights: the arrays.
            about: what it was trained on.
            more: further words of the config, its numbers among them.
        """
        data = safetensors.numpy.save(self.as_weights(weights))
        config = {
            "format": self.name,
            "version": self.version,
            **more,
            "sizes": self.sizes(weights),
            "weights_sha256": hashlib.sha256(data).hexdigest(),
            "about": dict(about),
        }
        return json.dumps(config, indent=2).encode(), data

    def load(self, folder: Path) -> tuple[dict[str, Any], dict[str, NDArray[np.float32]]]:
        """Read config and weights.

        Raises:
            PolicyFileError: a file is missing, too large or broken, or its numbers do not fit together.
        """
        config = self.read_config(
            folder / CONFIG_FILE, read_bytes(folder / CONFIG_FILE, MAX_CONFIG_BYTES, PolicyFileError, CONFIG)
        )
        data = read_bytes(folder / WEIGHTS_FILE, MAX_WEIGHTS_BYTES, PolicyFileError)
        return config, self.read_weights(folder / WEIGHTS_FILE, data, config)

    def read_config(self, path: Path, text: bytes) -> dict[str, Any]:
        """What a config says; `path` is named in errors.

        Raises:
            PolicyFileError: it is broken, or of another kind or version.
        """
        config = parse_json(text, path, CONFIG, PolicyFileError)
        if not isinstance(config, dict):
            raise PolicyFileError(path, "file", found=type(config).__name__, expected=CONFIG)
        if (config.get("format"), config.get("version")) != (self.name, self.version):
            expected = f"{self.name!r}, version {self.version}"
            raise PolicyFileError(path, "format", found="something else", expected=expected)
        self._check_config(path, config)
        return config

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

    def read_weights(self, path: Path, data: bytes, config: dict[str, Any]) -> dict[str, NDArray[np.float32]]:
        """The arrays of a safetensors file that belongs to a config; `path` is named in errors.

        Raises:
            PolicyFileError: they are broken, others than the config's, or do not fit together.
        """
        if hashlib.sha256(data).hexdigest() != config.get("weights_sha256"):
            expected = "those that config.json was written with"
            raise PolicyFileError(path, "sha256", found="other weights", expected=expected)
        self._check_header(path, data)
        weights = arrays_of(path, data)
        problem = self.why_unusable(weights, config["sizes"])
        if problem:
            expected = "the shapes of config.json, finite numbers"
            raise PolicyFileError(path, "arrays", found=problem, expected=expected)
        return weights

    def _check_header(self, path: Path, data: bytes) -> None:
        """What the file says of its arrays: these names, each once, as 32-bit floats."""
        arrays, _ = header_of(path, data)
        if set(arrays) != set(self.layers):
            found, expected = str(sorted(arrays)), str(sorted(self.layers))
            raise PolicyFileError(path, "arrays", found=found, expected=expected)


def header_of(path: Path, data: bytes) -> tuple[dict[str, Any], Any]:
    """What a safetensors file says of its arrays, each once and of 32-bit floats, and its metadata as they stand.

    Raises:
        PolicyFileError: it has no such header.
    """
    size = int.from_bytes(data[:8], "little")
    if not 0 < size <= min(len(data) - 8, MAX_HEADER_BYTES):
        found, expected = f"a header of {size} bytes", f"safetensors with one of at most {MAX_HEADER_BYTES}"
        raise PolicyFileError(path, "file", found=found, expected=expected)
    header = parse_json(data[8 : 8 + size], path, "safetensors with a header", PolicyFileError, "header")
    if not isinstance(header, dict):
        raise PolicyFileError(path, "header", found=type(header).__name__, expected="arrays by name")
    metadata = header.pop(METADATA, {})
    for name, one in header.items():
        dtype = one.get("dtype") if isinstance(one, dict) else None
        if dtype != DTYPE:
            raise PolicyFileError(path, name, found=f"dtype {dtype!r}", expected=f"{DTYPE!r}")
    return header, metadata


def arrays_of(path: Path, data: bytes) -> dict[str, NDArray[np.float32]]:
    """The arrays of a safetensors file whose header was looked at.

    Raises:
        PolicyFileError: header and arrays do not fit together.
    """
    try:
        found: dict[str, NDArray[np.float32]] = safetensors.numpy.load(data)
    except (SafetensorError, ValueError, LookupError, TypeError, OverflowError, MemoryError) as error:
        raise PolicyFileError(path, "file", found=str(error), expected="safetensors") from error
    return found


def remove_policy(folder: Path) -> None:
    """Remove the two files of a policy folder, and the folder if nothing else is in it; nothing if there is none."""
    for name in (CONFIG_FILE, WEIGHTS_FILE):
        (folder / name).unlink(missing_ok=True)
    if folder.is_dir() and not any(folder.iterdir()):
        folder.rmdir()
