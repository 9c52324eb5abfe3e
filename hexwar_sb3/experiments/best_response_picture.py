"""The picture of best responses: their win rates against the player, as they learn."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from hexwar_sb3.experiments.best_response import HALF
from hexwar_sb3.files import replacing

COLOURS = {"red": "tab:red", "blue": "tab:blue"}


def draw_responses(found: Sequence[dict[str, Any]], path: Path, *, player: str) -> None:
    """Write the curves of all responses as a PNG; their colour is the response's camp."""
    figure = Figure(figsize=(7, 4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    seen: set[str] = set()
    for figures in found:
        camp = str(figures["head"]["camp"])
        games = [0, *(row["games"] for row in figures["curve"])]
        rates = [float("nan"), *(100 * row["win_rate"] for row in figures["curve"])]
        label = None if camp in seen else f"responses as {camp}"
        axes.plot(games, rates, color=COLOURS[camp], marker="o", markersize=3, linewidth=1, label=label)
        seen.add(camp)
    axes.axhline(100 * HALF, color="grey", linewidth=0.8)
    axes.set(
        xlabel="games that the response learned from",
        ylabel="win rate against the player, %",
        ylim=(0, 100),
        xlim=(0, None),
        title=f"Fresh best responses to {player}",
    )
    axes.grid(alpha=0.3)
    axes.legend(loc="upper left")
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=120)
