"""The page at the end of a training: what was learned, beside what else plays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hexwar_sb3.commands.output import as_json, games_bar, panel_table, table
from hexwar_sb3.commands.run_folder import RunFolder, write_text
from hexwar_sb3.evaluation.intervals import Estimate, paired_interval
from hexwar_sb3.evaluation.panel import BOTS, CONSTANT_PLANS, Panel, Terms, play_panel
from hexwar_sb3.evaluation.provenance import provenance
from hexwar_sb3.league.cost import peak_mb

TRAINED = "trained"  # the row that the others are compared with


def write_page(
    folder: RunFolder,
    players: Mapping[str, object],
    terms: Terms,
    *,
    title: str,
    n_timesteps: int,
    minutes: float,
) -> tuple[dict[str, Any], str]:
    """Play fresh games of every player against MA1 and MA2; keep the figures, and the page; return both.

    Args:
        folder: of the run.
        players: by the name of the row; one is "trained".
        terms: of the games.
        title: what was trained on what.
        n_timesteps: env steps of the training.
        minutes: wall time of the training.
    """
    with games_bar(len(players) * len(BOTS) * len(terms.camps) * terms.games) as progress:
        panels = {
            name: play_panel(player, BOTS, terms, name=name, progress=progress)
            for name, player in players.items()
        }
    rows = [row for panel in panels.values() for row in panel.summary()]
    figures = {
        "command": (folder.path / "command.txt").read_text(encoding="utf-8").strip(),
        "seed": terms.seed,
        "n_timesteps": n_timesteps,
        "games": terms.games,
        **provenance(terms.scenario),
        "minutes": minutes,
        "peak_mb": peak_mb(),
        "rows": rows,
    }
    counted = "Figures: fresh games; win rate = (won + drawn / 2) / games; 95 % intervals."
    text = "\n\n".join([f"{title} in {minutes:.1f} minutes.\n{counted}", panel_table(rows), _gains(panels)])
    write_text(folder.path / "page.json", as_json(figures) + "\n")
    write_text(folder.page, text + "\n")
    return figures, text


def _gains(panels: dict[str, Panel]) -> str:
    """Say how far the trained policy is above others on the same seeds; of the constant plans, the best one."""
    rows = []
    for opponent in BOTS:
        trained = panels[TRAINED].against(opponent)
        plans = [name for name in CONSTANT_PLANS if name in panels]
        best = sorted(plans, key=lambda name: panels[name].against(opponent).win_rate.value)[-1:]
        others = [name for name in panels if name not in (TRAINED, *plans)]
        for name in (*others, *best):
            other = panels[name].against(opponent)
            won = paired_interval(100 * trained.scores, 100 * other.scores)
            rows.append(
                [opponent, name, _signed(won), _signed(paired_interval(trained.margins, other.margins))]
            )
    return table(("against", "trained minus", "win rate, %", "mean margin"), rows)


def _signed(estimate: Estimate) -> str:
    return f"{estimate.value:+.1f} [{estimate.low:+.1f}, {estimate.high:+.1f}]"
