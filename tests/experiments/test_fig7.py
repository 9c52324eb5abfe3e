from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from hexwar_sb3.experiments.fig7 import draw, runs
from hexwar_sb3.experiments.runs import Budget, Places, choose

MakeFolder = Callable[..., Path]
RUNS = runs(Budget(games=100), [0, 1])


@pytest.fixture
def figures(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    """Figures that were saved."""
    saved: list[Figure] = []
    save = Figure.savefig

    def keep(figure: Figure, *args: object, **kwargs: object) -> None:
        saved.append(figure)
        save(figure, *args, **kwargs)  # type: ignore[arg-type]  # passed on as they came

    monkeypatch.setattr(Figure, "savefig", keep)
    return saved


def test_the_figure_draws_what_is_there(
    places: Places, make_results: MakeFolder, figures: list[Figure], tmp_path: Path
) -> None:
    for run, margin in zip(choose(RUNS, ["hrl-plain", "dqn-hills"]), (10.0, 30.0, -50.0), strict=True):
        make_results(run, margin=margin, minutes=margin + 60)

    draw(RUNS, places, tmp_path / "fig7.png")

    (figure,) = figures
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles == [
        f"{scenario}, against {opponent}"
        for scenario in ("plain", "hills")
        for _ in ("win rate", "margin")
        for opponent in ("MA1", "MA2")
    ]
    (legend,) = figure.legends  # one for all
    assert [text.get_text() for text in legend.get_texts()] == [
        "HRL (2 trainings, 80 min each)",
        "DQN, the paper's (1 training, 10 min each)",
        "the paper's HRL0",
    ]
    assert all(axes.get_ylim() == (0.0, 1.0) for axes in figure.axes[0:2])  # one y-axis
    papers = [
        any(line.get_label() == "the paper's HRL0" for line in axes.get_lines()) for axes in figure.axes
    ]
    assert papers == [True, True, *6 * [False]]  # Tab. I is of the first map, and of win rates
    assert (tmp_path / "fig7.png").read_bytes().startswith(b"\x89PNG")


def test_a_curve_is_the_mean_over_seeds_and_its_band_their_range(
    places: Places, make_results: MakeFolder, figures: list[Figure], tmp_path: Path
) -> None:
    """Margins against MA1 are those of the first four games: 0, 1, 2, 3 above the seed's own."""
    for run, margin in zip(choose(RUNS, ["hrl-plain"]), (10.0, 30.0), strict=True):
        make_results(run, margin=margin)

    draw(RUNS, places, tmp_path / "fig7.png")

    axes = figures[0].axes[2]
    assert np.asarray(axes.lines[0].get_xydata()).tolist() == [[0.0, 21.5], [100.0, 21.5]]
    band = axes.collections[0].get_paths()[0].get_extents()
    assert (band.y0, band.y1) == (11.5, 31.5)


def test_without_results_the_figure_is_empty(places: Places, figures: list[Figure], tmp_path: Path) -> None:
    draw(RUNS, places, tmp_path / "fig7.png")

    assert [axes.get_title(loc="left") for axes in figures[0].axes] == ["", "", "", ""]
