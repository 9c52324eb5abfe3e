"""Orders as text and as records (rule book, section 4): round trips and unreadable ones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.order_rows import GAP, read_order, write_order
from hexwar_sb3.engine.orders import (
    ORDERS,
    Decompress,
    GetOff,
    GetOn,
    GuideShoot,
    Hide,
    IndirectShoot,
    Move,
    Null,
    Occupy,
    Order,
    Shoot,
    Stop,
)
from hexwar_sb3.engine.records import ORDER, PATH_CELLS
from hexwar_sb3.errors import OrderError, UnknownNameError
from hexwar_sb3.rules.enums import Action
from hexwar_sb3.rules.indices import PieceIndex

TEXTS = {
    "tank0 null": Null("tank0"),
    "tank0 move 1134 1234": Move("tank0", ["1134", "1234"]),
    "tank0 stop": Stop("tank0"),
    "tank0 hide": Hide("tank0"),
    "soldier1 occupy": Occupy("soldier1"),
    "tank1 shoot blue:chariot0 GUN": Shoot("tank1", "blue:chariot0", "GUN"),
    "aerocraft0 guide-shoot blue:tank0 chariot1": GuideShoot("aerocraft0", "blue:tank0", "chariot1"),
    "chariot0 indirect-shoot 2034": IndirectShoot("chariot0", "2034"),
    "soldier0 get-on chariot0": GetOn("soldier0", "chariot0"),
    "chariot0 get-off soldier0": GetOff("chariot0", "soldier0"),
    "tank0 decompress": Decompress("tank0"),
}


def test_all_eleven_actions_have_an_order() -> None:
    """II-B: eleven actions."""
    assert set(ORDERS) == set(Action)
    assert {type(order) for order in TEXTS.values()} == set(ORDERS.values())


@pytest.mark.parametrize("text", TEXTS)
def test_an_order_and_its_text_are_the_same_both_ways(text: str) -> None:
    order = TEXTS[text]
    assert str(order) == text
    assert Order.parse(text) == order
    assert hash(Order.parse(text)) == hash(order)


@pytest.fixture(scope="module")
def game() -> Game:
    return Game("plain")


def as_read(order: Order, game: Game) -> Order:
    i = game.roster.own_index(0, order.piece)
    row = np.zeros(1, ORDER).view(np.recarray)[0]
    write_order(order, i, row, game.roster, game.pieces, game.world.cells)
    return read_order(i, row, game.roster, game.pieces, game.world.cells)


@pytest.mark.parametrize("text", TEXTS)
def test_an_order_and_its_record_are_the_same_both_ways(text: str, game: Game) -> None:
    assert as_read(TEXTS[text], game) == TEXTS[text]


def test_every_cell_name_survives_text_and_record(game: Game) -> None:
    """All cells of the map, as the aim of a mortar."""
    hexmap = game.world.scenario.hexmap
    for cell in np.flatnonzero(hexmap.playable):
        order = IndirectShoot("chariot0", hexmap.cell_name(int(cell)))
        assert as_read(Order.parse(str(order)), game) == order


@given(st.lists(st.sampled_from(["W", "SW", "SE", "E", "NE", "NW"]), min_size=1, max_size=PATH_CELLS))
def test_a_path_by_directions_is_the_same_path_by_cells(steps: list[str]) -> None:
    """A path of directions reads back as cell names, and those as the same directions."""
    game = Game("plain")
    by_names = as_read(Move("tank0", steps), game)
    assert as_read(by_names, game) == by_names
    assert len(by_names.words()) <= len(steps)


def test_names_need_no_camp_where_it_is_clear(game: Game) -> None:
    """An own piece may be written with its camp, a target without."""
    assert as_read(Shoot("red:tank0", "chariot0", "gun"), game) == Shoot("tank0", "blue:chariot0", "GUN")


def test_a_gap_in_a_path_is_no_direction(game: Game) -> None:
    """A well-formed but impossible order is refused, not raised."""
    row = np.zeros(1, ORDER).view(np.recarray)[0]
    write_order(
        Move("tank0", ["1134", "2040"]), PieceIndex(0), row, game.roster, game.pieces, game.world.cells
    )
    assert list(row.path[:2]) == [4, GAP]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "order '': expected a piece and an action, like 'tank0 move 1134'"),
        ("tank0", "order 'tank0': expected a piece and an action, like 'tank0 move 1134'"),
        ("tank0 mvoe 1134", "order 'tank0 mvoe 1134': unknown action 'mvoe'; did you mean 'move'?"),
        ("tank0 shoot blue:tank0", "tank0 shoot: expected target weapon, found 1 parameters"),
        ("tank0 hide 1134", "tank0 hide: expected no parameters, found 1 parameters"),
        ("tank0 shoot blue:tank0 GUNN", "unknown weapon 'GUNN'; did you mean 'GUN'?"),
        ("tank0 get-on", "tank0 get-on: expected chariot, found none"),
    ],
)
def test_an_unreadable_order_says_what_was_expected(text: str, message: str) -> None:
    with pytest.raises(OrderError) as error:
        Order.parse(text)
    assert str(error.value) == message


@pytest.mark.parametrize(
    ("order", "message"),
    [
        (Hide("tnak0"), "unknown piece 'red:tnak0'; did you mean 'red:tank0'?"),
        (Hide("blue:tank0"), "blue:tank0 does not belong to red"),
        (Shoot("tank0", "blue:tank7", "GUN"), "unknown piece 'blue:tank7'; did you mean 'blue:tank1'?"),
        (Move("tank0", ["113"]), "cell '113': expected four digits, column then row"),
        (IndirectShoot("chariot0", "9999"), "cell '9999' is off the map: columns 01-71 (01-70 in even rows), rows 01-70"),
        (7, "expected an order such as Move('tank0', ['1134']) or 'tank0 move 1134', found 7"),
    ],
)  # fmt: skip
def test_an_order_about_what_does_not_exist_is_not_taken(order: Order, message: str, game: Game) -> None:
    """Nothing of the batch is given then."""
    with pytest.raises((OrderError, UnknownNameError)) as error:
        game.submit("red", [Hide("tank0"), order])
    assert str(error.value).startswith(message)
    assert not game.state.orders[0].kind.any()
