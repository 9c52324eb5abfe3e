"""The page at the end of a training: what was learned, and where it lies."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from hexwar_sb3.commands.bench_start import peak_mb
from hexwar_sb3.commands.output import games_bar, panel_table, print_json, table
from hexwar_sb3.commands.run_folder import RunFolder, write_text
from hexwar_sb3.evaluation.intervals import Estimate, paired_interval
from hexwar_sb3.evaluation.panel import CONSTANT_PLANS, Panel, play_panel
from hexwar_sb3.evaluation.provenance import provenance
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.play.lower_policy import HEURISTIC_LOWER, FrozenLower

if TYPE_CHECKING:
    from hexwar_sb3.commands.train import Train

OPPONENTS = ("MA1", "MA2")
LED_BY_HEURISTIC = "trained, heuristic lower"


def write_page(settings: Train, folder: RunFolder, *, minutes: float) -> None:
    """Play fresh games before and after, print the page and keep it with its figures.

    Args:
        settings: of the training.
        folder: of the run.
        minutes: wall time of the training.
    """
    players = players_of(settings, folder)
    with games_bar(
        len(players) * len(OPPONENTS) * len(settings.terms().camps) * settings.final_games
    ) as progress:
        panels = {
            name: play_panel(player, OPPONENTS, settings.terms(), name=name, progress=progress)
            for name, player in players.items()
        }
    rows = [row for panel in panels.values() for row in panel.summary()]
    figures = {**_origin(settings, folder), "minutes": minutes, "peak_mb": peak_mb(), "rows": rows}
    write_text(folder.path / "page.json", json.dumps(figures, indent=2) + "\n")
    text = "\n\n".join([_title(settings, minutes), panel_table(rows), _gains(panels), _places(folder)])
    write_text(folder.page, text + "\n")
    if settings.json:
        print_json({**figures, "run": str(folder.path)})
    else:
        print(text)


def players_of(settings: Train, folder: RunFolder) -> dict[str, object]:
    """Say who plays for the page, by the name of the row."""
    trained = FrozenPolicy.load(folder.policy)
    players: dict[str, object] = {"untrained": str(folder.untrained), "trained": trained}
    if isinstance(trained.lower, FrozenLower):
        players[LED_BY_HEURISTIC] = trained.led_by(HEURISTIC_LOWER)
    if settings.constant_plans:
        players |= {name: name for name in CONSTANT_PLANS}
    return players


def _origin(settings: Train, folder: RunFolder) -> dict[str, object]:
    """Where the figures come from."""
    command = (folder.path / "command.txt").read_text(encoding="utf-8").strip()
    budget = {"seed": settings.seed, "n_timesteps": settings.n_timesteps, "games": settings.final_games}
    return {"command": command, **budget, **provenance(settings.scenario)}


def _title(settings: Train, minutes: float) -> str:
    budget = (
        f"{settings.n_timesteps:,} env steps against {', '.join(settings.opponents)} in {minutes:.1f} minutes"
    )
    counted = "fresh games; win rate = (won + drawn / 2) / games; 95 % intervals"
    return f'What was learned on "{settings.scenario}", seed {settings.seed}: {budget}.\nFigures: {counted}.'


def _gains(panels: dict[str, Panel]) -> str:
    """Say how far the trained policy is above others on the same seeds; of the constant plans, the best one."""
    rows = []
    for opponent in OPPONENTS:
        trained = panels["trained"].against(opponent)
        plans = [name for name in CONSTANT_PLANS if name in panels]
        best = sorted(plans, key=lambda name: panels[name].against(opponent).win_rate.value)[-1:]
        others = [name for name in panels if name not in ("trained", *plans)]
        for name in (*others, *best):
            other = panels[name].against(opponent)
            won = paired_interval(100 * trained.scores, 100 * other.scores)
            rows.append(
                [opponent, name, _signed(won), _signed(paired_interval(trained.margins, other.margins))]
            )
    return table(("against", "trained minus", "win rate, %", "mean margin"), rows)


def _signed(estimate: Estimate) -> str:
    return f"{estimate.value:+.1f} [{estimate.low:+.1f}, {estimate.high:+.1f}]"


def _places(folder: RunFolder) -> str:
    places = {
        "policy to share": folder.policy,
        "best model": folder.path / "best_model.zip",
        "last model": folder.model,
        "learning curve": folder.path / "learning_curve.png",
        "replays": folder.replays,
        "this page": folder.page,
    }
    width = max(len(name) for name in places)
    return "\n".join(f"{name:<{width}}  {path}" for name, path in places.items())
