"""Opponents of a training as they are written."""

from __future__ import annotations

import pytest

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.evaluation import opponents
from hexwar_sb3.evaluation.opponents import broad_mixture, named, with_weights
from hexwar_sb3.rules import default_rules


def test_a_weight_stands_after_the_name() -> None:
    assert with_weights(["MA1=3", "drawn:7=0.5", "runs/a=b", "self=2e0", "nearest=0"]) == {
        "MA1": 3.0,
        "drawn:7": 0.5,
        "runs/a=b": 1.0,
        "self": 2.0,
        "nearest": 0.0,
    }
    assert named(["MA1=3", "self", "drawn"]) == ["MA1", "drawn"]


def test_the_broad_mixture_has_the_trained_policy_where_it_fits() -> None:
    assert broad_mixture("hills@3") == broad_mixture("plain")
    assert with_weights(broad_mixture("plain"))["HRL0"] == 2.0


@pytest.mark.parametrize(
    ("opponents", "message"),
    [
        ([], "at least one opponent with a weight above 0"),
        (["MA1=0"], "at least one opponent with a weight above 0"),
        (["MA1", "MA1=2"], "named once, got 'MA1' again"),
        (["MA1=1.2.3"], "NAME or NAME=WEIGHT, got 'MA1=1.2.3'"),
        (["MA1=1e999"], "NAME or NAME=WEIGHT"),
    ],
)
def test_what_is_wrong_is_said(opponents: list[str], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        with_weights(opponents)


def test_under_other_rules_the_trained_policy_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Who changes a rule can still train: HRL0 is refused where it is named."""
    opponents._knows_the_rules.cache_clear()
    monkeypatch.setattr(opponents, "default_rules", lambda: default_rules().with_numbers(hide_ticks=60))
    try:
        assert broad_mixture("plain") == opponents.OPPONENTS
    finally:
        opponents._knows_the_rules.cache_clear()
