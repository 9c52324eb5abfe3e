"""Information: two games that differ only in what red cannot see have the same page for red, byte for byte."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.viewer import camp_story
from hexwar_sb3.viewer.page import replay_page

DIRECTIONS = ("W", "E", "NE", "SE", "NW", "SW")
Plan = list[tuple[int, str]]  # blue: tick, direction of tank1


def played(seed: int, blue: Plan, *, blood: int = 3, hides: bool = False) -> Replay:
    """Red walks and hides at home; blue, far out of sight, does something or other."""
    game = Game("plain", seed=seed)
    game.submit("red", ["tank0 move E E", "aerocraft0 move E E E", "tank1 hide"], strict=False)
    with game.edit() as state:
        state["blue:tank1"].blood = blood
    for tick, direction in sorted(blue):
        game.advance(max(0, tick - game.tick))
        game.submit("blue", f"tank1 move {direction}", strict=False)
    if hides:
        game.submit("blue", "tank0 hide")
    game.advance(160 - game.tick)
    return Replay.of(game)


def page_of(replay: Replay) -> str:
    return replay_page(replay, "red")


PLANS = st.lists(st.tuples(st.integers(1, 140), st.sampled_from(DIRECTIONS)), max_size=6)


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**63), blue=PLANS, blood=st.integers(1, 3), hides=st.booleans())
def test_reds_page_is_the_same_whatever_it_cannot_see(seed: int, blue: Plan, blood: int, hides: bool) -> None:
    assert page_of(played(seed, blue, blood=blood, hides=hides)) == page_of(played(1, []))


def true_margin(game: Game, _: Any, told: dict[str, Any]) -> None:
    told.setdefault("extra", []).append(game.margin("red"))


def hidden_length(_: Game, events: Any, told: dict[str, Any]) -> None:
    told.setdefault("extra", []).extend([0] * sum(event.kind != "arrived" for event in events))


def seed_of_the_dice(game: Game, _: Any, told: dict[str, Any]) -> None:
    told["extra"] = game.seed


@pytest.mark.parametrize("leak", [true_margin, hidden_length, seed_of_the_dice])
def test_a_planted_leak_is_found(leak: Callable[..., None], monkeypatch: pytest.MonkeyPatch) -> None:
    look, document = camp_story.CampTeller.look, camp_story.CampTeller.document
    told: dict[int, dict[str, Any]] = {}

    def looks(self: Any, game: Game, events: Any) -> bool:
        new = look(self, game, events)
        leak(game, events, told.setdefault(id(self), {}))
        return new

    monkeypatch.setattr(camp_story.CampTeller, "look", looks)
    monkeypatch.setattr(
        camp_story.CampTeller, "document", lambda self, lines: document(self, lines) | told[id(self)]
    )

    assert page_of(played(2, [(9, "W")], blood=2, hides=True)) != page_of(played(1, []))


def test_an_event_of_an_unseen_piece_would_be_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(camp_story, "is_known", lambda *_: True)

    assert page_of(played(1, [], hides=True)) != page_of(played(1, []))
