"""Records as classes: their annotations make the dtype that kernels read, and tell a type checker what a field holds.

A class of records is never made: kernels get rows of record arrays, and a row of `PIECE` is a `PieceRecord` to the type
checker.
"""

from __future__ import annotations

from collections import namedtuple
from functools import lru_cache
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    Generic,
    NamedTuple,
    TypeAlias,
    TypeVar,
    get_args,
    get_origin,
    get_type_hints,
    overload,
)

import numpy as np

T = TypeVar("T")
First = TypeVar("First", bound=int)
Second = TypeVar("Second", bound=int)

I1: TypeAlias = Annotated[T, "i1"]
I2: TypeAlias = Annotated[T, "i2"]
I4: TypeAlias = Annotated[T, "i4"]
I8: TypeAlias = Annotated[T, "i8"]
U1: TypeAlias = Annotated[T, "u1"]
U4: TypeAlias = Annotated[T, "u4"]
U8: TypeAlias = Annotated[T, "u8"]
F4: TypeAlias = Annotated[T, "f4"]


class Vector(Generic[First, T]):
    """An array with one axis, as kernels see it: numbers, or records."""

    size: int
    shape: tuple[int]

    if TYPE_CHECKING:

        def __getitem__(self, at: First) -> T: ...
        def __setitem__(self, at: First | slice, value: T) -> None: ...
        def __len__(self) -> int: ...


class Table(Generic[First, Second, T]):
    """An array with two axes, as kernels see it."""

    size: int
    shape: tuple[int, int]

    if TYPE_CHECKING:

        @overload
        def __getitem__(self, at: tuple[First, Second]) -> T: ...
        @overload
        def __getitem__(self, at: First) -> Vector[Second, T]: ...
        def __getitem__(self, at: Any) -> Any: ...
        def __setitem__(self, at: tuple[First, Second], value: T) -> None: ...


class Block(Generic[T]):
    """An array with more axes; their order is in the comment where it is made, and what it holds may be a row of it."""

    size: int
    shape: tuple[int, ...]

    if TYPE_CHECKING:

        def __getitem__(self, at: tuple[int, ...]) -> Any: ...
        def __setitem__(self, at: tuple[int, ...], value: T) -> None: ...


Word: TypeAlias = str | int | float
Bound: TypeAlias = Word | tuple[Word, ...]
"""A number, the name of one that depends on the game, or a sum of these."""


class Field(NamedTuple):
    """One field of a record and what may stand in it."""

    name: str
    type: np.dtype[Any]
    least: Bound
    most: Bound
    shape: tuple[int, ...]
    also: tuple[float, ...]  # further values, outside of the range


class _Said(NamedTuple):
    """What a field's annotation does not say."""

    least: Bound = 0
    most: Bound = 0
    shape: tuple[int, ...] = ()
    also: tuple[float, ...] = ()


def within(least: Bound, most: Bound, shape: tuple[int, ...] = (), *, also: tuple[float, ...] = ()) -> Any:
    """What may stand in a field, and its shape; `also`: further values, outside of the range."""
    return _Said(least, most, shape, also)


def of_shape(*shape: int) -> Any:
    """Shape of a field that no file holds, so that its range does not matter."""
    return _Said(shape=shape)


def fields_of(record: type) -> tuple[Field, ...]:
    """Fields of a class of records, in the order in which they are written.

    Plain `int` and `float` take 4 bytes; a tuple is a row of such numbers.
    """
    return tuple(
        _field(record, name, hint) for name, hint in get_type_hints(record, include_extras=True).items()
    )


def _field(record: type, name: str, hint: Any) -> Field:
    said = getattr(record, name, None)
    own = said if isinstance(said, _Said) else _Said()  # else a default value
    row = get_args(hint) if get_origin(hint) is tuple else ()
    return Field(
        name,
        _type_of(row[0] if row else hint),
        own.least,
        own.most,
        own.shape or (len(row),) * bool(row),
        own.also,
    )


def dtype_of(record: type) -> np.dtype[np.void]:
    """Type of a record of this class, laid out as C would."""
    return np.dtype([(field.name, field.type, field.shape) for field in fields_of(record)], align=True)


def _type_of(hint: Any) -> np.dtype[Any]:
    """Type of an entry: a number as it is annotated, or a record within the record."""
    if hint in _PLAIN:
        return np.dtype(_PLAIN[hint])
    if isinstance(hint, type):
        return dtype_of(hint)
    if get_origin(hint) is Annotated:
        return np.dtype(hint.__metadata__[0])
    return _type_of(get_args(hint)[-1])


_PLAIN = {int: "i4", float: "f4"}


def plain(records: Any) -> list[Any]:
    """Records as named tuples of Python's numbers: where Python reads many fields of them, thirty times as fast."""
    return list(map(_tuple_of(records.dtype)._make, records.tolist()))


@lru_cache
def _tuple_of(dtype: np.dtype[np.void]) -> Any:
    return namedtuple("Record", dtype.names or ())  # noqa: PYI024 - its fields are known to the dtype alone
