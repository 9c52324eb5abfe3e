"""The page at the end of a training: what was learned, beside what else plays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from hexwar_sb3.bots.registry import BOTS as BOTS_BY_NAME
from hexwar_sb3.commands.output import as_json, games_bar, panel_table, table
from hexwar_sb3.commands.run_folder import RunFolder, write_text
from hexwar_sb3.evaluation.intervals import Estimate, paired_interval
from hexwar_sb3.evaluation.matches import Evaluation
from hexwar_sb3.evaluation.opponents import broad_mixture, with_weights
from hexwar_sb3.evaluation.panel import BOTS, CONSTANT_PLANS, Panel, play_panel
from hexwar_sb3.evaluation.provenance import provenance
from hexwar_sb3.league.cost import peak_mb
from hexwar_sb3.maps.scenario import ScenarioLike
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.player import POLICIES, seat_name

if TYPE_CHECKING:
    from stable_baselines3.common.vec_env import VecEnv

PAST = "itself, earlier"  # copies of the learner, in the table of who was met
TRAINED = "trained"  # the row that the others are compared with
OTHERS = tuple(name for name in BOTS_BY_NAME if name not in (*BOTS, "random"))
"""Further scripted players that the trained one meets, most of them for the first time."""
OTHERS_SHARE = 4  # of its games against MA1 and MA2


def write_page(
    folder: RunFolder,
    players: Mapping[str, object],
    evaluation: Evaluation,
    *,
    title: str,
    n_timesteps: int,
    minutes: float,
    core_minutes: float,
    met: Sequence[Mapping[str, Any]] = (),
    threads: int = 1,
) -> tuple[dict[str, Any], str]:
    """Play fresh games of every player against MA1 and MA2, and of the trained one against others.

    Figures and page are kept, and returned.

    Args:
        folder: of the run.
        players: by the name of the row; one is "trained".
        evaluation: how they are measured.
        title: what was trained on what.
        n_timesteps: env steps of the training.
        minutes: wall time of the training.
        core_minutes: its processor time; of earlier parts of a run that was broken off, their wall time.
        met: who was met in it (`met_by`).
        threads: cells side by side.
    """
    fewer = replace(evaluation, games=max(1, evaluation.games // OTHERS_SHARE))
    strangers = others_on(evaluation.terms.scenario)
    games = len(players) * len(BOTS) * evaluation.games + len(strangers) * fewer.games
    with games_bar(games * len(evaluation.camps)) as progress:
        how: Any = {"threads": threads, "progress": progress}
        panels = {
            name: play_panel(player, BOTS, evaluation, name=name, **how) for name, player in players.items()
        }
        others = play_panel(players[TRAINED], strangers, fewer, name=TRAINED, **how)
    rows = [row for panel in panels.values() for row in panel.summary()]
    figures = {
        "command": (folder.path / "command.txt").read_text(encoding="utf-8").strip(),
        "seed": evaluation.seed,
        "n_timesteps": n_timesteps,
        "games": evaluation.games,
        **provenance(evaluation.terms.scenario),
        "minutes": minutes,
        "core_minutes": core_minutes,
        "peak_mb": peak_mb(),
        "rows": rows,
        "others": others.summary(),
        "met": list(met),
    }
    counted = "Figures: fresh games; win rate = (won + drawn / 2) / games; 95 % intervals."
    tables = [
        panel_table(rows),
        _gains(panels),
        panel_table(others.summary()),
        *([_met_table(met)] if met else []),
    ]
    text = "\n\n".join([f"{title} in {minutes:.1f} minutes.\n{counted}", *tables])
    write_text(folder.path / "page.json", as_json(figures) + "\n")
    write_text(folder.page, text + "\n")
    return figures, text


def others_on(scenario: ScenarioLike) -> tuple[str, ...]:
    """Further players that can play a map, scripted and learned."""
    return (*OTHERS, *(name for name in with_weights(broad_mixture(scenario)) if name in POLICIES))


def met_by(env: VecEnv) -> list[dict[str, Any]]:
    """Who was met in the games of a task env, how often, and how the latest of them went for the learner."""
    games = env.get_attr("games")[0]
    counted, found = games.encounters, dict[str, tuple[int, float]]()
    for name, seat, n, rate in zip(
        games.mixture.names, games.mixture.players, counted.games, counted.rates, strict=True
    ):
        called = name or (PAST if isinstance(seat, FrozenPolicy) else seat_name(seat))
        before, won = found.get(called, (0, 0.0))
        found[called] = before + int(n), won + int(n) * float(rate)
    return [
        {"opponent": name, "games": n, "recent_win_rate": round(won / n, 4) if n else 0.5}
        for name, (n, won) in found.items()
    ]


def _met_table(met: Sequence[Mapping[str, Any]]) -> str:
    rows = [[one["opponent"], str(one["games"]), f"{100 * one['recent_win_rate']:.0f}"] for one in met]
    return table(("met in training", "games", "recent win rate, %"), rows)


def _gains(panels: dict[str, Panel]) -> str:
    """Say how far the trained policy is above others on the same seeds; of the constant plans, the best one."""
    rows = []
    for opponent in BOTS:
        trained = panels[TRAINED].against(opponent)
        constant = [name for name in CONSTANT_PLANS if name in panels]
        best = sorted(constant, key=lambda name: panels[name].against(opponent).win_rate.value)[-1:]
        others = [name for name in panels if name not in (TRAINED, *constant)]
        for name in (*others, *best):
            other = panels[name].against(opponent)
            won = paired_interval(100 * trained.scores, 100 * other.scores)
            rows.append(
                [opponent, name, _signed(won), _signed(paired_interval(trained.margins, other.margins))]
            )
    return table(("against", "trained minus", "win rate, %", "mean margin"), rows)


def _signed(estimate: Estimate) -> str:
    return f"{estimate.value:+.1f} [{estimate.low:+.1f}, {estimate.high:+.1f}]"
