from __future__ import annotations

import json
from pathlib import Path

import pytest

from hexwar_sb3.algorithms.qmix import QMIX
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import PolicyFileError
from hexwar_sb3.evaluation.panel import Terms, trained_terms


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A policy that was trained in games of its own kind."""
    terms = Terms(scenario="hills@7", decision_ticks=150, spots=3, early=True)
    QMIX("TaskPolicy", make_vec_env(seed=0), buffer_size=10).policy.freeze(**terms.about()).save(tmp_path)
    return tmp_path


def test_a_policys_folder_says_how_it_was_trained(folder: Path) -> None:
    found = trained_terms(folder)

    assert found == {"scenario": "hills@7", "decision_ticks": 150, "spots": 3, "early": True}
    assert Terms(**found).about() == Terms(**trained_terms(folder)).about()


def test_a_bot_was_not_trained() -> None:
    assert trained_terms("MA1") == {"early": False}


@pytest.mark.parametrize("number", ["seventy", "-1", "1e9", "9" * 5000, ""])
def test_a_number_that_is_none_is_answered_with_its_place(folder: Path, number: str) -> None:
    config = json.loads((folder / "config.json").read_text(encoding="utf-8"))
    config["about"]["decision_ticks"] = number
    (folder / "config.json").write_text(json.dumps(config), encoding="utf-8")

    with pytest.raises(PolicyFileError, match=r"about\.decision_ticks: found .*; expected a whole number"):
        trained_terms(folder)
