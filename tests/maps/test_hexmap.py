"""What a map promises its readers."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.maps.scenario import Scenario

FLAT = """
.....
....
.....
"""


def changed(hexmap: HexMap, layer: str, y: int, x: int, value: Any) -> HexMap:
    values = getattr(hexmap, layer).copy()
    values[y, x] = value
    return replace(hexmap, **{layer: values})


def test_arrays_of_a_map_cannot_be_written(board: Any) -> None:
    with pytest.raises(ValueError, match="read-only"):
        board(FLAT).paved[0, 0] = True


def test_void_cells_hold_nothing(board: Any) -> None:
    hexmap = board(FLAT)
    for layer, value in (("passable", True), ("concealed", True), ("elev_m", 10)):
        with pytest.raises(ConfigError, match="void"):
            changed(hexmap, layer, 1, 4, value)


def test_altitudes_are_multiples_of_the_grade(board: Any) -> None:
    with pytest.raises(ConfigError, match="multiple of grade_m = 10"):
        changed(board(FLAT), "elev_m", 0, 0, 15)


def test_layers_have_one_shape(board: Any) -> None:
    with pytest.raises(ConfigError, match="passable: expected booleans of shape"):
        replace(board(FLAT), passable=np.ones((2, 2), np.bool_))


def test_sides_are_3_to_99_cells(board: Any) -> None:
    hexmap = board(FLAT)
    layers = {
        f.name: getattr(hexmap, f.name)[:2]
        for f in fields(hexmap)
        if f.name not in ("name", "grade_m", "seed")
    }
    with pytest.raises(ConfigError, match="3 to 250"):
        HexMap(name="small", grade_m=10, **layers)


def test_the_hash_sees_every_layer_but_not_the_name(board: Any) -> None:
    hexmap = board(FLAT)
    assert replace(hexmap, name="other", seed=7).hash == hexmap.hash
    for layer, value in (("passable", False), ("paved", True), ("concealed", True), ("slushy", True)):
        assert changed(hexmap, layer, 1, 1, value).hash != hexmap.hash
    assert changed(hexmap, "controllable", 1, 1, True).hash != hexmap.hash
    assert changed(hexmap, "elev_m", 1, 1, 10).hash != hexmap.hash


def test_mirroring_twice_gives_the_same_map(rough_board: Any) -> None:
    hexmap = rough_board(3)
    assert hexmap.mirrored().hash != hexmap.hash
    assert hexmap.mirrored().mirrored().hash == hexmap.hash


def test_builtin_maps_are_symmetric(scenario: Scenario) -> None:
    assert scenario.hexmap.is_symmetric()
