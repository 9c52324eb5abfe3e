"""Plans of a person: what is tried at once, what waits, what is refused when it is due, and what is taken back."""

from __future__ import annotations

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.errors import HexWarError
from hexwar_sb3.server import seat as seat_module
from hexwar_sb3.server.seat import PersonSeat, Refused
from hexwar_sb3.server.steps import MOST_STEPS
from hexwar_sb3.server.ways import move_along

BOARD = """
    map   plain-40x9
    point ford 0604 40
    red   tank 0204
    red   chariot 0206
    blue  tank 3004
    ticks 900
"""


@pytest.fixture
def game() -> Game:
    return Game.from_text(BOARD)


@pytest.fixture
def seat(game: Game) -> PersonSeat:
    return PersonSeat(game, "red")


def play(seat: PersonSeat, ticks: int) -> dict[int, list[str]]:
    """Play so many ticks by the seat's plans; its orders by tick, and what was refused."""
    found: dict[int, list[str]] = {}
    for _ in range(ticks):
        tick = seat.game.tick
        orders, refused = seat.due()
        told = [*map(str, orders), *(one.why for one in refused)]
        found |= {tick: told} if told else {}
        seat.game.submit("red", orders, strict=False)
        seat.game.advance(1)
    return found


def test_an_order_lies_in_the_tray_until_the_clock_runs(seat: PersonSeat) -> None:
    seat.plan("tank0", ("tank0 move E",))

    assert seat.tray() == {"tank0": "tank0 move E"}
    assert seat.told() == {}
    assert play(seat, 3) == {0: ["tank0 move E"]}
    assert seat.tray() == {}


def test_what_the_engine_would_refuse_now_is_not_planned(seat: PersonSeat) -> None:
    seat.plan("tank0", ("tank0 hide",))

    with pytest.raises(HexWarError, match="stands in 0204, which is no control point"):
        seat.plan("tank0", ("tank0 occupy",))

    assert seat.tray() == {"tank0": "tank0 hide"}


def test_a_waypoint_is_walked_by_the_fastest_way_and_then_the_rest_is_due(seat: PersonSeat) -> None:
    seat.plan("tank0", ("tank0 go 0604", "tank0 occupy", "tank0 hide"))

    assert seat.tray() == {"tank0": "tank0 move 0304 0404 0504 0604"}
    assert seat.told() == {"tank0": ["tank0 go 0604", "tank0 occupy", "tank0 hide"]}
    assert play(seat, 200) == {
        0: ["tank0 move 0304 0404 0504 0604"],
        80: ["tank0 occupy"],
        81: ["tank0 hide"],
    }
    assert seat.plans == {}


@pytest.mark.parametrize(
    ("piece", "first", "second", "tick"),
    [
        ("tank0", "shoot blue:tank0 GUN", "shoot blue:tank0 GUN", 75),
        ("chariot0", "move E", "indirect-shoot 1204", 94),
    ],
)
def test_steps_that_only_have_to_wait_wait(
    game: Game, piece: str, first: str, second: str, tick: int
) -> None:
    """A gun cools for 75 ticks; a chariot fires when it has stood for 75 ticks."""
    with game.edit() as state:
        state["blue:tank0"].cell = "1404"
    seat = PersonSeat(game, "red")
    seat.plan(piece, (f"{piece} {first}", f"{piece} {second}"))

    assert play(seat, 100) == {0: [f"{piece} {first}"], tick: [f"{piece} {second}"]}


def test_a_step_that_is_refused_when_it_is_due_ends_the_plan(seat: PersonSeat) -> None:
    seat.plan("tank0", ("tank0 move E", "tank0 occupy", "tank0 hide"))

    assert play(seat, 100)[20] == [
        "red tank0 stands in 0304, which is no control point; it must stand in one to occupy it"
    ]
    assert seat.plans == {}


def test_what_was_refused_is_told_with_its_piece_and_order(seat: PersonSeat) -> None:
    seat.plan("tank0", ("tank0 shoot blue:tank0 GUN",), then=True)

    _, refused = seat.due()

    assert refused == [
        Refused(
            "tank0",
            "tank0 shoot blue:tank0 GUN",
            "blue tank0 is not in sight of red tank0; a target must be alive and seen by red tank0 itself",
        )
    ]


def test_a_piece_on_its_way_stops_before_it_goes_elsewhere(seat: PersonSeat) -> None:
    seat.plan("tank0", ("tank0 go 1004",))
    play(seat, 30)

    seat.plan("tank0", ("tank0 go 0206",))

    assert seat.tray() == {"tank0": "tank0 stop"}
    play(seat, 300)
    assert seat.game.view("red").piece("tank0").cell == "0206"


def test_a_way_longer_than_an_order_is_walked_in_several(
    seat: PersonSeat, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        seat_module, "move_along", lambda way, piece, roster, _: move_along(way, piece, roster, 3)
    )
    seat.plan("tank0", ("tank0 go 0604",))

    assert play(seat, 100) == {0: ["tank0 move 0304 0404 0504"], 60: ["tank0 move 0604"]}


def test_undo_takes_back_plans_until_the_clock_runs(seat: PersonSeat) -> None:
    seat.plan("tank0", ("tank0 hide",))
    seat.plan("tank0", ("tank0 go 0604",))
    seat.cancel("tank0")
    assert seat.undoes == 3

    seat.undo()
    assert seat.told() == {"tank0": ["tank0 go 0604"]}
    seat.undo()
    assert seat.tray() == {"tank0": "tank0 hide"}
    play(seat, 1)
    with pytest.raises(HexWarError, match="nothing to take back"):
        seat.undo()


def test_kept_plans_go_on_when_they_are_restored(game: Game, seat: PersonSeat) -> None:
    seat.plan("tank0", ("tank0 go 0604", "tank0 occupy"))
    other = PersonSeat(game.copy(), "red")
    other.restore({piece: tuple(steps) for piece, steps in seat.kept().items()})

    assert play(other, 100) == play(seat, 100)


def test_a_destroyed_piece_has_no_plan_left(game: Game, seat: PersonSeat) -> None:
    seat.plan("tank0", ("tank0 go 0604",))
    with game.edit() as state:
        state["red:tank0"].blood = 0

    assert seat.due() == ([], [])
    assert seat.plans == {}


@pytest.mark.parametrize(
    ("piece", "steps", "why"),
    [
        ("blue:tank0", ("blue:tank0 hide",), "does not belong to red"),
        ("red:tank0", ("red:tank0 hide",), "without its camp"),
        ("tank9", ("tank9 hide",), "unknown piece"),
        ("tank0", ("chariot0 hide",), "expected a step of tank0"),
        ("tank0", ("tank0 go 9999",), "9999"),
        ("tank0", ("tank0 go",), "expected one cell"),
        ("tank0", ("tank0 go 0204",), "stands there already"),
        ("tank0", ("tank0 fly",), "unknown action 'fly'"),
        ("tank0", ("tank0 null",), "does nothing"),
        ("tank0", ("tank0 shoot blue:tank7 GUN",), "unknown piece"),
        ("tank0", (), "0 steps"),
        ("tank0", ("tank0 hide",) * (MOST_STEPS + 1), "33 steps"),
    ],
)
@pytest.mark.parametrize("then", [True, False])
def test_what_is_no_plan_of_the_piece_is_refused(
    seat: PersonSeat, piece: str, steps: tuple[str, ...], why: str, then: bool
) -> None:
    if then and why == "stands there already":
        return  # it may have left by then
    with pytest.raises(HexWarError, match=why):
        seat.plan(piece, steps, then=then)
    assert (seat.plans, seat.undoes) == ({}, 0)


def test_a_plan_is_at_most_so_long(seat: PersonSeat) -> None:
    seat.plan("tank0", ("tank0 hide",) * MOST_STEPS, then=True)

    with pytest.raises(HexWarError, match="at most 32"):
        seat.plan("tank0", ("tank0 hide",), then=True)
