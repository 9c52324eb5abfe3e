"""What a piece can do, here and elsewhere: the engine's own answers, by what the camp knows."""

from __future__ import annotations

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.orders import GuideShoot, IndirectShoot, Shoot
from hexwar_sb3.errors import OrderError
from hexwar_sb3.server.advice import look_at, path_to

BOARD = """
    map   plain-40x9
    point ford 0604 40
    red   tank 0204
    red   chariot 0206
    red   soldier 0208
    blue  tank 1004
    blue  chariot 3804
    ticks 900
"""


@pytest.fixture
def game() -> Game:
    return Game.from_text(BOARD)


def number(game: Game, name: str) -> int:
    return int(game.roster.cell(name))


@pytest.mark.parametrize("piece", ["tank0", "chariot0", "soldier0"])
def test_what_is_told_is_what_is_legal(game: Game, piece: str) -> None:
    told, legal = look_at(game, "red", piece, None), game.legal_orders("red", piece)
    fire = [order for order in legal if isinstance(order, Shoot | GuideShoot)]
    cells = {number(game, order.cell) for order in legal if isinstance(order, IndirectShoot)}

    assert {shot["order"] for shot in told["shots"]} == set(map(str, fire))
    assert {cell for group in told["mortar"] for cell in group["cells"]} == cells
    others = {str(order) for order in legal if order not in fire and not isinstance(order, IndirectShoot)}
    assert set(told["orders"]) | {f"{piece} null"} == others
    assert told["at"] == number(game, game.view("red").piece(piece).cell)


def test_chances_are_told_before_a_shot(game: Game) -> None:
    (shot,) = (shot for shot in look_at(game, "red", "tank0", None)["shots"] if "GUN" in shot["order"])
    (order,) = (o for o in game.legal_orders("red", "tank0") if isinstance(o, Shoot) and o.weapon == "GUN")

    chances = order.chances
    assert chances is not None
    assert shot["chances"] == pytest.approx([chances.nothing, chances.suppressed, *chances.losses], abs=1e-4)
    assert shot["points"] == pytest.approx(10 * chances.expected_losses, abs=0.01)
    assert (shot["target"], shot["ago"]) == ("blue:tank0", 0)


def test_mortar_cells_come_in_groups_of_equal_chances(game: Game) -> None:
    groups = look_at(game, "red", "chariot0", None)["mortar"]
    by_cell = {cell: group for group in groups for cell in group["cells"]}

    assert by_cell[number(game, "1004")]["class"] == 2
    for order in game.legal_orders("red", "chariot0"):
        if isinstance(order, IndirectShoot):
            group, chances = by_cell[number(game, order.cell)], order.chances
            assert chances is not None
            found = (group["hit"], group["off_target"], group["scatter"])
            assert found == pytest.approx((chances.hit, chances.off_target, chances.scatter), abs=1e-4)
    assert len(groups) <= 6


def test_what_is_impossible_says_why_in_the_engines_words(game: Game) -> None:
    told = dict(look_at(game, "red", "tank0", None)["impossible"])

    for order, why in told.items():
        assert game.why_illegal("red", order) == why
    assert {order.split()[1] for order in told} == {"stop", "occupy", "decompress", "shoot"}
    assert not any("chariot0" in order or "mortar" in why for order, why in told.items())  # no enemy unseen


def test_a_moving_chariot_says_why_it_does_not_fire(game: Game) -> None:
    game.submit("red", "chariot0 move E E")
    game.advance(5)

    told = look_at(game, "red", "chariot0", None)

    assert told["mortar"] == []
    verbs = {order.split()[1] for order, _ in told["impossible"]}
    assert {"move", "hide", "indirect-shoot", "shoot"} <= verbs


def test_from_another_cell_it_fires_as_if_it_stood_there(game: Game) -> None:
    told = look_at(game, "red", "tank0", number(game, "0804"))
    with game.edit() as state:
        state["red:tank0"].cell = "0804"

    there = look_at(game, "red", "tank0", None)

    assert told["planned"]
    assert told["at"] == there["at"]
    assert told["shots"] == there["shots"]


def test_looking_changes_nothing(game: Game) -> None:
    before = [array.tobytes() for array in (game.state.pieces, game.state.memory, game.state.games)]

    look_at(game, "red", "tank0", number(game, "0804"))
    path_to(game, "red", "tank0", number(game, "0804"), None)

    assert [array.tobytes() for array in (game.state.pieces, game.state.memory, game.state.games)] == before


def test_an_enemy_out_of_sight_counts_where_it_was_last_seen(game: Game) -> None:
    """Seen in 1004 at tick 0, then it drives away: the chances from 0804 are those of then, and say how old they are."""
    with game.edit() as state:
        state["red:tank0"].cell = "0204"
    then = look_at(game, "red", "tank0", number(game, "0804"))["shots"]
    with game.edit() as state:
        state["blue:tank0"].cell = "3904"
    game.advance(10)

    told = look_at(game, "red", "tank0", number(game, "0804"))["shots"]

    assert [shot["ago"] for shot in told] == [
        11
    ]  # last seen before the edit, in the state before the first step
    assert [shot | {"ago": 0} for shot in told] == then
    assert look_at(game, "red", "tank0", None)["shots"] == []


def test_the_way_is_the_one_that_is_walked(game: Game) -> None:
    told = path_to(game, "red", "tank0", number(game, "0604"), None)

    game.submit("red", "tank0 move " + " ".join(game.roster.cell_name(cell) for cell in told["cells"]))
    found = [(event.cell, event.tick) for event in game.advance(200) if event.kind == "arrived"]

    assert found == [
        (game.roster.cell_name(cell), tick) for cell, tick in zip(told["cells"], told["ticks"], strict=True)
    ]
    assert told["arrives"] == told["ticks"][-1] == 80


def test_a_piece_on_its_way_sets_out_after_its_hop(game: Game) -> None:
    game.submit("red", "tank0 move E E")
    game.advance(5)

    told = path_to(game, "red", "tank0", number(game, "0204"), None)

    assert told["start"] == 20
    assert path_to(game, "red", "tank0", number(game, "0604"), number(game, "0404"))["ticks"] == [25, 45]


def test_the_way_tells_who_would_see_it(game: Game) -> None:
    told = path_to(game, "red", "tank0", number(game, "0604"), None)

    assert told["watched"] == [[cell, ["blue:tank0"]] for cell in told["cells"]]


@pytest.mark.parametrize(
    ("piece", "cell"), [("tank0", -1), ("tank0", 10**6), ("tank0", 79), ("blue:tank0", 5), ("nobody", 5)]
)
def test_other_pieces_and_cells_are_refused(game: Game, piece: str, cell: int) -> None:
    """Cell 79 ends the second row, which is one cell shorter."""
    for question in (look_at, path_to):
        with pytest.raises((OrderError, KeyError)):
            question(game, "red", piece, cell, *((None,) if question is path_to else ()))
