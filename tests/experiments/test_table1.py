"""Table I: bars, cells and paired differences from matches that can be counted by hand; the pipeline at its smallest."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.commands.output import table as lay_out
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.evaluation.panel import CONSTANT_PLANS
from hexwar_sb3.evaluation.tournament import Meeting, Table
from hexwar_sb3.experiments.kept import Record
from hexwar_sb3.experiments.runs import Places
from hexwar_sb3.experiments.table1 import BROAD, COLUMNS, FURTHER, ROWS, Table1
from hexwar_sb3.experiments.table1_page import PAPER, bar, in_words, missed, no_worse, rows, write
from hexwar_sb3.league.cai import DISTILLED, make_cai
from hexwar_sb3.league.distil import Lessons
from hexwar_sb3.league.league import League
from hexwar_sb3.league.member import as_member
from hexwar_sb3.league.selection import Standing
from hexwar_sb3.league.settings import LeagueSettings
from hexwar_sb3.players.frozen import FrozenPolicy
from tests.experiments.conftest import page_rows

WINS = {
    "HRL0": 2,
    "HRL1": 3,
    "HRL2": 3,
    "CAI": 4,
    DISTILLED: 1,
    BROAD: 2,
}  # of 4 games as red; as blue the same
"""What each row's player reaches against anybody in the tests."""


def camp(wins: int) -> dict[str, Any]:
    return {
        "games": 4,
        "wins": wins,
        "draws": 0,
        "losses": 4 - wins,
        "win_rate": wins / 4,
        "win_rate_interval": [0.0, 1.0],
        "mean_margin": 10.0 * wins,
        "mean_margin_interval": [0.0, 100.0],
        "points_held": [0.5, 0.0, 0.5],
    }


def counted() -> Table:
    """Every row has its wins in both colours against every column."""
    found: dict[Meeting, dict[str, Any]] = {}
    for name in (*ROWS, *FURTHER, *CONSTANT_PLANS):
        wins = WINS.get(name, 0)
        for column in COLUMNS:
            letters = "W" * wins + "L" * (4 - wins)
            as_red = Meeting(red=name, blue=column, scenario="plain")
            as_blue = Meeting(red=column, blue=name, scenario="plain")
            found[as_red] = {"red": camp(wins), "blue": camp(4 - wins), "red_games": letters}
            swapped = letters.translate(str.maketrans("WL", "LW"))
            found[as_blue] = {"red": camp(4 - wins), "blue": camp(wins), "red_games": swapped}
    return Table(found)


def small(folder: Path, **settings: Any) -> Table1:
    """A pipeline of a minute, whose warm-ups are there."""
    places = Places(folder / "results", folder / "work")
    made = Table1(
        places=places,
        seeds=(0, 1),
        settings=LeagueSettings(
            keep=2, iterations=1, games=4, fill_games=1, refit_games=1, match_games=2, warm_up_games=2, n_envs=2, opponents=("MA1", "drawn"),
            learner={"learning_starts": 0, "buffer_size": 200, "batch_size": 8}, **settings,
        ),
        lessons=Lessons(games=2, updates=5, batch_size=8),
        cai_games=4,
        games=2,
        progress_games=2,
    )  # fmt: skip
    env = make_vec_env(n_envs=1, privileged_state=True, seed=0)
    for run in (*made.warm_ups(), *made.starters()):
        model = QMIX("TaskPolicy", env, seed=run.seed, buffer_size=10)
        kept, policy = places.kept(run), folder / run.name
        as_member(model, side="both", scenario="plain").save(policy)
        kept.put(
            Record(
                command=run.command, config={}, page={"minutes": 1.0, "rows": page_rows(0.1 * run.seed, 0.0)}
            ),
            [],
            policy,
        )
    return made


@pytest.fixture
def pipeline(tmp_path: Path) -> Table1:
    """A pipeline of models for both camps."""
    return small(tmp_path)


def test_a_league_of_two_colours_has_a_cai_of_each(tmp_path: Path) -> None:
    made = small(tmp_path, split=True)
    assert made.run(lambda _: None) is not None
    policies = {camp: FrozenPolicy.load(made.policy("CAI", camp)) for camp in ("red", "blue")}

    assert {camp: policy.about["side"] for camp, policy in policies.items()} == {"red": "red", "blue": "blue"}
    assert not made.policy("CAI", "both").exists()


def test_the_pipeline_goes_from_warm_ups_to_the_table(pipeline: Table1) -> None:
    said: list[str] = []
    table = pipeline.run(said.append)
    assert table is not None
    _, text = write(table, pipeline, lay_out)
    figures = json.loads((pipeline.kept / "table.json").read_text())

    assert len(table.rows) == len(pipeline.meetings())
    assert {(cell["row"], cell["games"]) for cell in figures["cells"]} == {
        (name, 2) for name in (*ROWS, *FURTHER, *CONSTANT_PLANS)
    }
    assert (pipeline.kept / "table.txt").read_text() == text + "\n"
    assert {"groups", "round robin", "CAI", "matches", "progress"} <= set(figures["costs"])
    assert pipeline.states()["iterations of the league"] == "1 of 1"
    assert said[-1] == "matches of the table"
    assert (pipeline.kept / "league.png").stat().st_size > 10_000
    assert (pipeline.kept / "league" / "iteration_01" / "table.json").exists()
    assert not list((pipeline.kept / "league").glob("*/groups"))  # small files only


def test_cai_is_a_function_of_its_spec(pipeline: Table1, tmp_path: Path) -> None:
    pipeline.run(lambda _: None)
    cai = FrozenPolicy.load(pipeline.policy("CAI", "both")).sha256
    specs = {
        FrozenPolicy.load(one.folder / "learned").sha256: one for one in pipeline.combined(pipeline.league())
    }
    spec = specs[cai]  # the better of two
    make_cai(replace(spec, folder=tmp_path / "again"))

    for name in ("distilled", "learned"):
        policies = [FrozenPolicy.load(folder / name) for folder in (spec.folder, tmp_path / "again")]
        assert policies[0].sha256 == policies[1].sha256
    assert (len(specs), policies[0].sha256) == (2, cai)
    assert policies[0].about["side"] == "both"
    assert sum(weight for _, weight in spec.opponents) == pytest.approx(1.0)


def test_cai_is_the_student_that_does_best(pipeline: Table1, monkeypatch: pytest.MonkeyPatch) -> None:
    def second_wins(
        self: League, models: Mapping[str, Mapping[str, object]], k: int, folder: Path, jobs: int = 1
    ) -> dict[str, list[Standing]]:
        if k == 0:
            return rank(self, models, k, folder, jobs)
        assert (k, [list(own) for own in models.values()]) == (2, 2 * [["both-0", "both-1"]])
        rows = [
            {"name": name, "score": rate, "mean_margin": 0.0}
            for name, rate in (("both-0", 0.4), ("both-1", 0.6))
        ]
        return {"red": rows, "blue": rows}

    rank = League.rank
    monkeypatch.setattr(League, "rank", second_wins)
    pipeline.run(lambda _: None)

    second = pipeline.work / "cai" / "both-1" / "learned"
    assert FrozenPolicy.load(pipeline.policy("CAI", "both")).sha256 == FrozenPolicy.load(second).sha256


def test_a_copy_that_was_broken_off_is_not_taken_for_whole(
    pipeline: Table1, monkeypatch: pytest.MonkeyPatch
) -> None:
    pipeline.run(lambda _: None)
    for folder in (pipeline.work, pipeline.kept / "policies"):
        shutil.rmtree(folder)

    def killed(source: Path, made: Path, **_: object) -> None:
        shutil.copyfile(next(source.rglob("*.json")), made / "half.json")
        raise KeyboardInterrupt

    monkeypatch.setattr(shutil, "copytree", killed)
    with pytest.raises(KeyboardInterrupt):
        pipeline.league()

    assert not pipeline.work.joinpath("league").exists()


def test_what_is_committed_is_enough_to_go_on(pipeline: Table1) -> None:
    pipeline.run(lambda _: None)
    shutil.rmtree(pipeline.work)
    matches = json.loads(pipeline.matches.read_text())
    some = {name: row for name, row in matches.items() if "CAI" not in name}
    pipeline.matches.write_text(json.dumps(some))
    policies = {path: path.read_bytes() for path in pipeline.kept.rglob("weights.safetensors")}
    pipeline.run(lambda _: None)

    assert not (pipeline.work / "cai").exists()
    assert policies == {path: path.read_bytes() for path in pipeline.kept.rglob("weights.safetensors")}
    assert json.loads(pipeline.matches.read_text()) == matches
    assert 0 < len(some) < len(matches)
    assert pipeline.states()["matches"] == f"{len(pipeline.meetings())} of {len(pipeline.meetings())}"


def test_bars_are_the_papers_cells_that_are_judged() -> None:
    assert bar("HRL1", "HRL0", 0) == 0.77
    assert bar("HRL1", "HRL0", 1) == 0.80
    assert bar("CAI", "MA1", 0) == 0.99
    assert bar("CAI", "HRL1", 1) == 0.64
    assert bar("HRL0", "HRL0", 0) is None
    assert bar("HRL2", "HRL1", 0) is None
    assert bar("HRL1", "nearest", 0) is None


def test_a_cell_is_the_row_players_own_camp() -> None:
    cells = rows(counted(), "plain")
    cai = [cell for cell in cells if cell["row"] == "CAI" and cell["column"] == "MA2"]

    assert [(cell["camp"], cell["win_rate"], cell["paper"]) for cell in cai] == [
        ("red", 1.0, 0.99),
        ("blue", 1.0, 0.95),
    ]
    assert {(cell["row"], cell["column"]) for cell in cells} >= set(PAPER)


def test_what_misses_its_bar_is_listed() -> None:
    below = list(missed(rows(counted(), "plain")))

    assert "HRL0 against MA1 as red: 50.0 % [0.0, 100.0], bar 94" in below
    assert not any(line.startswith("CAI") for line in below)


def test_differences_are_paired_game_by_game() -> None:
    found = {(one["player"], one["minus"], one["against"]): one for one in no_worse(counted(), "plain")}

    assert found["CAI", "HRL0", "MA1"]["points"] == 50.0
    assert found["HRL1", "HRL0", "MA1"]["points"] == 25.0
    assert found["CAI", "HRL0", "MA1"]["no_worse"]
    assert not found[DISTILLED, "HRL1", "all columns"]["no_worse"]


def test_the_page_shows_every_row() -> None:
    table = counted()
    costs = {"warm-ups": {"wall_s": 120.0, "core_s": 120.0}, "matches": {"wall_s": 60.0, "core_s": 360.0}}
    text = in_words(rows(table, "plain"), no_worse(table, "plain"), costs, lay_out)

    for name in (*ROWS, *FURTHER, *CONSTANT_PLANS):
        assert f"\n{name} " in text
    assert "97 / 96" in text
    assert ["matches", "1.0", "6.0", "75", "%"] in [line.split() for line in text.splitlines()]
    assert ["all", "3.0", "8.0", "100", "%"] in [line.split() for line in text.splitlines()]
