"""How our pictures look: sizes, colours that colour-blind eyes tell apart, bands, and files that are whole or not there."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, to_rgb
from matplotlib.figure import Figure

from hexwar_sb3.files import replacing

INK, FAINT = "#33302b", "#8d877d"
CAMPS = {"red": "#c0392b", "blue": "#1f4e9c"}
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a5195", "#444444")
"""Colours of lines (Okabe and Ito, and two more), the first for what a picture is about."""
DPI = 110
_ABOUT = {".pdf": "Subject"}  # what a kind of file calls it
_DATES = {".svg": ("Date",), ".pdf": ("CreationDate",)}


def new_figure(width: float, height: float) -> Figure:
    """An empty figure of so many inches; nothing but files can be made of it."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def write_figure(figure: Figure, path: Path, title: str = "", about: str = "") -> None:
    """Write a figure, whole or not at all; its kind is that of the suffix.

    The file says its title and what it is about, and not when it was made: the same figure gives the same bytes.
    """
    said = {"Title": title, _ABOUT.get(path.suffix, "Description"): about}
    dates = dict.fromkeys(_DATES.get(path.suffix, ()))
    with replacing(path) as temporary, rc_context({"svg.hashsalt": "hexwar"}):
        figure.savefig(temporary, dpi=DPI, metadata={**{k: v for k, v in said.items() if v}, **dates})


def dress(axes: Axes, title: str = "", **labels: Any) -> None:
    """Give axes their words and a faint grid; `labels` are those of `Axes.set`."""
    axes.set_title(title, fontsize="medium", loc="left", color=INK)
    axes.set(**labels)
    axes.grid(alpha=0.25, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(colors=INK, labelsize="small")


def colour(number: int) -> str:
    """Colour of a line by its number."""
    return COLOURS[number % len(COLOURS)]


def draw_band(
    axes: Axes,
    x: Sequence[float] | npt.NDArray[np.float64],
    mean: Sequence[float] | npt.NDArray[np.float64],
    low: Sequence[float] | npt.NDArray[np.float64],
    high: Sequence[float] | npt.NDArray[np.float64],
    **style: Any,
) -> None:
    """A line with its points, and what it is uncertain by as a band of its colour; `style` is that of the line."""
    (line,) = axes.plot(
        x, mean, **{"marker": "o", "markersize": 3, "linewidth": 1.6, "clip_on": False, **style}
    )
    axes.fill_between(x, low, high, color=line.get_color(), alpha=0.18, linewidth=0)


def ink_on(colormap: Colormap, share: float) -> str:
    """Black or white, whichever is read better on a colour of a map (0..1)."""
    red, green, blue = (
        value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
        for value in to_rgb(colormap(share))
    )
    luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue
    return "black" if (luminance + 0.05) ** 2 > 1.05 * 0.05 else "white"
