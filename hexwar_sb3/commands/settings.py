"""Settings that several commands share, with their flags."""

from __future__ import annotations

import re
from typing import Annotated, TypeVar

import tyro

from hexwar_sb3.errors import ConfigError

Json = Annotated[bool, tyro.conf.arg(help="print one JSON object instead of a table")]
Games = Annotated[int, tyro.conf.arg(help="games a cell of the table", aliases=("-n",))]
Seed = Annotated[int, tyro.conf.arg(help="0..999999; the same seed gives the same games")]
DecisionTicks = Annotated[
    int, tyro.conf.arg(help="ticks between two decisions of a policy; as it was trained")
]
T = TypeVar("T")
AsTrained = Annotated[T | None, tyro.conf.arg(help_behavior_hint="(default: as the policy was trained)")]
Cluster = Annotated[
    str | None,
    tyro.conf.arg(
        help="HOST:PORT of a Ray cluster that does the work, this machine one of it; else this machine alone"
    ),
]
MOST_JOBS = 1_000  # each is a process that takes some hundred MB
ConstantPlans = Annotated[
    bool,
    tyro.conf.arg(help="leave out the players that follow one fixed plan", help_behavior_hint=""),
]
ScenarioName = Annotated[
    str, tyro.conf.arg(help="name of a built-in scenario, NAME@SEED for one like it, or path of a file")
]


def check_name(setting: str, name: str) -> None:
    """Check a name that files are called by: no folders, no surprises.

    Raises:
        ConfigError: it has other characters than letters, digits, "-" and "_".
    """
    if not re.fullmatch(r"[A-Za-z0-9_-]{1,80}", name):
        raise ConfigError(f"{setting} must be of letters, digits, - and _, got {name!r}")


def check_jobs(setting: str, jobs: int | None) -> None:
    """Check how many processes are to work side by side; None: as many as there are by themselves.

    Raises:
        ConfigError: none, or more than any machine bears.
    """
    if jobs is None:
        return
    if jobs < 1:
        raise ConfigError(f"{setting} must be at least 1, got {jobs}")
    if jobs > MOST_JOBS:
        raise ConfigError(f"{setting} must be at most {MOST_JOBS}, got {jobs}")
