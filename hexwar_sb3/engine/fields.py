"""What a file holds is checked by the ranges of its records' fields."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NoReturn, TypeAlias

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.errors import CheckpointError
from hexwar_sb3.records import Bound, Field

Bounds: TypeAlias = Mapping[str, Any]  # what the names stand for: numbers, or arrays with a value a game

ANY_I1 = (-128, 127)  # least and most
ANY_U4 = 2**32 - 1
ANY_U8 = 2**64 - 1


def refuse(place: str, found: object, expected: str) -> NoReturn:
    """Refuse what a snapshot holds.

    Raises:
        CheckpointError: always.
    """
    raise CheckpointError("snapshot", place, found=str(found), expected=expected)


def check_names(arrays: Mapping[str, Any], expected: Iterable[str], place: str = "arrays") -> None:
    """Check that a snapshot holds these arrays and no others.

    Raises:
        CheckpointError: it does not.
    """
    known = list(expected)
    for name in known:
        if name not in arrays:
            refuse(place, f"no {name!r}", "all of a checkpoint")
    for name in arrays:
        if name not in known:
            refuse(place, f"an unknown {name!r}", "what a checkpoint holds")


def check_form(place: str, array: Any, dtype: Any, shape: tuple[int, ...]) -> None:
    """Check an array's type and shape.

    Raises:
        CheckpointError: it has others.
    """
    if not isinstance(array, np.ndarray):
        refuse(place, type(array).__name__, "an array")
    if array.dtype != np.dtype(dtype):
        refuse(place, f"values of the type {array.dtype}", f"{np.dtype(dtype)}")
    if array.shape != shape:
        refuse(place, f"the shape {array.shape}", f"{shape}")


def copied(place: str, array: Any, like: NDArray[Any]) -> NDArray[Any]:
    """Copy an array of this type and shape, laid out as kernels take it.

    Raises:
        CheckpointError: it has others.
    """
    check_form(place, array, like.dtype, like.shape)
    copy = like.copy()
    copy[...] = array
    return copy


def check_rows(place: str, rows: NDArray[Any], fields: Sequence[Field], bounds: Bounds) -> None:
    """Check every field of record arrays, whose first axis is the game.

    Raises:
        CheckpointError: a field is out of its range.
    """
    for field in fields:
        check_range(
            f"{place}.{field.name}", rows[field.name], field.least, field.most, bounds, also=field.also
        )


def check_range(
    place: str,
    values: NDArray[Any],
    least: Bound,
    most: Bound,
    bounds: Bounds | None = None,
    *,
    also: Sequence[float] = (),
) -> None:
    """Check numbers [game, ...]; what is no number is out of every range.

    Raises:
        CheckpointError: one is out of its range.
    """
    values = np.asarray(values)
    low, high = (_resolved(bound, bounds or {}, values.ndim) for bound in (least, most))
    fits = (values >= low) & (values <= high)
    for value in also:
        fits |= values == value
    if not fits.all():
        where = tuple(np.argwhere(~fits)[0].tolist())
        ends = (np.broadcast_to(end, values.shape)[where] for end in (low, high))
        special = "".join(f" or {value}" for value in also)
        refuse(place, f"{values[where]}{_at(where)}", f"{'..'.join(map(str, ends))}{special}")


def check_all(place: str, fits: NDArray[np.bool_], values: Any, expected: str) -> None:
    """Check a condition [game, ...] of the values that it is about.

    Raises:
        CheckpointError: it does not hold everywhere.
    """
    if not fits.all():
        where = tuple(np.argwhere(~fits)[0].tolist())
        refuse(place, f"{np.broadcast_to(values, fits.shape)[where]}{_at(where)}", expected)


def check_same(place: str, rows: Any, others: Any, names: Iterable[str]) -> None:
    """Check that fields are what they must be.

    Raises:
        CheckpointError: one differs.
    """
    for name in names:
        values, expected = np.broadcast_arrays(rows[name], others[name])
        if not (fits := values == expected).all():
            where = tuple(np.argwhere(~fits)[0].tolist())
            refuse(f"{place}.{name}", f"{values[where]}{_at(where)}", f"{expected[where]}")


def _resolved(bound: Bound, bounds: Bounds, n_axes: int) -> Any:
    """The number, or an array [game, 1, ...] that goes with values of so many axes."""
    words = bound if isinstance(bound, tuple) else (bound,)
    values = [bounds[word] if isinstance(word, str) else word for word in words]
    if len(values) == 1 and not isinstance(values[0], np.ndarray):
        return values[0]
    total = np.asarray(sum(np.asarray(value, np.int64) for value in values))
    return total.reshape(total.shape + (1,) * (n_axes - total.ndim)) if total.ndim else total


def _at(where: tuple[int, ...]) -> str:
    return f" at {list(where)}" if where else ""
