"""Pictures: they can be saved, for any map, with and without a scenario."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

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


@pytest.mark.parametrize(("width", "height"), [(20, 11), (90, 24), (12, 60), (3, 3)])
def test_the_legend_is_whole_and_the_page_not_half_white(board: Any, width: int, height: int) -> None:
    rows = ["." * (width - y % 2) for y in range(height)]
    figure = map_picture(board("\n".join(rows)))
    FigureCanvasAgg(figure).draw()  # type: ignore[no-untyped-call]
    page, (legend,) = figure.bbox, figure.legends

    box = legend.get_window_extent()
    assert page.x0 <= box.x0 < box.x1 <= page.x1
    assert page.y0 <= box.y0 < box.y1 <= page.y1
    drawn = figure.axes[0].get_window_extent()
    assert drawn.width * drawn.height > 0.3 * page.width * page.height
    assert drawn.y0 >= box.y1


def test_north_is_up_and_odd_rows_lie_half_a_cell_east(board: Any) -> None:
    where = centres(board("...\n..\n..."))
    assert where[3][0] == where[0][0] + 0.5
    assert where[3][1] < where[0][1]
