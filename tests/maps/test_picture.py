"""Pictures: they can be saved, for any map, with and without a scenario."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hexwar_sb3.maps.picture import centres, map_picture
from hexwar_sb3.maps.scenario import Scenario


def texts(figure: Any) -> set[str]:
    return {text.get_text() for text in figure.axes[0].texts}


def test_a_builtin_map_with_its_scenario(scenario: Scenario, tmp_path: Path) -> None:
    figure = map_picture(scenario.hexmap, scenario)
    figure.savefig(tmp_path / "map.png", dpi=50)
    assert (tmp_path / "map.png").stat().st_size > 10_000
    assert {"main 80", "secondary 50", "T", "C+S", "A", "1010", "7070"} <= texts(figure)


def test_a_small_rough_map_alone(rough_board: Any, tmp_path: Path) -> None:
    figure = map_picture(rough_board(0))
    figure.savefig(tmp_path / "map.svg")
    assert "1010" in texts(figure)


def test_north_is_up_and_odd_rows_lie_half_a_cell_east(board: Any) -> None:
    where = centres(board("...\n..\n..."))
    assert where[3][0] == where[0][0] + 0.5
    assert where[3][1] < where[0][1]
