"""All ways in for files of strangers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fnmatch import fnmatch
from functools import partial
from pathlib import Path

from tests.attack.load_games import (
    camp_attempt,
    map_attempt,
    map_cases,
    named_cases,
    replay_attempt,
    replay_cases,
    scenario_attempt,
    scenario_cases,
    spots_attempt,
    spots_cases,
)
from tests.attack.load_models import (
    checkpoint_attempt,
    checkpoint_cases,
    model_attempt,
    model_cases,
    npz_cases,
    steps_attempt,
)
from tests.attack.load_policies import (
    levels_cases,
    lower_attempt,
    one_file_attempt,
    one_file_cases,
    policy_attempt,
    policy_cases,
)
from tests.attack.load_results import (
    curve_attempt,
    league_attempt,
    league_cases,
    study_attempt,
    study_cases,
    terrain_attempt,
    terrain_cases,
    tournament_attempt,
    tournament_cases,
)
from tests.attack.load_settings import preset_attempt, preset_cases, run_attempt, run_cases
from tests.attack.oracle import Attempt
from tests.attack.tricks import Case


@dataclass(frozen=True)
class Loader:
    """One way in.

    `prepare(root)` gives the function that loads the files of a folder and uses them. It ends well, raises one of our
    errors or an OSError (refused), `Wrong` (taken, and not what the file says or what may be), or anything else: a fault.
    """

    name: str
    folder: str  # of the valid files, in the root
    cases: Callable[[Path], Iterator[Case]]
    prepare: Callable[[Path], Attempt]
    leaves: tuple[str, ...] = (".lock", "*.lock")  # what loading may leave beside the files

    def may_leave(self, name: str) -> bool:
        """Whether a file of this name may lie there afterwards."""
        return any(fnmatch(part, pattern) for part in Path(name).parts for pattern in self.leaves)


ANYTHING = ("*",)
LOADERS: dict[str, Loader] = {
    one.name: one
    for one in (
        Loader("map", "map", map_cases, map_attempt),
        Loader("scenario", "scenario", scenario_cases, scenario_attempt),
        Loader("scenario and map", "named", named_cases, scenario_attempt),
        Loader("hot spots", "spots", spots_cases, spots_attempt),
        Loader("replay", "replay", partial(replay_cases, "game.hwr"), replay_attempt),
        Loader("camp's replay", "camp", partial(replay_cases, "red.hwr"), camp_attempt),
        Loader("policy", "policy", policy_cases, policy_attempt),
        Loader("policy of two levels", "levels", levels_cases, policy_attempt),
        Loader("policy as one file", "one_file", one_file_cases, one_file_attempt),
        Loader("lower policy", "lower", policy_cases, lower_attempt),
        Loader("preset", "preset", preset_cases, preset_attempt, ("runs",)),
        Loader("run", "run", run_cases, run_attempt),
        Loader("QMIX", "qmix", model_cases, partial(model_attempt, "qmix")),
        Loader(
            "HierarchicalQMIX", "hierarchical", model_cases, partial(model_attempt, "hierarchical"), ("runs",)
        ),
        Loader("MaskedDQN", "masked", model_cases, partial(model_attempt, "masked")),
        Loader("replay buffer", "steps", partial(npz_cases, "replay.npz"), steps_attempt),
        Loader(
            "checkpoint", "checkpoint", checkpoint_cases, partial(checkpoint_attempt, "checkpoint", "qmix")
        ),
        Loader(
            "checkpoint of two levels",
            "levels_checkpoint",
            checkpoint_cases,
            partial(checkpoint_attempt, "levels_checkpoint", "hierarchical"),
        ),
        Loader("evaluations", "curve", partial(npz_cases, "evaluations.npz"), curve_attempt, ("again.npz",)),
        Loader("match", "tournament", tournament_cases, tournament_attempt, ("*.json", "*.lock", ".lock")),
        Loader("league", "league", league_cases, league_attempt, ("league.png", "*.lock", ".lock")),
        Loader(
            "study", "study", study_cases, study_attempt, ("found.json", "*.lock", ".lock", "preset.json")
        ),
        Loader("cached terrain", "terrain", terrain_cases, terrain_attempt, ANYTHING),
    )
}
