"""Files of strangers: whatever lies in one, no code runs, nothing dies or takes long, and nothing false is taken."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from tests.attack.loaders import LOADERS
from tests.attack.run import PER_LOADER, Outcome, attacked, make_valid, table

QUICK, ALL = 5, 1_500  # files a loader in the fast tests, files in all in the slow one


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The valid files."""
    return make_valid(tmp_path_factory.mktemp("valid") / "root")


def check(outcomes: list[Outcome]) -> None:
    faults = "\n".join(str(one) for one in outcomes if one.faults)
    assert not faults, f"{table(outcomes)}\n{faults}"


def test_a_hundred_bad_files_do_no_harm(root: Path) -> None:
    outcomes = attacked(root, list(LOADERS), QUICK)

    assert len(outcomes) >= 100
    check(outcomes)


@pytest.mark.slow
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("name", LOADERS)
def test_bad_files_do_no_harm(root: Path, name: str) -> None:
    outcomes = attacked(root, [name], PER_LOADER)

    assert len(outcomes) * len(LOADERS) >= ALL
    check(outcomes)
