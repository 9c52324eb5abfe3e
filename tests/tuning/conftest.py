"""The smallest study that there is: a few games a trial."""

from __future__ import annotations

from pathlib import Path

import pytest
from optuna.trial import TrialState

from hexwar_sb3.tuning.objective import Common
from hexwar_sb3.tuning.study import StudySpec, run_study

SMALL = Common(
    opponents=("MA1",),
    panel=("MA1",),
    lower_ticks=60_000,
    upper_ticks=108_000,
    trainings=2,
    final_games=2,
)


@pytest.fixture
def spec(tmp_path: Path) -> StudySpec:
    return StudySpec(folder=tmp_path / "small", common=SMALL, sampler="random", pruner="none")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests that look at the finished study run in one process, so that it is made once."""
    for item in items:
        if "finished" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.xdist_group("finished study"))


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> StudySpec:
    """Three trials, none of them pruned."""
    folder = tmp_path_factory.mktemp("studies") / "finished"
    spec = StudySpec(folder=folder, common=SMALL, sampler="random", pruner="none")
    study = run_study(spec, 3, say=lambda _: None)
    assert [one.state for one in study.trials] == [TrialState.COMPLETE] * 3
    return spec
