"""Finalists: the study's own policies where it has them, others trained; the same fresh games for both points."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from statistics import fmean
from typing import Any

import pytest

from hexwar_sb3.algorithms.preset_file import load_preset
from hexwar_sb3.cli import main
from hexwar_sb3.evaluation.panel import play_panel
from hexwar_sb3.evaluation.seeds import Purpose
from hexwar_sb3.folders import LOCK
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.tuning.final import compare
from hexwar_sb3.tuning.store import JOURNAL
from hexwar_sb3.tuning.study import StudySpec, begin, best_trial, known_spec


def test_best_and_paper_meet_the_panel_on_the_same_games(finished: StudySpec) -> None:
    """Seed 1 is one of the study's own, seed 2 is not."""
    found = compare(finished, games=3, seeds=(1, 2), workers=2)
    best = f"trial {best_trial(begin(finished)).number}"

    assert list(found["points"]) == [best, "paper"]
    assert found["points"]["paper"] == {"alpha": 0.01, "beta": 0.05, "decision_ticks": 75}
    assert [(row["player"], row["camp"], row["games"]) for row in found["rows"]] == [
        (f"{name}, seed {seed}", camp, 3)
        for seed in (1, 2)
        for name in (best, "paper")
        for camp in ("red", "blue")
    ]
    margin = margins(found)
    differences = found["minus_paper"][best]
    by_seed = [differences[f"seed {seed}"]["margin"]["value"] for seed in (1, 2)]
    assert by_seed == pytest.approx(
        [margin[f"{best}, seed {seed}"] - margin[f"paper, seed {seed}"] for seed in (1, 2)]
    )
    assert differences["all"]["margin"]["value"] == pytest.approx(sum(by_seed) / 2)
    low, high = differences["trainings"]["margin"]["interval"]
    half = 12.7062 * abs(by_seed[0] - by_seed[1]) / 2  # Student's quantile of one degree of freedom
    assert (low, high) == pytest.approx((sum(by_seed) / 2 - half, sum(by_seed) / 2 + half), rel=1e-4)
    trained = sorted(path.name for path in (finished.folder / "finalists").iterdir() if path.name != LOCK)
    assert len(trained) == len({str(point) for point in found["points"].values()})
    assert all(name.endswith("-seed2") for name in trained)


def test_a_policy_of_the_study_is_that_of_its_point_and_seed(finished: StudySpec) -> None:
    margin = margins(compare(finished, games=2, seeds=finished.common.seeds, trials=(1,)))

    for seed in finished.common.seeds:
        preset = load_preset("default").changed(begin(finished).trials[1].params)
        how = replace(finished.common.evaluation(preset, 2, seed), purpose=Purpose.REPORT)
        own = FrozenPolicy.load(finished.policies(1) / str(seed))
        panel = play_panel(own, finished.common.panel, how, name="own")
        assert margin[f"trial 1, seed {seed}"] == pytest.approx(panel.total.mean_margin.value)


def test_points_are_compared_by_seeds_that_did_not_choose_them(
    finished: StudySpec, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "fresh"
    shutil.copytree(finished.folder, folder, ignore=shutil.ignore_patterns("finalists"))
    found = compare(known_spec(folder), games=2, trials=(0,))

    assert found["seeds"] == {"compared": [2, 3], "study": [0, 1]}
    assert [row["player"] for row in found["rows"][::2]] == [
        f"{name}, seed {seed}" for seed in (2, 3) for name in ("trial 0", "paper")
    ]
    assert {path.name[-6:] for path in (folder / "finalists").glob("*-seed*")} == {"-seed2", "-seed3"}
    for seeds, said in (
        ((), "trainings with the seeds 2, 3; the study chose by 0, 1: these are fresh"),
        ((2, 1), "trainings with the seeds 2, 1; the study chose by 0, 1: of these 1 chose too"),
    ):
        flags = ("--games", "2", "--trials", "0", *(("--seeds", *map(str, seeds)) if seeds else ()))
        with pytest.raises(SystemExit) as stopped:
            main(("tune", "compare", str(folder), *flags))
        assert stopped.value.code == 0
        assert said in capsys.readouterr().out.splitlines()


@pytest.mark.parametrize("seed", ["-1", "1000000"])
def test_a_seed_that_is_none_trains_nothing(
    seed: str, finished: StudySpec, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(("tune", "compare", str(finished.folder), "--seeds", "1", seed))

    assert stopped.value.code == 2
    assert f"seed must be in 0..999999, got {seed}" in capsys.readouterr().err


def margins(found: dict[str, Any]) -> dict[str, float]:
    """Mean margin of each finalist over both colours."""
    mean: dict[str, float] = {}
    for row in found["rows"]:
        mean[row["player"]] = mean.get(row["player"], 0.0) + row["mean_margin"] / 2
    return mean


def test_several_trials_meet_the_papers_point(finished: StudySpec) -> None:
    found = compare(finished, games=2, seeds=(0,), trials=(2, 1, 2))
    margin = margins(found)

    assert list(found["points"]) == ["trial 2", "trial 1", "paper"]
    assert "trainings" not in found["minus_paper"]["trial 2"]  # one
    assert {
        name: one["all"]["margin"]["value"] for name, one in found["minus_paper"].items()
    } == pytest.approx(
        {name: margin[f"{name}, seed 0"] - margin["paper, seed 0"] for name in ("trial 2", "trial 1")}
    )


@pytest.mark.parametrize("action", ["compare", "export"])
def test_a_trial_that_was_not_completed_has_no_point_to_take(
    finished: StudySpec, action: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out.json"
    with pytest.raises(SystemExit) as stopped:
        main(("tune", action, str(finished.folder), "--trials", "7", "-o", str(out)))

    assert stopped.value.code == 2
    assert "trial 7 was not completed; these were: 0, 1, 2" in capsys.readouterr().err
    assert not out.exists()


def test_any_completed_trial_becomes_a_preset_but_not_two(
    finished: StudySpec, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for trial in begin(finished).get_trials():
        out = tmp_path / f"{trial.number}.json"
        with pytest.raises(SystemExit) as stopped:
            main(("tune", "export", str(finished.folder), "--trials", str(trial.number), "-o", str(out)))
        assert stopped.value.code == 0
        assert load_preset(str(out)) == load_preset("default").changed(trial.params)
    with pytest.raises(SystemExit) as stopped:
        main(("tune", "export", str(finished.folder), "--trials", "0", "1"))
    assert stopped.value.code == 2
    assert "the point of one trial, not of 2" in capsys.readouterr().err


@pytest.mark.parametrize("package", ["optuna", "filelock", "scipy"])
def test_without_the_extra_one_line_says_what_to_install(
    package: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(
        "hexwar_sb3.commands.tune.find_spec", lambda name: None if name == package else find_spec(name)
    )
    with pytest.raises(SystemExit) as stopped:
        main(("tune", "show"))

    assert stopped.value.code == 2
    assert f'tuning needs {package}: pip install "hexwar-sb3[tune]"' in capsys.readouterr().err


def test_who_looks_at_a_study_leaves_its_journal_as_it_is(
    finished: StudySpec, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    journal = finished.folder / JOURNAL
    before = journal.read_bytes()
    for action in (("show",), ("export", "-o", str(tmp_path / "mine.json"))):
        with pytest.raises(SystemExit) as stopped:
            main(("tune", action[0], str(finished.folder), *action[1:]))
        assert stopped.value.code == 0

    assert journal.read_bytes() == before
    said = capsys.readouterr().out
    assert "3 complete" in said
    for trial in begin(finished).trials:
        assert " ".join(f"{one:+.2f}" for one in trial.user_attrs["trainings"]) in said


def test_where_the_papers_point_is_the_best_it_is_trained_once(finished: StudySpec, tmp_path: Path) -> None:
    folder = tmp_path / "papers"
    shutil.copytree(finished.folder, folder)
    study = begin(known_spec(folder))
    for _ in range(2):
        study.enqueue_trial({"alpha": 0.01, "beta": 0.05, "decision_ticks": 75})
        trial = study.ask(fixed_distributions=finished.space)
        trial.set_user_attr("ticks", 1)
        study.tell(trial, 9.0)
    found = compare(known_spec(folder), games=2, seeds=(5, 5))

    (own,) = found["minus_paper"]
    assert found["points"][own] == found["points"]["paper"]
    assert found["minus_paper"][own]["all"]["margin"] == {"value": 0.0, "interval": [0.0, 0.0]}
    assert len(list((folder / "finalists").glob("*-seed5"))) == 1


def test_the_best_point_becomes_a_preset_of_train(
    finished: StudySpec, capsys: pytest.CaptureFixture[str]
) -> None:
    path = finished.folder / "mine.json"
    with pytest.raises(SystemExit) as stopped:
        main(("tune", "export", str(finished.folder), "-o", str(path), "--json"))
    said = json.loads(capsys.readouterr().out)
    best = best_trial(begin(finished))

    assert stopped.value.code == 0
    assert (said["trial"], said["point"]) == (best.number, best.params)
    with pytest.raises(SystemExit) as stopped:
        main(
            (
                *("train", "--preset", str(path), "--n-timesteps", "1200", "--final-games", "1"),
                *("--runs", str(finished.folder / "runs"), "--name", "tuned", "--no-constant-plans"),
            )
        )
    assert stopped.value.code == 0
    policy = FrozenPolicy.load(finished.folder / "runs" / "tuned_1" / "policy")
    assert policy.about["decision_ticks"] == str(best.params["decision_ticks"])


def test_the_studys_page_has_every_trial_and_picture(
    finished: StudySpec, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(("tune", "show", str(finished.folder), "--json"))
    said = json.loads(capsys.readouterr().out)

    assert stopped.value.code == 0
    assert [row["state"] for row in said["trials"]] == ["complete"] * 3
    assert said["paper"]["number"] == 0
    assert said["ticks"] == pytest.approx(said["ticks_without_pruning"], rel=0.05)
    for row in said["trials"]:
        assert row["value"] == fmean(row["trainings"])
        assert len(row["trainings"]) == 2
    for name in ("history", "slices", "race", "surface"):
        assert (finished.folder / f"{name}.png").stat().st_size > 5_000
