"""The outside of a model zip: its entries as bytes, in and out, without pickle."""

from __future__ import annotations

import io
import json
import math
import pathlib
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import stable_baselines3
from numpy.typing import NDArray
from stable_baselines3.common.utils import get_system_info

from hexwar_sb3.algorithms.ranges import INFINITE
from hexwar_sb3.algorithms.tensors import unpack
from hexwar_sb3.errors import CheckpointError, shortened
from hexwar_sb3.reading import parse_json, read_bytes, read_entries

File = str | pathlib.Path | io.BufferedIOBase
FORMAT = "hexwar model 2"
MAX_BYTES = 1 << 28
MAX_DATA_BYTES = 1 << 21  # of the plain values
DATA, VERSION, SYSTEM, WEIGHTS, PICKLED = (
    *("data", "_stable_baselines3_version", "system_info.txt"),
    *(".safetensors", ".pth"),
)


@dataclass(frozen=True)
class ModelZip:
    """What a model zip holds."""

    name: str  # in messages
    data: dict[str, Any]
    weights: dict[str, dict[str, NDArray[Any]]] = field(default_factory=dict)  # by the part of the model
    system: str = ""


def zip_path(path: str | pathlib.Path) -> pathlib.Path:
    """Path of a model zip; the suffix may be left out."""
    path = pathlib.Path(path)
    return path if path.suffix or not path.name else path.with_suffix(".zip")


def read_file(path: File) -> tuple[str, bytes]:
    """Name and bytes of a model zip, read once: what is checked is what is used.

    Raises:
        CheckpointError: it is missing, no regular file, or too large.
    """
    if isinstance(path, str | pathlib.Path):
        place = zip_path(path)
        return str(place), read_bytes(place, MAX_BYTES, CheckpointError, "a model zip")
    name = "model"
    try:
        path.seek(0)
        data = path.read(MAX_BYTES + 1)
    except (OSError, ValueError, AttributeError) as error:
        raise CheckpointError(name, "file", found=str(error), expected="an open binary file") from error
    if not isinstance(data, bytes):
        raise CheckpointError(name, "file", found=type(data).__name__, expected="an open binary file")
    if len(data) > MAX_BYTES:
        raise CheckpointError(
            name, "file size", found=f"more than {MAX_BYTES} bytes", expected=f"at most {MAX_BYTES}"
        )
    return name, data


def has_pickles(name: str, data: bytes) -> bool:
    """Whether the weights in a zip are pickled, as Stable-Baselines3 and our earlier versions write them.

    Raises:
        CheckpointError: it is no zip.
    """
    return any(entry.endswith(PICKLED) for entry in read_entries(data, name, CheckpointError, "a model zip"))


def read_zip(name: str, data: bytes) -> ModelZip:
    """Take the bytes of a zip apart.

    Raises:
        CheckpointError: it is broken, or holds something else than a model of ours.
    """
    entries = read_entries(data, name, CheckpointError, "a model zip")
    if any(entry.endswith(PICKLED) for entry in entries):
        raise CheckpointError(
            name,
            "weights",
            found="pickled ones, of an earlier version or of Stable-Baselines3",
            expected="safetensors, or trust=True: unpickling runs code",
        )
    for entry in entries:
        if entry not in (DATA, VERSION, SYSTEM) and not entry.endswith(WEIGHTS):
            raise CheckpointError(name, entry, found="an unknown entry", expected="those of a model zip")
    text = entries.get(DATA, b"")
    if len(text) > MAX_DATA_BYTES:
        raise CheckpointError(name, DATA, found=f"{len(text)} bytes", expected=f"at most {MAX_DATA_BYTES}")
    values = parse_json(text, name, "names and values", CheckpointError, DATA)
    if not isinstance(values, dict) or values.pop("format", None) != FORMAT:
        raise CheckpointError(name, "data: format", found="another one", expected=FORMAT)
    weights = {
        entry.removesuffix(WEIGHTS): unpack(content, name, entry)
        for entry, content in entries.items()
        if entry.endswith(WEIGHTS)
    }
    return ModelZip(name, values, weights, entries.get(SYSTEM, b"").decode("utf-8", "replace"))


def write_zip(data: Mapping[str, Any], weights: Mapping[str, bytes]) -> bytes:
    """Put a zip together: plain values as JSON, weights by the part of the model."""
    zipped = io.BytesIO()
    with zipfile.ZipFile(zipped, "w") as archive:
        archive.writestr(DATA, json.dumps(_jsonable({"format": FORMAT, **data}), indent=1, allow_nan=False))
        for part, content in weights.items():
            archive.writestr(f"{part}{WEIGHTS}", content)
        archive.writestr(VERSION, stable_baselines3.__version__)
        archive.writestr(SYSTEM, get_system_info(print_info=False)[1])
    return zipped.getvalue()


def _jsonable(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _jsonable(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_jsonable(one) for one in value]
    if isinstance(value, float) and math.isinf(value):
        return INFINITE if value > 0 else f"-{INFINITE}"
    return value


def print_system(zipped: ModelZip) -> None:
    """Print on what a model was saved, and what this is, as SB3 does."""
    print("== CURRENT SYSTEM INFO ==")  # noqa: T201  # print_system_info=True asks for it
    get_system_info()
    print("== SAVED MODEL SYSTEM INFO ==")  # noqa: T201
    print("\n".join(shortened(line) for line in zipped.system.splitlines()[:20]))  # noqa: T201
