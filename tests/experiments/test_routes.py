"""The report of a lower level over maps that it knows and does not know."""

from __future__ import annotations

import numpy as np
import pytest

from hexwar_sb3.commands.train_settings import LOWER_SCENARIOS
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.experiments.routes import asymmetric, report, text, unseen
from hexwar_sb3.maps.files import load_scenario
from hexwar_sb3.maps.spec import STANDARD


def test_the_unseen_map_is_none_of_those_that_the_lower_level_learns_on() -> None:
    hashes = {load_scenario(name).hexmap.hash for name in LOWER_SCENARIOS}

    assert set(STANDARD) < set(LOWER_SCENARIOS)
    assert not {unseen().hexmap.hash, asymmetric().hexmap.hash} & hashes


def test_the_asymmetric_map_is_not_its_own_mirror_image() -> None:
    world = load_world(asymmetric())
    heights = world.cells.elev_m

    assert (heights != heights[world.cells.mirror]).mean() > 0.5
    assert np.any(world.cells.slushy)  # the west is wet


def test_the_report_has_a_row_for_each_map_and_type() -> None:
    rows = report("heuristic", routes=1)

    assert [row["map"] for row in rows[::5]] == [*STANDARD, "unseen", "asymmetric"]
    assert {row["finished"] for row in rows} == {1.0}
    assert {row["agreement"] for row in rows} == {1.0}
    assert len(text(rows).splitlines()) == 1 + len(rows)


@pytest.mark.parametrize("make", [unseen, asymmetric])
def test_the_maps_are_the_same_every_time(make: object) -> None:
    assert callable(make)
    assert make().hexmap.hash == make().hexmap.hash
