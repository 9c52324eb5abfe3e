"""Studies: trials in processes, the same again from the same seed; who is killed comes again."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, NoReturn

import optuna
import pytest
from optuna.trial import TrialState

from hexwar_sb3.algorithms.preset_file import load_preset, save_preset
from hexwar_sb3.algorithms.presets import PRESETS
from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.tuning.objective import Common
from hexwar_sb3.tuning.study import StudySpec, begin, known_spec, run_study
from hexwar_sb3.tuning.workers import AGAIN, WORKER, bury, ended


def shape(study: optuna.Study) -> list[tuple[dict[str, Any], float | None]]:
    return [(one.params, one.value) for one in study.trials]


def test_the_papers_point_comes_first(finished: StudySpec) -> None:
    trials = begin(finished).trials

    assert trials[0].params == {"alpha": 0.01, "beta": 0.05, "decision_ticks": 75}
    assert [one.state for one in trials] == [TrialState.COMPLETE] * 3
    assert len({one.params["alpha"] for one in trials}) == 3


def test_a_trial_leaves_its_preset_and_policies_as_artifacts(finished: StudySpec, tmp_path: Path) -> None:
    study = begin(finished)
    for trial in study.trials:
        for seed in ("0", "1"):
            policy = FrozenPolicy.load(finished.policies(trial.number) / seed)
            assert policy.about["decision_ticks"] == str(trial.params["decision_ticks"])
            assert policy.about["seed"] == seed
        artifacts = optuna.artifacts.get_all_artifact_meta(trial, storage=study._storage)
        of_name = {one.filename: one.artifact_id for one in artifacts}
        assert sorted(of_name) == ["policies.zip", "preset.json"]
        packed = finished.folder / "artifacts" / of_name["policies.zip"]
        shutil.unpack_archive(packed, tmp_path / str(trial.number), "zip")
        assert sorted(path.name for path in (tmp_path / str(trial.number)).iterdir()) == ["0", "1"]


def test_a_study_that_goes_on_is_the_unbroken_one(finished: StudySpec, spec: StudySpec) -> None:
    """The same seed and one worker: the same trials."""
    run_study(spec, 1, say=lambda _: None)
    run_study(spec, 2, say=lambda _: None)

    assert shape(begin(spec)) == shape(begin(finished))[:2]


def test_a_finished_study_is_left_alone(finished: StudySpec) -> None:
    before = shape(begin(finished))
    run_study(finished, 3, say=lambda _: None)

    assert shape(begin(finished)) == before


def test_a_study_says_what_it_was_begun_with(finished: StudySpec) -> None:
    assert known_spec(finished.folder) == finished


def test_points_of_ones_own_come_after_the_papers(spec: StudySpec) -> None:
    points = [{"alpha": 1.0, "beta": 0.5}, {"decision_ticks": 300}]
    begin(spec, points)
    study = begin(spec, points)  # once each

    waiting = [one.system_attrs["fixed_params"] for one in study.trials]
    assert waiting == [{"alpha": 0.01, "beta": 0.05, "decision_ticks": 75}, *points]


def test_a_study_goes_on_with_another_sampler_and_pruner(spec: StudySpec) -> None:
    begin(spec)
    begin(replace(spec, sampler="qmc", pruner="halving"))

    assert known_spec(spec.folder) == replace(spec, sampler="qmc", pruner="halving")


OTHERS: dict[str, tuple[Callable[[StudySpec], StudySpec], str]] = {
    "space": (lambda spec: replace(spec, also=("mixer",)), r"holds another study: space\.mixer nothing, not"),
    "preset": (lambda spec: replace(spec, preset="paper"), r"holds another study: preset\.n_envs 32, not 16"),
    "budget": (
        lambda spec: replace(spec, common=replace(spec.common, upper_ticks=72_000)),
        "holds another study: upper_ticks 108000, not 72000",
    ),
    "seeds": (
        lambda spec: replace(spec, common=replace(spec.common, trainings=3)),
        "holds another study: trainings 2, not 3",
    ),
}


@pytest.mark.parametrize("what", OTHERS)
def test_a_study_of_another_kind_is_not_gone_on_with(what: str, finished: StudySpec) -> None:
    change, message = OTHERS[what]
    with pytest.raises(ConfigError, match=message):
        begin(change(finished))


def wait_until(condition: Callable[[], bool], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


def test_a_killed_trial_comes_again_and_none_is_stuck(spec: StudySpec) -> None:
    """One of two workers dies in mid-trial."""
    study, killed = begin(spec), list[int]()

    def kill_one() -> None:
        def claimed() -> list[optuna.trial.FrozenTrial]:
            running = study.get_trials(states=(TrialState.RUNNING,))
            return [one for one in running if WORKER in one.user_attrs and len(one.params) == 3]

        wait_until(lambda: bool(claimed()))
        victim = claimed()[0]
        killed.append(victim.number)
        os.kill(victim.user_attrs[WORKER]["pid"], signal.SIGKILL)

    thread = threading.Thread(target=kill_one)
    thread.start()
    run_study(spec, 2, workers=2, say=lambda _: None)
    thread.join()

    trials = begin(spec).trials
    states = [one.state for one in trials]
    assert states.count(TrialState.COMPLETE) == ended(trials) == 2
    assert states.count(TrialState.FAIL) == 1
    assert len(trials) == 3
    again = [one for one in trials if AGAIN in one.user_attrs]
    assert [one.user_attrs[AGAIN] for one in again] == killed
    assert again[0].params == trials[killed[0]].params


def test_who_stops_a_study_leaves_no_process_and_goes_on_later(spec: StudySpec) -> None:
    """SIGTERM is what Ctrl-C is."""
    study = begin(spec)
    command = [sys.executable, "-m", "hexwar_sb3.cli", "tune", "run", str(spec.folder), *flags(spec)]

    def worked_on() -> list[optuna.trial.FrozenTrial]:
        running = study.get_trials(states=(TrialState.RUNNING,))
        return [one for one in running if WORKER in one.user_attrs]

    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        wait_until(lambda: bool(worked_on()))
        worker = worked_on()[0].user_attrs[WORKER]["pid"]
        process.send_signal(signal.SIGTERM)
        _, said = process.communicate(timeout=30)

    assert process.returncode == 130
    assert "the same command goes on" in said
    assert "Traceback" not in said
    with pytest.raises(ProcessLookupError):
        os.kill(worker, 0)
    assert [one.state for one in begin(spec).trials] == [TrialState.FAIL, TrialState.WAITING]


def flags(spec: StudySpec) -> list[str]:
    """Flags of `hexwar tune run` for a study."""
    settings = {**asdict(spec.common), "sampler": spec.sampler, "pruner": spec.pruner, "n_trials": 1}
    found: list[str] = []
    for name, value in settings.items():
        values = value if isinstance(value, tuple) else (value,)
        found += [f"--{name.replace('_', '-')}", *map(str, values)]
    return found


def test_a_trial_of_a_process_that_is_gone_comes_again(spec: StudySpec) -> None:
    """As a machine leaves it that went down: parent and worker are gone."""
    study = begin(spec)
    trial = study.ask()
    trial.set_user_attr(WORKER, {"host": os.uname().nodename, "pid": 2**22 - 1})
    run_study(spec, 1, say=lambda _: None)

    dead, again = begin(spec).trials
    assert (dead.state, again.state) == (TrialState.FAIL, TrialState.COMPLETE)
    assert again.params == {
        "alpha": 0.01,
        "beta": 0.05,
        "decision_ticks": 75,
    }  # the paper's, which was in line


def test_a_point_that_dies_twice_counts_as_failed(spec: StudySpec) -> None:
    study = begin(spec)
    for _ in range(2):
        study.ask().set_user_attr(WORKER, {"host": os.uname().nodename, "pid": 2**22 - 1})
        bury(study, spec.lock)

    assert [one.state for one in study.trials] == [TrialState.FAIL] * 2
    assert ended(study.trials) == 1


def test_another_process_that_is_faster_does_not_hurt(
    spec: StudySpec, monkeypatch: pytest.MonkeyPatch
) -> None:
    study = begin(spec)
    study.ask().set_user_attr(WORKER, {"host": os.uname().nodename, "pid": 2**22 - 1})

    def too_late(*_: Any, **__: Any) -> NoReturn:
        raise optuna.exceptions.UpdateFinishedTrialError

    monkeypatch.setattr(study, "tell", too_late)
    bury(study, spec.lock)

    assert len(study.trials) == 1  # who was faster puts it in line


def test_processes_that_never_get_a_trial_end_the_study(
    spec: StudySpec, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(ConfigError, match="3 processes ended before they had a trial"):
        run_study(spec, 1, say=lambda _: None)


def test_a_study_keeps_its_preset_and_may_be_moved(spec: StudySpec, tmp_path: Path) -> None:
    mine = tmp_path / "mine.json"
    save_preset(mine, PRESETS["default"].changed({"gamma": 0.9}), {})
    begin(replace(spec, preset=str(mine)))
    mine.unlink()
    spec.folder.rename(tmp_path / "elsewhere")
    moved = known_spec(tmp_path / "elsewhere")

    assert load_preset(moved.preset).learner["gamma"] == 0.9
    begin(moved)
    other = load_preset(moved.preset).changed({"gamma": 0.8})
    save_preset(mine, other, {})
    with pytest.raises(ConfigError, match=r"preset\.learner\.gamma 0\.9, not 0\.8"):
        begin(replace(moved, preset=str(mine)))


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "sampler": ({"sampler": "tpr"}, "unknown sampler 'tpr'; did you mean 'tpe'"),
    "pruner": ({"pruner": "mean"}, "unknown pruner 'mean'"),
    "a value of the preset that is not searched": (
        {"preset": "paper", "also": ("learning_rate",)},
        r"learning_rate must be a number in 0\.0001\.\.0\.01, got 0\.1",
    ),
    "setting": ({"also": ("widths",)}, "unknown setting 'widths'"),
    "preset": ({"preset": "fast"}, "unknown preset 'fast'"),
    "panel": ({"common": Common(panel=("MA9",))}, "unknown player 'MA9'"),
    "opponent with a weight": ({"common": Common(opponents=("MA9=2",))}, "unknown player 'MA9'"),
    "itself as an opponent": ({"common": Common(opponents=("MA1", "self"))}, "unknown player 'self'"),
    "hot spots, and a policy among the opponents": (
        {"also": ("spots",), "common": Common(panel=("MA1",))},
        "opponents: HRL0 knows the hot spots of its training alone: leave it or spots out",
    ),
    "hot spots, and a policy in the panel": (
        {"also": ("spots",), "common": Common(opponents=("MA1=2", "drawn"))},
        "panel: HRL0 knows the hot spots of its training alone: leave it or spots out",
    ),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_name_is_met_before_anything_begins(what: str, tmp_path: Path) -> None:
    settings, message = WRONG[what]
    with pytest.raises((UnknownNameError, ConfigError), match=message):
        StudySpec(folder=tmp_path / "none", **settings)
    assert not (tmp_path / "none").exists()
