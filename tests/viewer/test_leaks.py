"""Information: two games that differ only in what red cannot see have the same page for red, byte for byte."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.viewer import camp_story, save_events, save_gif, save_moment
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


# --- the other files -----------------------------------------------------------------------------


def fought(hidden: str, blood: int = 3) -> Replay:
    """Red and a blue tank fire at each other; blue's soldier, far out of sight, does something or other."""
    game = Game.from_text("""
        map   plain-60x9
        point ford 3005 40
        red   tank 0204
        red   chariot 0205
        blue  tank 0704
        blue  soldier 5505
        seed  11
        ticks 400
    """)
    with game.edit() as state:
        state["blue:soldier0"].blood = blood
    game.submit("red", ["tank0 shoot blue:tank0 GUN", "chariot0 shoot blue:tank0 CANNON"], strict=False)
    game.submit("blue", [f"soldier0 {hidden}", "tank0 move E E E"], strict=False)
    game.advance(90)
    game.submit("red", ["tank0 shoot blue:tank0 GUN", "chariot0 move E"], strict=False)
    game.advance(60)
    return Replay.of(game)


WRITERS: dict[str, Callable[[Replay, Path], None]] = {
    "red.hwr": lambda replay, path: replay.for_camp("red").save(path),
    "events.csv": lambda replay, path: save_events(replay, path, "red"),
    "moment.png": lambda replay, path: save_moment(replay, path, 100, "red"),
    "moment.svg": lambda replay, path: save_moment(replay, path, 100, "red"),
    "game.gif": lambda replay, path: save_gif(replay, path, 80, 110, "red"),
}


@pytest.mark.parametrize("name", WRITERS)
def test_reds_files_are_the_same_whatever_it_cannot_see(name: str, tmp_path: Path) -> None:
    """Also in a fight: the dice of what red sees are thrown as before."""
    games = (fought("hide"), fought("move W W"), fought("move E", blood=1))
    for number, replay in enumerate(games):
        WRITERS[name](replay, tmp_path / str(number) / name)

    first, *others = [(tmp_path / str(number) / name).read_bytes() for number in range(len(games))]
    assert others == [first, first]
    assert any(event["kind"] == "shot" for event in games[0].for_camp("red").events)


@pytest.mark.parametrize("name", WRITERS)
def test_reds_files_tell_what_it_sees(name: str, tmp_path: Path) -> None:
    """Else their being equal would say little."""
    changed = fought("hide")
    game = changed.game_at(80)
    with game.edit() as state:
        state["blue:tank0"].blood = 1
    game.advance(70)
    for folder, replay in (("one", changed), ("other", Replay.of(game))):
        WRITERS[name](replay, tmp_path / folder / name)

    assert (tmp_path / "one" / name).read_bytes() != (tmp_path / "other" / name).read_bytes()
