"""What a stranger's study may say of its trials and settings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import optuna
import pytest
from optuna.trial import TrialState, create_trial

from hexwar_sb3.errors import ConfigError, FileFormatError, HexWarError
from hexwar_sb3.tuning.space import PAPER, space_of
from hexwar_sb3.tuning.store import open_storage
from hexwar_sb3.tuning.study import StudySpec, begin, known_spec
from hexwar_sb3.tuning.trials import check_trials

SPACE = space_of()
GOOD: dict[str, Any] = {
    "state": TrialState.COMPLETE,
    "value": 0.5,
    "params": PAPER,
    "distributions": SPACE,
    "user_attrs": {
        "ticks": 10,
        "win_rate": 0.5,
        "agreement": 0.0,
        "trainings": [0.4, 0.6],
        "worker": {"host": "x", "pid": 1},
    },
    "intermediate_values": {1: 0.4, 2: 0.5},
    "system_attrs": {"completed_rung_0": 0.4},
}
WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "no value": ({"values": []}, r"trial -1\.values: found \[\]; expected one finite number"),
    "two values": ({"values": [1.0, 2.0]}, r"trial -1\.values: found \[1\.0, 2\.0\]"),
    "an infinite value": ({"values": [float("inf")]}, r"trial -1\.values"),
    "a report that is a text": ({"intermediate_values": {1: "x"}}, r"trial -1\.reports"),
    "a report that is no number": (
        {"intermediate_values": {1: float("nan")}},
        r"trial -1\.reports: found \[\(1, nan\)\]; expected finite numbers by step",
    ),
    "a rung that is a text": (
        {"system_attrs": {"completed_rung_0": "x"}},
        r"trial -1\.completed_rung_0: found 'x'; expected a finite number",
    ),
    "trainings that are a number": (
        {"user_attrs": {"ticks": 1, "trainings": 0.5}},
        r"trial -1\.trainings: found 0\.5; expected a list",
    ),
    "a training that is a text": (
        {"user_attrs": {"ticks": 1, "trainings": [0.5, "x"]}},
        r"trial -1\.trainings: found \[0\.5, 'x'\]",
    ),
    "a training that is infinite": (
        {"user_attrs": {"ticks": 1, "trainings": [float("inf")]}},
        r"trial -1\.trainings: found \[inf\]",
    ),
    "an agreement that is no number": (
        {"user_attrs": {"ticks": 1, "agreement": float("nan")}},
        r"trial -1\.agreement: found nan; expected a finite number",
    ),
    "ticks as a text": (
        {"user_attrs": {"ticks": "x"}},
        r"trial -1\.ticks: found 'x'; expected a whole number",
    ),
    "no ticks": ({"user_attrs": {}}, "trial -1: found no ticks"),
    "a win rate that is a list": ({"user_attrs": {"ticks": 1, "win_rate": []}}, r"trial -1\.win_rate"),
    "a process that is none": (
        {"user_attrs": {"ticks": 1, "worker": None}},
        r"trial -1\.worker: found NoneType",
    ),
    "a process without a host": (
        {"user_attrs": {"ticks": 1, "worker": {"pid": 1}}},
        r"worker\.host: found nothing",
    ),
    "a point of another space": ({"params": {"alpha": 0.1}}, "trial -1: found no beta"),
    "a value outside": ({"params": {**PAPER, "alpha": 7.0}}, r"trial -1\.params: found alpha must be"),
    "attributes without names": ({"system_attrs": [{}]}, r"trial -1\.attributes: found others"),
    "attributes that are a text": ({"user_attrs": "ticks"}, r"trial -1\.attributes: found others"),
    "a point in line that is none": (
        {"system_attrs": {"fixed_params": []}},
        r"trial -1\.point: found a point is",
    ),
}


def made(**changes: Any) -> optuna.trial.FrozenTrial:
    """A trial as a storage gives it; what Optuna itself would refuse to make is put in afterwards."""
    trial = create_trial(**GOOD)
    for name, value in changes.items():
        setattr(
            trial,
            {"values": "_values", "user_attrs": "_user_attrs", "params": "_params"}.get(name, name),
            value,
        )
    return trial


def test_a_trial_of_ours_is_taken() -> None:
    check_trials([made()], SPACE, "study")


@pytest.mark.parametrize("what", WRONG)
def test_a_trial_that_is_none_of_ours_is_refused_with_its_place(what: str) -> None:
    changes, message = WRONG[what]
    with pytest.raises(FileFormatError, match=message):
        check_trials([made(**changes)], SPACE, "study")


def told(spec: StudySpec, **changes: Any) -> None:
    """Change what a study says of itself."""
    begin(spec)
    study = optuna.load_study(study_name="study", storage=open_storage(spec.folder))
    study.set_user_attr("spec", {**study.user_attrs["spec"], **changes})


def test_nothing_but_our_errors_comes_of_settings_of_other_kinds(
    spec: StudySpec, swaps: tuple[Any, ...]
) -> None:
    values = spec.values()
    refused = 0
    for name, value in [*values.items(), ("another", 1)]:
        for other in swaps:
            if other == value:
                continue
            told(spec, **{name: other})
            with pytest.raises(HexWarError):
                known_spec(spec.folder)
            refused += 1
        if name in values:
            told(spec, **{name: value})
    assert refused > 50


def test_common_settings_of_other_kinds_are_refused(spec: StudySpec) -> None:
    for change in (
        {"seed": "x"},
        {"seed": -1},
        {"panel": "MA1"},
        {"trainings": True},
        {"trainings": 0},
        {"colour": 1},
    ):
        told(spec, common={**spec.values()["common"], **change})
        with pytest.raises(HexWarError):
            known_spec(spec.folder)


def test_a_study_of_an_earlier_version_is_refused_with_its_place(spec: StudySpec) -> None:
    """One that judged a point by one training, with reports within it."""
    common = {**spec.values()["common"], "reports": 5, "report_games": 40}
    del common["trainings"]
    told(spec, pruner="median", common=common)
    with pytest.raises(FileFormatError) as error:
        known_spec(spec.folder)

    assert (error.value.path, error.value.place) == (str(spec.folder), "common.reports")
    assert error.value.found == "an unknown setting"
    assert "trainings" in error.value.expected


def test_a_strangers_text_does_not_steer_the_terminal(spec: StudySpec) -> None:
    begin(spec)
    study = optuna.load_study(study_name="study", storage=open_storage(spec.folder))
    study.set_user_attr("meaning", {**study.user_attrs["meaning"], "scenario": "\x1b[2J"})

    with pytest.raises(ConfigError, match=r"another study: scenario \\x1b\[2J, not plain") as error:
        begin(spec)
    assert str(error.value).isprintable()


def test_a_study_names_no_file_of_ours(spec: StudySpec, tmp_path: Path) -> None:
    told(spec, preset=str(tmp_path / "elsewhere.json"))
    with pytest.raises(FileFormatError, match=r"spec\.preset"):
        known_spec(spec.folder)


def test_a_study_of_two_objectives_is_refused(spec: StudySpec) -> None:
    optuna.create_study(
        study_name="study", storage=open_storage(spec.folder), directions=["maximize", "maximize"]
    )
    for opens in (lambda: known_spec(spec.folder), lambda: begin(replace(spec))):
        with pytest.raises(HexWarError):
            opens()
