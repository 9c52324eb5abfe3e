"""Finalists: the study's own policies where it has them, others trained; the same fresh games for both points."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from hexwar_sb3.cli import main
from hexwar_sb3.play.frozen import FrozenPolicy
from hexwar_sb3.tuning.final import compare
from hexwar_sb3.tuning.study import StudySpec, begin, best_trial, known_spec


def test_best_and_paper_meet_the_panel_on_the_same_games(finished: StudySpec) -> None:
    found = compare(finished, games=3, seeds=(0, 1), workers=2)

    assert found["points"]["paper"] == {"alpha": 0.01, "beta": 0.05, "decision_ticks": 75}
    assert found["trial"] == best_trial(begin(finished)).number
    assert [(row["player"], row["camp"], row["games"]) for row in found["rows"]] == [
        (player, camp, 3) for player in ("best 0", "paper 0", "best 1", "paper 1") for camp in ("red", "blue")
    ]
    margin = {row["player"]: 0.0 for row in found["rows"]}
    for row in found["rows"]:
        margin[row["player"]] += row["mean_margin"] / 2
    by_seed = [found["best_minus_paper"][f"seed {seed}"]["margin"]["value"] for seed in (0, 1)]
    assert by_seed == pytest.approx([margin[f"best {seed}"] - margin[f"paper {seed}"] for seed in (0, 1)])
    assert found["best_minus_paper"]["all"]["margin"]["value"] == pytest.approx(sum(by_seed) / 2)
    trained = sorted(path.name for path in (finished.folder / "finalists").iterdir())
    assert len(trained) == len({str(point) for point in found["points"].values()})  # seed 0 is the study's
    assert all(name.endswith("-seed1") for name in trained)


def test_where_the_papers_point_is_the_best_it_is_trained_once(finished: StudySpec, tmp_path: Path) -> None:
    folder = tmp_path / "papers"
    shutil.copytree(finished.folder, folder)
    study = begin(known_spec(folder))
    for _ in range(2):
        study.enqueue_trial({"alpha": 0.01, "beta": 0.05, "decision_ticks": 75})
        study.tell(study.ask(fixed_distributions=finished.space), 9.0)
    found = compare(known_spec(folder), games=2, seeds=(5, 5))

    assert found["points"]["best"] == found["points"]["paper"]
    assert found["best_minus_paper"]["all"]["margin"] == {"value": 0.0, "interval": [0.0, 0.0]}
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
    for name in ("history", "slices", "curves", "surface"):
        assert (finished.folder / f"{name}.png").stat().st_size > 5_000
