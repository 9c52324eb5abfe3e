"""Pictures of a study: history, importances, slices, alpha and beta for each Delta-t, the race."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import optuna
from matplotlib.ticker import MaxNLocator
from optuna.importance import PedAnovaImportanceEvaluator
from optuna.trial import FrozenTrial, TrialState
from optuna.visualization import matplotlib as plots

from hexwar_sb3.files import replacing
from hexwar_sb3.pictures import FAINT
from hexwar_sb3.tuning.space import short

LEAST_FOR_IMPORTANCES = 4  # completed trials
PANELS_A_ROW = 4
REACHED = "mean margin / force"


def draw_study(study: optuna.Study, folder: Path) -> list[Path]:
    """Write the pictures that the trials suffice for; nothing but files, whatever backend is set.

    Args:
        study: with a completed trial.
        folder: gets the pictures.
    """
    done = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
    drawn: dict[str, Callable[[], Any]] = {
        "surface": lambda: _draw_surface(_shown(study)),
        "race": lambda: _draw_race(_shown(study)),
        "history": lambda: plots.plot_optimization_history(study, target_name=REACHED),
        "slices": lambda: plots.plot_slice(study, target_name=REACHED),
    }
    if len(done) >= LEAST_FOR_IMPORTANCES:
        drawn["importances"] = lambda: plots.plot_param_importances(
            study, evaluator=PedAnovaImportanceEvaluator(), target_name=REACHED
        )
    quiet = warnings.catch_warnings(
        action="ignore"
    )  # that plots are experimental, that an axis has one value
    with quiet, mpl.rc_context({"backend": "agg"}):
        return [_write(draw(), folder / f"{name}.png") for name, draw in drawn.items()] if done else []


def _shown(study: optuna.Study) -> list[FrozenTrial]:
    """Completed trials, and pruned ones that reported anything."""
    ended = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE, TrialState.PRUNED))
    return [one for one in ended if one.state == TrialState.COMPLETE or one.intermediate_values]


def _write(axes: Any, path: Path) -> Path:
    import matplotlib.pyplot as plt

    figure = np.ravel(axes)[0].figure
    with replacing(path) as temporary:
        figure.savefig(temporary, dpi=100, bbox_inches="tight")
    plt.close(figure)
    return path


def _draw_surface(trials: list[FrozenTrial]) -> Any:
    """A panel for each Delta-t that was tried: alpha and beta of its trials, the colour is what they reached."""
    import matplotlib.pyplot as plt

    times = sorted({one.params["decision_ticks"] for one in trials})
    reached = [_reached(one) for one in trials]
    columns = min(len(times), PANELS_A_ROW)
    rows = -(-len(times) // columns)
    figure, panels = plt.subplots(
        rows,
        columns,
        figsize=(2.2 * columns + 1.2, 2.2 * rows + 0.4),
        sharex=True,
        sharey=True,
        squeeze=False,
        layout="constrained",
    )
    colours = mpl.cm.ScalarMappable(mpl.colors.Normalize(min(reached), max(reached) + 1e-9), "viridis")
    for axes, ticks in zip(panels.flat, times, strict=False):
        _draw_panel(axes, [one for one in trials if one.params["decision_ticks"] == ticks], colours)
        axes.set_title(f"every {ticks} ticks", fontsize="medium")
    for axes in panels.flat[len(times) :]:
        axes.set_axis_off()
    for name, limits in (("alpha", panels[0][0].set_xlim), ("beta", panels[0][0].set_ylim)):
        searched: Any = trials[0].distributions[name]
        limits(np.log10(searched.low) - 0.1, np.log10(searched.high) + 0.1)
    figure.supxlabel("log10 alpha")
    figure.supylabel("log10 beta")
    figure.colorbar(colours, ax=panels.ravel().tolist(), label=f"{REACHED}; x: pruned")
    return panels


def _draw_panel(axes: Any, trials: list[FrozenTrial], colours: Any) -> None:
    """Draw the trials of one Delta-t where they lie, with their numbers; nothing is said of what was not tried."""
    at = np.log10([[one.params["alpha"], one.params["beta"]] for one in trials])
    reached = np.array([_reached(one) for one in trials])
    for state, marker in ((TrialState.COMPLETE, "o"), (TrialState.PRUNED, "x")):
        some = np.array([one.state == state for one in trials])
        axes.scatter(*at[some].T, c=colours.to_rgba(reached[some]), marker=marker)
    for one, place in zip(trials, at, strict=True):
        axes.annotate(str(one.number), place, (4, 3), textcoords="offset points", fontsize=6, color=FAINT)
    axes.grid(alpha=0.25, linewidth=0.6)


def _draw_race(trials: list[FrozenTrial]) -> Any:
    """Mean of each trial over its trainings so far; completed ones end in a dot, the best and the first have a name."""
    import matplotlib.pyplot as plt

    _, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    done = [one for one in trials if one.state == TrialState.COMPLETE]
    best = max(done, key=_reached)
    for one in trials:
        named = {best.number: "C1", 0: "C0"}.get(one.number)
        point = ", ".join(f"{name} {short(value)}" for name, value in one.params.items())
        axes.plot(
            list(one.intermediate_values),
            list(one.intermediate_values.values()),
            color=named or "0.7",
            marker="o" if one.state == TrialState.COMPLETE else "x",
            markevery=[-1] if one.intermediate_values else None,
            linewidth=2 if named else 1,
            zorder=3 if named else 2,
            label=f"trial {one.number}: {point}" if named else None,
        )
    axes.set(xlabel="trainings, one a seed", ylabel=f"{REACHED}, of the trainings so far")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_title(f"{len(done)} trials completed, {len(trials) - len(done)} pruned (x)")
    axes.legend(loc="lower right")
    return axes


def _reached(trial: FrozenTrial) -> float:
    """What a trial ended at, or its last report."""
    if trial.state == TrialState.COMPLETE and trial.value is not None:
        return trial.value
    return trial.intermediate_values[max(trial.intermediate_values)]
