"""Weights as safetensors: strict to read, without surprises of memory order to write."""

from __future__ import annotations

from collections.abc import Mapping
from math import prod
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import safetensors.numpy
import torch
from numpy.typing import NDArray
from torch import Tensor

from hexwar_sb3.errors import CheckpointError
from hexwar_sb3.reading import parse_json

Form = tuple[np.dtype[Any], tuple[int, ...]]
"""Type and shape of a tensor."""

DTYPES: dict[str, np.dtype[Any]] = {
    "F16": np.dtype(np.float16),
    "F32": np.dtype(np.float32),
    "F64": np.dtype(np.float64),
    "I64": np.dtype(np.int64),
}
MAX_TENSORS, MAX_LIST_BYTES = 4_096, 1 << 20
_LENGTH_BYTES = 8  # at the beginning: how long the list of tensors is
_ABOUT = "__metadata__"
NEVER_NEGATIVE = ("step", "exp_avg_sq", "max_exp_avg_sq", "square_avg", "sum")  # of an optimiser's state


def pack(tensors: Mapping[str, Tensor | NDArray[Any]]) -> bytes:
    """Write tensors by name."""
    return safetensors.numpy.save(
        {
            name: np.array(one.detach().cpu().numpy() if isinstance(one, Tensor) else one, order="C")
            for name, one in tensors.items()
        }
    )


def unpack(data: bytes, source: str | Path, place: str) -> dict[str, NDArray[Any]]:
    """Read tensors; they stay in the bytes that were given.

    Raises:
        CheckpointError: these are no safetensors, or tensors lie in other places than one behind the other.
    """

    def fail(found: str, expected: str = "tensors as safetensors") -> NoReturn:
        raise CheckpointError(source, place, found=found, expected=expected)

    length = int.from_bytes(data[:_LENGTH_BYTES], "little")
    start = _LENGTH_BYTES + length
    if len(data) < _LENGTH_BYTES or start > len(data) or length > MAX_LIST_BYTES:
        fail(f"{len(data)} bytes, {length} of them for the list")
    listed = parse_json(data[_LENGTH_BYTES:start], source, "a list of tensors", CheckpointError, place)
    if not isinstance(listed, dict) or len(listed) > MAX_TENSORS:
        fail("no dict, or more tensors than a model has", f"at most {MAX_TENSORS} tensors")
    listed.pop(_ABOUT, None)
    found: dict[str, NDArray[Any]] = {}
    for name, entry in sorted(listed.items(), key=lambda item: _begin(item[1])):
        dtype, shape = _form(entry) or fail(f"{name}: {entry!r}", "dtype, shape and data_offsets")
        end = start + prod(shape) * dtype.itemsize
        if entry["data_offsets"] != [start - _LENGTH_BYTES - length, end - _LENGTH_BYTES - length]:
            fail(f"{name}: data_offsets {entry['data_offsets']}", "one tensor behind the other")
        if end > len(data):
            fail(f"{len(data)} bytes", f"at least {end}")
        found[name] = np.frombuffer(data, dtype, prod(shape), start).reshape(shape)
        start = end
    if start != len(data):
        fail(f"{len(data)} bytes", f"{start}, for the tensors that are listed")
    return found


def _begin(entry: Any) -> tuple[int, int]:
    """Where a tensor begins and ends, for sorting; anything for what is none."""
    offsets = entry.get("data_offsets") if isinstance(entry, dict) else None
    if isinstance(offsets, list) and len(offsets) == 2 and all(type(one) is int for one in offsets):
        return offsets[0], offsets[1]
    return 0, 0


def _form(entry: Any) -> Form | None:
    if not isinstance(entry, dict) or set(entry) != {"dtype", "shape", "data_offsets"}:
        return None
    dtype, shape = entry["dtype"], entry["shape"]
    if not isinstance(dtype, str) or dtype not in DTYPES or not isinstance(shape, list) or len(shape) > 8:
        return None
    if not all(type(n) is int and 0 <= n <= 1 << 32 for n in shape):
        return None
    return DTYPES[dtype], tuple(shape)


def forms_of(module: torch.nn.Module) -> dict[str, Form]:
    """Type and shape of each tensor of a network."""
    return {
        name: (np.dtype(str(one.dtype).removeprefix("torch.")), tuple(one.shape))
        for name, one in module.state_dict().items()
    }


def check_forms(
    tensors: Mapping[str, NDArray[Any]], expected: Mapping[str, Form], source: str | Path, place: str
) -> None:
    """Check names, types and shapes, and that every number is finite.

    Raises:
        CheckpointError: they are others.
    """
    for name in [*expected, *tensors]:
        if name not in tensors or name not in expected:
            found, wanted = ("nothing", "a tensor") if name in expected else ("a tensor", "none of this name")
            raise CheckpointError(source, f"{place}: {name}", found=found, expected=wanted)
    for name, one in tensors.items():
        if (one.dtype, one.shape) != expected[name]:
            dtype, shape = expected[name]
            raise CheckpointError(
                source, f"{place}: {name}", found=f"{one.dtype} {one.shape}", expected=f"{dtype} {shape}"
            )
        if not np.isfinite(one).all():
            raise CheckpointError(
                source, f"{place}: {name}", found="numbers that are not finite", expected="finite ones"
            )


def checked_weights(
    module: torch.nn.Module, tensors: Mapping[str, NDArray[Any]], source: str | Path, place: str
) -> dict[str, Tensor]:
    """Weights as `load_state_dict` takes them.

    Raises:
        CheckpointError: they are those of another network, or not finite.
    """
    check_forms(tensors, forms_of(module), source, place)
    return {name: torch.from_numpy(one.copy()) for name, one in tensors.items()}


def state_of(optimizer: torch.optim.Optimizer) -> dict[str, Tensor]:
    """What an optimiser remembers, by the number of the parameter and the name: "0.exp_avg"."""
    return {
        f"{k}.{name}": one
        for k, state in optimizer.state_dict()["state"].items()
        for name, one in state.items()
        if isinstance(one, Tensor)
    }


def checked_state(
    optimizer: torch.optim.Optimizer, tensors: Mapping[str, NDArray[Any]], source: str | Path, place: str
) -> dict[str, Any]:
    """What an optimiser remembered, as `load_state_dict` takes it; its own settings stay.

    Raises:
        CheckpointError: it is the memory of another one.
    """
    parameters = [one for group in optimizer.param_groups for one in group["params"]]
    names = _remembered(optimizer)
    known = {name.partition(".")[0] for name in tensors}
    kept = [k for k in range(len(parameters)) if str(k) in known]
    expected: dict[str, Form] = {
        f"{k}.{name}": (np.dtype(np.float32), () if is_scalar else tuple(parameters[k].shape))
        for k in kept
        for name, is_scalar in names.items()
    }
    check_forms(tensors, expected, source, place)
    for name, one in tensors.items():
        if name.partition(".")[2] in NEVER_NEGATIVE and (one < 0).any():
            raise CheckpointError(source, f"{place}: {name}", found="a number below 0", expected="none")
    state = {k: {name: torch.from_numpy(tensors[f"{k}.{name}"].copy()) for name in names} for k in kept}
    return {**optimizer.state_dict(), "state": state}


def _remembered(optimizer: torch.optim.Optimizer) -> dict[str, bool]:
    """Names of what an optimiser of this kind remembers after a step, and whether each is a single number."""
    parameter = torch.nn.Parameter(torch.zeros(1))
    parameter.grad = torch.zeros(1)
    again: Any = type(optimizer)
    probe = again([parameter], **optimizer.defaults)
    probe.step()
    return {name: one.ndim == 0 for name, one in probe.state[parameter].items() if isinstance(one, Tensor)}
