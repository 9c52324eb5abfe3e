"""Who sees whom, and what is remembered (rule book, section 6)."""

from __future__ import annotations

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.orders import Hide, Move
from hexwar_sb3.engine.sight import look_all, look_around
from hexwar_sb3.engine.view import SideView


def sees(observer: str, target: str, apart: int, cells: str = "") -> bool:
    """Does a red piece see a blue one so many cells to the east?"""
    kind, *words = target.split()
    place = f"{2 + apart:02d}02"
    board = f"map plain-60x3\n{cells}\nred {observer} 0202\nblue {kind} {place} {' '.join(words)}"
    game = Game.from_text(board)
    return bool(game.view("red").own[0].sees)


def range_of(observer: str, target: str, cells: str = "") -> int:
    """The greatest distance of sight, checked from both sides."""
    reach = max(apart for apart in range(1, 40) if sees(observer, target, apart, cells))
    assert all(sees(observer, target, apart, cells) for apart in range(1, reach + 1))
    return reach


@pytest.mark.parametrize("observer", ["tank", "chariot", "soldier"])
@pytest.mark.parametrize(
    ("target", "reach"), [("soldier", 10), ("tank", 25), ("chariot", 25), ("aerocraft", 5)]
)
def test_how_far_ground_pieces_see(observer: str, target: str, reach: int) -> None:
    """Section 6, first row of the table."""
    assert range_of(observer, target) == reach


@pytest.mark.parametrize(("target", "reach"), [("soldier", 2), ("tank", 5), ("chariot", 5), ("aerocraft", 5)])
def test_how_far_an_aerocraft_sees(target: str, reach: int) -> None:
    """Section 6, second row."""
    assert range_of("aerocraft", target) == reach


@pytest.mark.parametrize(
    ("rule", "observer", "target", "cells", "reach"),
    [
        ("a hidden soldier is seen half as far", "tank", "soldier hidden", "", 5),
        ("a hidden vehicle is seen half as far, rounded down", "tank", "tank hidden", "", 12),
        ("an aerocraft sees hidden vehicles as well as others", "aerocraft", "tank hidden", "", 5),
        ("an aerocraft sees hidden soldiers half as far, but 1", "aerocraft", "soldier hidden", "", 1),
    ],
)  # fmt: skip
def test_hiding_halves_sight(rule: str, observer: str, target: str, cells: str, reach: int) -> None:
    """Section 6: x 1/2 (floor, at least 1)."""
    assert range_of(observer, target, cells) == reach, rule


@pytest.mark.parametrize(
    ("rule", "target", "apart", "seen"),
    [
        ("a piece in a concealed cell is seen half as far", "tank", 12, True),
        ("... and no farther", "tank", 13, False),
        ("a hidden piece in a concealed cell a quarter", "tank hidden", 6, True),
        ("... and no farther", "tank hidden", 7, False),
        ("an aerocraft is never concealed", "aerocraft", 5, True),
    ],
)
def test_cover_halves_sight(rule: str, target: str, apart: int, seen: bool) -> None:
    """Section 6: x 1/2 again."""
    assert sees("tank", target, apart, f"cell {2 + apart:02d}02 concealed") == seen, rule


@pytest.mark.parametrize(("hill", "seen"), [("0202", True), ("1602", False)])
def test_a_hidden_vehicle_is_no_smaller_from_above(hill: str, seen: bool) -> None:
    """Section 6: except a vehicle whose cell is lower than the observer's."""
    assert sees("tank", "tank hidden", 14, f"cell {hill} elev 30") == seen


def test_a_hidden_soldier_is_smaller_from_above_too() -> None:
    """Section 6: the exception is for vehicles."""
    assert not sees("tank", "soldier hidden", 6, "cell 0202 elev 30")


def test_a_ridge_blocks_the_view_but_not_that_of_an_aerocraft() -> None:
    """Section 6, line of sight."""
    ridge = "cell 0301 0302 0303 elev 50"
    assert not sees("tank", "tank", 3, ridge)
    assert sees("aerocraft", "tank", 3, ridge)
    assert sees("tank", "tank", 1, ridge)


def test_over_a_ridge_aerocraft_are_seen_from_the_ground_and_by_each_other() -> None:
    """Section 6: it flies above its cell, as observer and as target."""
    assert sees("tank", "aerocraft", 3, "cell 0301 0302 0303 elev 50")
    assert sees("aerocraft", "aerocraft", 3, "cell 0401 0402 0403 elev 180")
    for observer, target in (("aerocraft", "tank"), ("tank", "aerocraft")):
        assert not sees(observer, target, 3, "cell 0401 0402 0403 elev 180")


@pytest.mark.parametrize(("apart", "seen"), [(1, True), (2, False)])
def test_whoever_is_seen_at_all_is_seen_from_the_next_cell(apart: int, seen: bool) -> None:
    """Section 6: halved once or twice, and still 1."""
    assert sees("aerocraft", "soldier hidden", apart) == seen
    assert sees("aerocraft", "soldier hidden", apart, f"cell {2 + apart:02d}02 concealed") == seen


def seen(view: SideView) -> list[str]:
    return [enemy.name for enemy in view.seen]


def test_passengers_neither_see_nor_are_seen() -> None:
    """Section 6: not aboard."""
    game = Game.from_text("map plain-9x3\nred chariot 0202\nred soldier aboard chariot0\nblue tank 0502")
    assert game.view("red").piece("soldier0").sees == ()
    assert seen(game.view("blue")) == ["red:chariot0"]


def test_an_enemy_out_of_sight_is_remembered_as_last_seen() -> None:
    """Section 6: u(sigma, t) with hex, blood and steps since."""
    game = Game.from_text("map plain-60x3\nred tank 0202\nblue tank 2602 moving 2702 2802 2902")
    assert seen(game.view("red")) == ["blue:tank0"]
    game.advance(40)
    assert (game.view("red").seen, game.view("red").lost[0].unseen_ticks) == ((), 1)
    game.advance(60)
    lost = game.view("red").lost[0]
    assert (lost.name, lost.cell, lost.blood, lost.unseen_ticks) == ("blue:tank0", "2702", 3, 61)


def test_an_enemy_that_was_never_seen_has_no_cell() -> None:
    """Section 6: unknown fields are absent, not zero."""
    game = Game.from_text("map plain-60x3\nred tank 0202\nblue soldier 3902")
    unseen = game.view("red").unseen[0]
    assert (unseen.name, unseen.kind) == ("blue:soldier0", "soldier")
    assert game.state.memory[0, :, :].seen.tolist() == [[0, 0], [0, 0]]
    assert not hasattr(unseen, "cell")
    assert not hasattr(unseen, "blood")


def test_a_watched_death_is_known_and_an_unwatched_one_is_not() -> None:
    """Section 6: what was seen last."""
    game = Game.from_text("map plain-60x3\nred tank 0202\nblue tank 2002\nblue tank 4002")
    game.pieces[1].blood = game.pieces[2].blood = 1
    with game.edit() as state:
        state["blue:tank0"].blood = 0
        state["blue:tank1"].blood = 0
    red = game.view("red")
    assert [(enemy.name, enemy.blood) for enemy in red.lost] == [("blue:tank0", 0)]
    assert [enemy.name for enemy in red.unseen] == ["blue:tank1"]
    assert game.state.memory[0, 0, 1].tick == 0, "seen in the very state in which it is dead"


def test_a_seen_enemy_shows_where_it_goes_and_how_it_stands() -> None:
    """Section 6: type, hex, next hex, blood, hidden, suppressed, speed."""
    game = Game.from_text("map plain-9x3\nred tank 0202\nblue chariot 0502 moving 0602 suppressed blood 2")
    enemy = game.view("red").seen[0]
    assert (enemy.kind, enemy.cell, enemy.next_cell, enemy.blood) == ("chariot", "0502", "0602", 2)
    assert (enemy.suppressed, enemy.hidden, enemy.moving, enemy.speed) == (True, False, True, 1 / 20)
    known = game.state.memory[0, 0, 1]
    assert (known.suppressed, known.hidden, known.moving) == (1, 0, 1)


def test_an_enemy_that_stands_under_cover_is_known_to() -> None:
    """Section 6: hidden, not suppressed, not in motion; a stop transition is motion."""
    game = Game.from_text("map plain-9x3\nred tank 0202\nblue tank 0502 hidden\nblue tank 0602 stopping")
    cover, stopping = game.state.memory[0, 0, 1:]
    assert (cover.suppressed, cover.hidden, cover.moving) == (0, 1, 0)
    assert stopping.moving == 1


def test_a_piece_that_hides_drops_out_of_sight() -> None:
    """Section 6: sight is renewed when a piece hides or shows itself."""
    game = Game.from_text("map plain-60x3\nred tank 0202\nblue tank 1602")
    game.submit("blue", Hide("tank0"))
    game.advance(74)
    assert seen(game.view("red")) == ["blue:tank0"]
    game.advance(1)
    assert seen(game.view("red")) == []
    game.submit("blue", Move("tank0", ["1702"]))
    game.advance(1)
    assert seen(game.view("red")) == ["blue:tank0"]


def test_with_the_lights_on_everything_on_the_map_is_seen() -> None:
    """architecture.md, section 4: fog=False is for debugging."""
    game = Game.from_text("map plain-60x3\nred tank 0202\nblue tank 5002")
    game.state.games[0].fog = 0
    with game.edit() as state:
        state["red:tank0"].cell = "0202"
    assert seen(game.view("red")) == ["blue:tank0"]


def test_with_the_lights_on_neither_passengers_nor_the_dead_are_seen() -> None:
    """architecture.md, section 4: on the map."""
    game = Game.from_text(
        "map plain-60x3\nred tank 0202\nblue chariot 5002\nblue soldier aboard chariot0\nblue tank 5102"
    )
    game.state.games[0].fog = 0
    with game.edit() as state:
        state["blue:tank0"].blood = 0
    assert seen(game.view("red")) == ["blue:chariot0"]
    assert not game.state.memory[0, 0, 0].seen, "nobody is an enemy of its own"


def test_an_aerocraft_sees_a_hidden_vehicle_as_far_as_any() -> None:
    """Section 6: the observer flies."""
    assert sees("aerocraft", "tank hidden", 5)


def test_only_the_pieces_named_are_looked_at_again() -> None:
    """Section 6: what they see, and who sees them."""
    game = Game.from_text("map plain-9x3\nred tank 0202\nred tank 0203\nblue tank 0502\nblue tank 0503")
    game.pieces.sees = 0
    game.pieces[0].changed_now = 1
    look_around(game.pieces, *game.world.tables)
    assert game.pieces.sees.tolist() == [0b11, 0, 0b01, 0b01]
    assert not game.pieces.changed_now.any()
    look_all(game.pieces, *game.world.tables)
    assert game.pieces.sees.tolist() == [0b11, 0b11, 0b11, 0b11]


def test_a_camp_knows_since_when_an_enemy_is_in_sight_and_stands_in_its_cell() -> None:
    """Section 6: a contact is news once; the clock of its cell starts again when it moves."""
    game = Game.from_text("map plain-60x3\nred tank 0202\nblue tank 2802 moving 2702 2602")
    known, record = game.state.memory[0, 0, 1], game.state.games[0]
    assert (known.seen, record.contact_tick[0]) == (0, -1)
    game.advance(20)
    assert (known.seen, known.first_tick, known.still_since, record.contact_tick[0]) == (1, 20, 20, 20)
    assert known.tick == 20
    game.advance(10)
    assert known.still_since == 20
    game.advance(10)
    assert (known.first_tick, known.still_since, record.contact_tick[0]) == (20, 40, 20)


def test_an_enemy_out_of_sight_leads_nowhere_and_was_seen_a_tick_ago() -> None:
    """Section 6: what is remembered is the last state in which it was seen."""
    game = Game.from_text("map plain-60x3\nred tank 0202\nblue tank 2702 moving 2802 2902")
    known = game.state.memory[0, 0, 1]
    assert known.next_cell == game.pieces[1].cell + 1
    game.advance(20)
    assert (known.seen, known.next_cell, known.tick, known.blood) == (0, -1, 19, 3)
