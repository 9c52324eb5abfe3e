"""Text boards."""

from __future__ import annotations

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.orders import Shoot
from hexwar_sb3.errors import ConfigError


def test_a_moving_chariot_cannot_shoot_until_it_has_stopped() -> None:
    """A piece that is under way refuses a shoot order and says why (section 4, shoot)."""
    game = Game.from_text("""
        map      plain-5x5
        red      chariot 0101 moving 0102
        blue     soldier 0104
    """)

    reason = game.why_illegal("red", Shoot("chariot0", target="blue:soldier0", weapon="CANNON"))

    assert reason == "red chariot0 is moving; it must stand for 75 s before it shoots"


def test_a_board_says_everything_of_a_position() -> None:
    game = Game.from_text("""
        # comments and blank lines are skipped

        map      plain-9x5
        cell     0303 0304 elev 40 concealed
        point    main 0503 80 blue
        point    far 0701 20
        red      chariot 0101 blood 2 ammo HEAVY 1 mortar_cool 12
        red      soldier aboard chariot0
        red      tank 0201 stopping suppressed
        blue     tank 0901 hidden cool 33
        ticks    900
        score    net
        seed     7
    """)
    assert str(game).splitlines() == [
        "board: tick 0 of 900, margin red -54, blue +54",
        "point    main 0503 80 blue",
        "point    far 0701 20 green",
        "red      chariot0 0101 blood 2",
        "red      soldier0 aboard chariot0 blood 3",
        "red      tank0 0201 blood 3 stopping suppressed",
        "blue     tank0 0901 blood 3 hidden cool 33",
    ]
    assert game.seed == 7
    assert game.view("red").piece("chariot0").mortar_cool_left == 12
    assert dict(game.view("red").piece("chariot0").ammo)["HEAVY"] == 1
    assert int(game.world.cells.elev_m.max()) == 40


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("mpa plain-5x5", "board, line 2: 'mpa plain-5x5': unknown word 'mpa'; did you mean 'map'?"),
        ("map hills-5x5", "board, line 2: 'map hills-5x5': unknown map 'hills-5x5'; expected plain-<columns>x<rows>"),
        ("red tnak 0101", "board, line 2: 'red tnak 0101': unknown type of piece 'tnak'; did you mean 'tank'?"),
        ("red tank 0909", "board, line 2: 'red tank 0909': cell '0909' is off the map: columns 01-05 (01-04 in even rows), rows 01-05"),
        ("red tank 0101 flying", "board, line 2: 'red tank 0101 flying': unknown word 'flying' after the piece's cell"),
        ("red soldier aboard chariot0", "board, line 2: 'red soldier aboard chariot0': red chariot0 must stand in a line above its passenger"),
        ("cell 0101 swampy", "board, line 2: 'cell 0101 swampy': unknown mark 'swampy'; expected elev, blocked"),
        ("red tank", "board, line 2: 'red tank': a word is missing at its end"),
    ],
)  # fmt: skip
def test_a_board_that_cannot_be_read_names_the_line(line: str, message: str) -> None:
    with pytest.raises(ConfigError) as error:
        Game.from_text(f"map plain-5x5\n{line}")
    assert str(error.value).startswith(message)


def test_a_board_needs_a_map_first() -> None:
    with pytest.raises(ConfigError, match="expected a line 'map plain-5x5' first"):
        Game.from_text("red tank 0101")
