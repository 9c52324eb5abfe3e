"""Indirect fire (rule book, section 9)."""

from __future__ import annotations

from collections import Counter

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import GameEvent, of_kind
from hexwar_sb3.engine.orders import GetOff, GetOn, IndirectShoot, Move
from hexwar_sb3.maps.geometry import cells_apart
from hexwar_sb3.rules import default_rules

WIDE = "map plain-40x9\nblue tank 4005\n"
BATTERY = WIDE + "red chariot 0105\n"
BURST = {
    True: {2: 2, 3: 1, 4: 1, 5: 1, 6: 0, 7: 0, 8: 0, 9: 0, 10: 0, 11: 1, 12: 1},
    False: {2: 0, 3: 0, 4: 0, 5: -1, 6: -1, 7: -1, 8: -1, 9: 0, 10: -1, 11: 0, 12: 0},
}


def bombard(board: str, cell: str = "0905", seed: int = 0) -> Game:
    game = Game.from_text(board, seed)
    assert game.submit("red", IndirectShoot("chariot0", cell)) == [None]
    return game


def landed(board: str, *, hit: bool, cell: str = "0905", n: int = 0) -> tuple[Game, list[GameEvent]]:
    """The nth game whose round comes down in the aimed cell, on target or off it."""
    for seed in range(3000):
        game = bombard(board, cell, seed)
        events = game.advance(150)
        landing = of_kind(events, "mortar_landed")[0]
        if (landing.cell, landing.hit) == (cell, hit):
            if n == 0:
                return game, events
            n -= 1
    raise AssertionError("no such landing")


def test_a_round_lands_after_150_s_and_bursts_until_450_s() -> None:
    """Section 9: land_at = t + 150, end_at = t + 450."""
    game = bombard(BATTERY)
    assert [event.tick for event in of_kind(game.advance(200), "mortar_landed")] == [150]
    assert game.view("blue").bursting == game.view("red").bursting != ()
    game.advance(249)
    assert game.view("red").bursting != ()
    game.advance(1)
    assert game.view("red").bursting == ()


def test_a_round_costs_a_round_300_s_and_cover() -> None:
    """Section 4, indirect-shoot: MORTAR -1, mortar_cool = 300, cool = max(cool, 75), hidden off."""
    game = bombard(WIDE + "red chariot 0105 hidden cool 100")
    game.advance(1)
    chariot = game.view("red").piece("chariot0")
    assert (dict(chariot.ammo)["MORTAR"], chariot.hidden) == (5, False)
    assert (chariot.mortar_cool_left, chariot.cool_left) == (299, 99)
    game.advance(298)
    assert game.why_illegal("red", IndirectShoot("chariot0", "0905")) is not None
    game.advance(1)
    assert game.why_illegal("red", IndirectShoot("chariot0", "0905")) is None


@pytest.mark.parametrize("tick", [1, 100, 149])
def test_a_move_order_before_landing_cancels_the_round(tick: int) -> None:
    """Section 9; in the last step of the flight too, since orders start before rounds land (section 5)."""
    game = bombard(BATTERY)
    game.advance(tick)
    game.submit("red", Move("chariot0", ["E"]))
    assert not of_kind(game.advance(200), "mortar_landed")
    assert game.view("red").rounds == ()
    assert game.view("red").piece("chariot0").mortar_cool_left == max(0, 300 - tick - 200)


def test_a_move_order_after_landing_cancels_nothing() -> None:
    """Section 9: the burst stays."""
    game = bombard(BATTERY)
    game.advance(150)
    game.submit("red", Move("chariot0", ["E"]))
    game.advance(10)
    assert game.view("red").bursting != ()


def test_a_round_of_a_destroyed_chariot_still_lands() -> None:
    """Section 9; the strength used is that at launch."""
    game = bombard(BATTERY + "red tank 0101")
    game.advance(20)
    with game.edit() as state:
        state["red:chariot0"].blood = 0
    assert len(of_kind(game.advance(140), "mortar_landed")) == 1


def test_a_round_whose_owner_takes_a_soldier_aboard_lands() -> None:
    """Section 13: boarding is no move order."""
    game = bombard(BATTERY + "red soldier 0105")
    game.advance(76)
    game.submit("red", GetOn("soldier0", "chariot0"))
    assert len(of_kind(game.advance(100), "mortar_landed")) == 1


@pytest.mark.parametrize(
    ("klass", "more"), [(0, ""), (1, "red tank 0805"), (2, "red tank 0805\nblue chariot 0905")]
)
def test_where_a_round_lands_depends_on_who_observes(klass: int, more: str) -> None:
    """Section 9: correction class 0 nobody looks, 1 an own piece looks there, 2 it sees an enemy there."""
    wall = "cell 0301 0302 0303 0304 0305 0306 0307 0308 0309 elev 200\n"
    places: Counter[str] = Counter()
    for seed in range(300):
        game = bombard(BATTERY + wall + more, seed=seed)
        landing = of_kind(game.advance(150), "mortar_landed")[0]
        places["hit" if landing.hit else "in the cell" if landing.cell == "0905" else "elsewhere"] += 1
    table = default_rules().table("scatter")
    dice = {roll: 6 - abs(roll - 7) for roll in range(2, 13)}
    found = {roll: table.at(klass, roll, 0) for roll in dice}
    chances = {
        "hit": sum(dice[r] for r, n in found.items() if n == -1),
        "in the cell": sum(dice[r] for r, n in found.items() if n == 0),
        "elsewhere": sum(dice[r] for r, n in found.items() if n > 0),
    }
    for place, chance in chances.items():
        assert places[place] / 300 == pytest.approx(chance / 36, abs=0.1), place


def test_the_observers_chances_are_shown_with_the_order() -> None:
    """Section 4: a mortar order is listed with its chances."""
    game = Game.from_text(BATTERY + "blue chariot 0905\n")
    orders = {o.cell: o for o in game.legal_orders("red", "chariot0") if isinstance(o, IndirectShoot)}
    assert orders["0905"].chances is not None
    assert orders["0905"].chances.hit == pytest.approx(30 / 36)
    assert orders["0906"].chances is not None
    assert orders["0906"].chances.hit == pytest.approx(24 / 36)


def test_a_scattered_round_stays_on_the_map() -> None:
    """Section 9: n cells away, or the last playable cell on that ray; judged as off target."""
    wall = "cell 0301 0302 0303 0304 0305 0306 0307 0308 0309 elev 200\n"
    cells = set()
    for seed in range(200):
        game = bombard(BATTERY + wall, "0901", seed)
        landing = of_kind(game.advance(150), "mortar_landed")[0]
        hexmap = game.world.scenario.hexmap
        here, there = hexmap.parse_cell("0901"), hexmap.parse_cell(str(landing.cell))
        assert cells_apart(game.world.cells, here, there) <= 1
        assert not (landing.hit and here != there)
        cells.add(landing.cell)
    assert len(cells) == 5, "four neighbours on the map's edge, and the cell"


@pytest.mark.parametrize("hit", [True, False])
@pytest.mark.parametrize("camp", ["red", "blue"])
def test_everybody_in_the_cell_is_judged_own_pieces_too(camp: str, *, hit: bool) -> None:
    """Section 9: raw by two dice, light gun column, correction by one die."""
    for n in range(6):
        game, events = landed(BATTERY + f"{camp} soldier 0905", hit=hit, n=n)
        judged = of_kind(events, "mortar_judged")
        assert [event.target for event in judged] == [f"{camp}:soldier0"]
        event = judged[0]
        assert event.raw == BURST[hit][int(event.roll or 0)]
        modified = int(event.correction_roll or 0) + int(event.modifiers or 0)
        correction = -2 if modified <= 1 else -1 if modified <= 4 else 0 if modified <= 7 else 1
        assert event.correction == correction
        assert event.result == max(-1, int(event.raw or 0) + correction)
        assert game.tick == 150


@pytest.mark.parametrize(
    ("rule", "modifiers", "piece", "more"),
    [
        ("no armour +1", 1, "soldier 0905", ""),
        ("composite armour -3", -3, "tank 0905", ""),
        ("medium armour 0", 0, "chariot 0905", ""),
        ("concealed -2", -1, "soldier 0905", "cell 0905 concealed"),
        ("hidden -2", -1, "soldier 0905 hidden", ""),
        ("a soldier in motion +2", 3, "soldier 0905 moving 1005", "cell 1005 elev 70"),
        ("a vehicle in motion 0", 0, "chariot 0905 moving 1005", "cell 1005 slushy elev 50"),
        ("stacked +2", 3, "soldier 0905", "red soldier 0905"),
    ],
)
def test_the_burst_has_its_modifiers(rule: str, modifiers: int, piece: str, more: str) -> None:
    """Section 9, correction; three guns at launch: 0."""
    _, events = landed(BATTERY + f"red {piece}\n{more}", hit=True)
    assert of_kind(events, "mortar_judged")[0].modifiers == modifiers, rule


@pytest.mark.parametrize(("blood", "modifiers"), [(1, -4), (2, -2), (3, 0)])
def test_fewer_guns_hurt_less(blood: int, modifiers: int) -> None:
    """Section 9: guns = blood at launch."""
    board = BATTERY.replace("0105", f"0105 blood {blood}") + "red chariot 0905"
    _, events = landed(board, hit=True)
    assert of_kind(events, "mortar_judged")[0].modifiers == modifiers


def test_passengers_and_aerocraft_are_not_judged() -> None:
    """Section 9: ground pieces in the cell, not aboard."""
    board = BATTERY + "blue chariot 0905\nblue soldier aboard chariot0\nblue aerocraft 0905"
    _, events = landed(board, hit=True)
    assert [event.target for event in of_kind(events, "mortar_judged")] == ["blue:chariot0"]


def test_whoever_enters_a_burst_is_judged_once() -> None:
    """Section 9: once per burst, with the landing's class; going out and in again changes nothing."""
    game, _ = landed(BATTERY + "red tank 1005\nred aerocraft 1105", hit=True)
    game.submit("red", [Move("tank0", ["0905", "1005", "0905"]), Move("aerocraft0", ["1005", "0905"])])
    judged = of_kind(game.advance(80), "mortar_judged")
    assert [(event.target, event.tick, event.hit) for event in judged] == [("red:tank0", 170, True)]


def test_a_piece_that_stands_there_since_the_landing_is_not_judged_again() -> None:
    """Section 9: neither by staying nor by coming back."""
    game, _ = landed(BATTERY + "red tank 0905", hit=True)
    game.submit("red", Move("tank0", ["1005", "0905"]))
    assert not of_kind(game.advance(100), "mortar_judged")


def test_arriving_in_the_step_of_the_landing_counts_as_entering() -> None:
    """Section 9: also in the step of the landing, after it."""
    for seed in range(500):
        game = bombard(BATTERY + "red tank 1005", seed=seed)
        game.advance(130)
        game.submit("red", Move("tank0", ["0905"]))
        events = game.advance(20)
        if of_kind(events, "mortar_landed")[0].cell == "0905":
            assert [(e.target, e.tick) for e in of_kind(events, "mortar_judged")] == [("red:tank0", 150)]
            return
    raise AssertionError


def test_getting_off_in_a_burst_counts_as_entering() -> None:
    """Section 9."""
    for n in range(20):
        game, _ = landed(BATTERY + "red chariot 0905\nred soldier aboard chariot1", hit=True, n=n)
        if game.why_illegal("red", GetOff("chariot1", "soldier0")) is None:
            game.submit("red", GetOff("chariot1", "soldier0"))
            judged = of_kind(game.advance(80), "mortar_judged")
            assert [(event.target, event.tick) for event in judged] == [("red:soldier0", 225)]
            return
    raise AssertionError


def test_a_burst_that_has_ended_hurts_nobody() -> None:
    """Section 9: burst until end_at."""
    game, _ = landed(BATTERY + "red tank 1005", hit=True)
    game.advance(300)
    game.submit("red", Move("tank0", ["0905"]))
    assert not of_kind(game.advance(30), "mortar_judged")
