"""The picture of best responses: their win rates against the player, as they learn."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hexwar_sb3.experiments.best_response import HALF
from hexwar_sb3.pictures import CAMPS, INK, dress, new_figure, write_figure


def draw_responses(found: Sequence[dict[str, Any]], path: Path, *, player: str) -> None:
    """Write the curves of all responses as a PNG; their colour is the response's camp."""
    figure = new_figure(7, 4)
    axes = figure.subplots()
    seen: set[str] = set()
    for figures in found:
        camp = str(figures["head"]["camp"])
        games = [0, *(row["games"] for row in figures["curve"])]
        rates = [float("nan"), *(100 * row["win_rate"] for row in figures["curve"])]
        label = None if camp in seen else f"responses as {camp}"
        axes.plot(games, rates, color=CAMPS[camp], marker="o", markersize=3, linewidth=1, label=label)
        seen.add(camp)
    axes.axhline(100 * HALF, color=INK, linewidth=0.8)
    dress(
        axes,
        f"Fresh best responses to {player}, a line a training",
        xlabel="games that the response learned from",
        ylabel="win rate against the player, %",
        ylim=(0, 100),
        xlim=(0, None),
    )
    axes.legend(loc="upper left", fontsize="small")
    write_figure(figure, path)
