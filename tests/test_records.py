"""Classes of records: the dtype that kernels read is made of their annotations."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.engine.sound import TABLES
from hexwar_sb3.engine.state import new_state
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.records import (
    F4,
    I1,
    I2,
    U4,
    Block,
    Field,
    Table,
    Vector,
    dtype_of,
    fields_of,
    of_shape,
    within,
)


class Inner:
    """A record within another."""

    flag: I1[int]
    worth: F4[float]


class Outer:
    """One field of each kind."""

    bits: U4[np.uint32] = within(0, "most")
    cell: I2[int] = within(-1, ("last", 1), also=(99,))
    ammo: Vector[int, I1[int]] = within(0, 9, (4,))
    grid: Table[int, int, I2[int]] = of_shape(2, 3)
    odds: Block[F4[float]] = of_shape(2, 2, 2)
    inner: Inner
    inners: Vector[int, Inner] = of_shape(5)
    count: int
    share: float = 0.5  # a default value says nothing of the form
    row: tuple[float, float, float]


def test_a_dtype_is_what_the_annotations_say() -> None:
    inner = np.dtype([("flag", "i1"), ("worth", "f4")], align=True)

    assert dtype_of(Outer) == np.dtype(
        [
            ("bits", "u4"),
            ("cell", "i2"),
            ("ammo", "i1", (4,)),
            ("grid", "i2", (2, 3)),
            ("odds", "f4", (2, 2, 2)),
            ("inner", inner),
            ("inners", inner, (5,)),
            ("count", "i4"),
            ("share", "f4"),
            ("row", "f4", (3,)),
        ],
        align=True,
    )


def test_a_field_says_what_may_stand_in_it() -> None:
    bits, cell, ammo, *_ = fields_of(Outer)

    assert bits == Field("bits", np.dtype("u4"), 0, "most", (), ())
    assert cell == Field("cell", np.dtype("i2"), -1, ("last", 1), (), (99,))
    assert (ammo.least, ammo.most, ammo.shape) == (0, 9, (4,))


def test_every_array_of_a_game_has_its_table_of_ranges() -> None:
    state = new_state(load_world("plain"), 1)

    for name, fields in TABLES.items():
        assert [field.name for field in fields] == list(getattr(state, name).dtype.names)
