"""Scenes: what films and pictures of a moment draw, for the referee and for each camp."""

from __future__ import annotations

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.orders import Move, Shoot
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.errors import UnknownNameError
from hexwar_sb3.viewer.scene import SHOT_TICKS, Token, fanned, scene_of, scenes


def test_the_referees_scene_has_every_living_piece_that_no_other_carries() -> None:
    game = Game("plain", seed=0)

    scene = scene_of(game)

    assert sorted(token.text for token in scene.tokens) == ["A1", "A1", *["C3"] * 4, *["T3"] * 4]
    assert scene.margins == {"red": game.margin("red"), "blue": game.margin("blue")}


def test_a_camps_scene_has_enemies_where_it_saw_them_last() -> None:
    game = Game.from_text("map plain-90x3\nred tank 0102\nblue tank 1802\nticks 1000")
    game.submit("blue", Move("tank0", ["E"] * 20))
    game.advance(400)

    scene = scene_of(game, "red")

    (ghost,) = [token for token in scene.tokens if token.camp == "blue"]
    assert (ghost.text, ghost.is_ghost) == ("T3", True)
    assert game.roster.cell_name(ghost.cell) == game.view("red").lost[0].cell
    assert scene.margins == {"red": game.view("red").known_margin}


def test_a_shot_is_seen_by_the_referee_for_some_ticks_and_by_no_camp() -> None:
    game = Game.from_text("map plain-20x3\nred tank 0102\nblue tank 0402\nticks 100")
    game.submit("red", Shoot("tank0", "tank0", "GUN"))
    game.advance(40)
    replay = Replay.of(game)

    shown = {scene.tick: scene for scene in scenes(replay, {1, SHOT_TICKS, SHOT_TICKS + 1})}

    assert [(shot.camp, shot.tick) for shot in shown[1].shots] == [("red", 1)]
    assert len(shown[SHOT_TICKS].shots) == 1
    assert shown[SHOT_TICKS + 1].shots == ()
    assert not any(scene.shots or scene.deaths for scene in scenes(replay, {1, 2}, "red"))


def test_a_death_is_marked_where_it_was(replay: Replay) -> None:
    dead = next(event for event in replay.events if event["kind"] == "dead")

    (scene,) = scenes(replay, {dead["tick"]})

    hexmap = replay.scenario().hexmap
    assert (dead["piece"].split(":")[0], dead["cell"]) in {
        (death.camp, hexmap.cell_name(death.cell)) for death in scene.deaths
    }


def test_pieces_in_one_cell_stand_in_a_row() -> None:
    row = [Token("red", 7, "T3"), Token("red", 7, "T2"), Token("red", 8, "C3")]

    assert [aside for _, aside in fanned(row)] == [-0.5, 0.5, 0.0]


def test_an_unknown_view_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'red'"):
        next(scenes(Replay.of(Game("plain", seed=0)), {0}, "rde"))
