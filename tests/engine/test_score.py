"""Scores and the end of a game (rule book, section 12)."""

from __future__ import annotations

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.orders import Occupy
from hexwar_sb3.engine.score import known_margin, own_total, points_held, points_value
from hexwar_sb3.rules.enums import Camp

BOARD = "map plain-9x5\nticks {ticks}\npoint main 0303 80\nred tank 0303\nred aerocraft 0101\nblue chariot 0903\nblue soldier aboard chariot0\n"


def test_a_camp_is_worth_its_pieces_with_passengers_and_its_points() -> None:
    """Section 12: the sum over own pieces of v x blood, passengers included."""
    game = Game.from_text(BOARD.format(ticks=1800))
    rules, rows = game.world.rules[0], (game.state.games[0], game.pieces)
    assert own_total(*rows, Camp.RED, rules) == 3 * 10 + 8
    assert own_total(*rows, Camp.BLUE, rules) == 3 * 7 + 3 * 4
    assert game.margin("red") == 38 - 33 - 80
    assert game.margin("blue") == 33 - 38 - 80


def test_each_side_of_the_built_in_scenario_is_worth_134() -> None:
    """Section 2: sum 134 a side, 130 of control points."""
    game = Game("plain")
    assert game.view("red").own_total == game.view("blue").own_total == 134
    assert game.margin("red") == game.margin("blue") == -130


def test_the_net_score_leaves_green_out() -> None:
    """Section 12, option net."""
    game = Game.from_text(BOARD.format(ticks=1800) + "score net")
    assert (game.margin("red"), game.margin("blue")) == (5, -5)


def test_the_winner_does_not_depend_on_how_green_is_read() -> None:
    """Section 12: v_Red - v_Blue = 2 (own_Red - own_Blue)."""
    for words in ("", "score net"):
        game = Game.from_text(BOARD.format(ticks=1800) + words)
        assert game.margin("red") - game.margin("blue") == 2 * (38 - 33)


@pytest.mark.parametrize(("blood", "outcome"), [(3, "red"), (1, "blue")])
def test_the_larger_score_wins_at_the_last_tick(blood: int, outcome: str) -> None:
    """Section 12."""
    game = Game.from_text(BOARD.format(ticks=30))
    with game.edit() as state:
        state["red:tank0"].blood = blood
    game.advance(29)
    assert (game.over, game.outcome) == (False, None)
    game.advance(10)
    assert (game.over, game.outcome, game.tick) == (True, outcome, 30)


def test_equal_scores_draw() -> None:
    """Section 12."""
    game = Game.from_text("map plain-9x5\nticks 5\nred tank 0101\nblue tank 0901")
    game.advance(5)
    assert game.outcome == "draw"


def test_a_game_goes_on_when_one_side_is_wiped_out() -> None:
    """Section 12: the end is at the last tick exactly; an early end is an option."""
    game = Game.from_text(BOARD.format(ticks=60))
    with game.edit() as state:
        state["blue:chariot0"].blood = 0
    game.advance(10)
    assert not game.over
    game.submit("red", Occupy("tank0"))
    game.advance(1)
    assert game.margin("red") == 38 + 80
    game.state.games[0].early_end = 1
    game.advance(1)
    assert game.over


def test_the_known_margin_counts_enemies_at_their_last_seen_blood() -> None:
    """Section 6: never seen ones at full blood; unseen losses do not show."""
    game = Game.from_text("map plain-60x3\nred tank 0102\nblue tank 5902\nblue chariot 2002")
    rules = game.world.rules[0]

    def known(camp: Camp) -> int:
        return int(known_margin(game.state.games[0], game.pieces, game.state.memory[0], camp, rules))

    assert known(Camp.RED) == game.margin("red") == 30 - 51
    with game.edit() as state:
        state["blue:tank0"].blood = 1
        state["blue:chariot0"].blood = 2
    assert (known(Camp.RED), game.margin("red")) == (30 - 30 - 14, 30 - 10 - 14)
    assert game.view("red").known_margin == known(Camp.RED)


@pytest.mark.parametrize("words", ["", "score net"])
def test_the_known_margin_is_the_margin_where_everything_is_seen(words: str) -> None:
    """Section 12: points of all owners, in both forms of the score."""
    points = "point main 0303 80 red\npoint near 0503 50 blue\npoint far 0703 30\n"
    game = Game.from_text(f"map plain-9x5\n{points}red tank 0303 blood 2\nblue chariot 0603\n{words}")
    for camp in (Camp.RED, Camp.BLUE):
        known = known_margin(
            game.state.games[0], game.pieces, game.state.memory[0], camp, game.world.rules[0]
        )
        assert known == game.margin(camp.name.lower())


def test_a_camp_holds_the_points_that_it_owns() -> None:
    """Section 12: green's are nobody's."""
    points = "point main 0303 80 red\npoint near 0503 50 red\npoint far 0703 30\n"
    record = Game.from_text(f"map plain-9x5\n{points}red tank 0101\nblue tank 0901").state.games[0]
    assert [points_held(record, camp) for camp in Camp] == [2, 0, 1]
    assert [points_value(record, camp) for camp in Camp] == [130, 0, 30]
