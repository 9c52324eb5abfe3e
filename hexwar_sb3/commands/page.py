"""The page at the end of a training: what was learned, and where it lies."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from hexwar_sb3.commands.output import panel_table, print_json, table
from hexwar_sb3.commands.run_folder import RunFolder, write_text
from hexwar_sb3.evaluation.intervals import Estimate, paired_interval
from hexwar_sb3.evaluation.panel import CAMPS, CONSTANT_PLANS, Panel, play_panel

if TYPE_CHECKING:
    from hexwar_sb3.commands.train import Train

OPPONENTS = ("MA1", "MA2")


def write_page(settings: Train, folder: RunFolder) -> None:
    """Play fresh games before and after, print the page and keep it with its figures."""
    players = {"untrained": str(folder.untrained), "trained": str(folder.policy)}
    players |= {name: name for name in CONSTANT_PLANS}
    panels = {name: _play(settings, name, player) for name, player in players.items()}
    rows = [row for panel in panels.values() for row in panel.summary()]
    figures = {"command": (folder.path / "command.txt").read_text(encoding="utf-8").strip(), "rows": rows}
    write_text(folder.path / "page.json", json.dumps(figures, indent=2) + "\n")
    text = "\n\n".join([_title(settings), panel_table(rows), _gains(panels), _places(folder)])
    write_text(folder.page, text + "\n")
    if settings.json:
        print_json({**figures, "run": str(folder.path)})
    else:
        print(text)


def _play(settings: Train, name: str, player: str) -> Panel:
    return play_panel(
        player,
        OPPONENTS,
        name=name,
        games=settings.final_games,
        scenario=settings.scenario,
        seed=settings.seed,
        camps=CAMPS if settings.side == "both" else (settings.side,),
    )


def _title(settings: Train) -> str:
    steps = f"{settings.n_timesteps:,} env steps against {', '.join(settings.opponents)}"
    return f'What was learned on "{settings.scenario}", seed {settings.seed}, {steps}; fresh games, 95 % intervals:'


def _gains(panels: dict[str, Panel]) -> str:
    """Say how much the training gained, game by game on the same seeds, by opponent."""
    rows = []
    for opponent in OPPONENTS:
        before, after = panels["untrained"].against(opponent), panels["trained"].against(opponent)
        won = paired_interval(100 * after.scores, 100 * before.scores)
        rows.append([opponent, _signed(won), _signed(paired_interval(after.margins, before.margins))])
    return table(("gained against", "win rate, points of %", "mean margin"), rows)


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
