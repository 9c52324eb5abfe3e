"""Moving, stopping and stacking (rule book, sections 1, 4, 5.6 and 13)."""

from __future__ import annotations

import pytest

from hexwar_sb3.engine.codes import Event
from hexwar_sb3.engine.dice import priority
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import GameEvent, of_kind
from hexwar_sb3.engine.movement import arrive, start_hops
from hexwar_sb3.engine.orders import Decompress, Hide, Move, Shoot, Stop
from hexwar_sb3.engine.pieces import in_motion
from hexwar_sb3.engine.records import NEVER, NO_PIECE
from hexwar_sb3.maps.geometry import NE, E, W


def arrivals(events: list[GameEvent], piece: str) -> list[tuple[str | None, int]]:
    return [(event.cell, event.tick) for event in of_kind(events, "arrived") if event.piece == piece]


@pytest.mark.parametrize(
    ("rule", "ticks", "kind", "cells"),
    [
        ("a vehicle needs 20 s a cell", 20, "tank", ""),
        (
            "a road takes 20 s over any ground",
            20,
            "chariot",
            "cell 0101 0201 paved elev 0\ncell 0201 slushy concealed",
        ),
        ("a road up a hill takes 20 s", 20, "tank", "cell 0101 0201 paved\ncell 0201 elev 50"),
        ("one paved cell is no road", 40, "tank", "cell 0201 paved concealed"),
        ("forest doubles the time", 40, "tank", "cell 0201 concealed"),
        ("marsh takes four times as long", 80, "tank", "cell 0201 slushy"),
        ("marsh counts before forest", 80, "tank", "cell 0201 slushy concealed"),
        ("one level of slope costs nothing", 20, "tank", "cell 0201 elev 10"),
        ("three levels of slope take three times as long", 60, "tank", "cell 0201 elev 30"),
        ("downhill is as slow as uphill", 60, "tank", "cell 0101 elev 30"),
        ("slope and marsh multiply", 400, "tank", "cell 0201 elev 50 slushy"),
        ("a soldier needs 144 s a cell", 144, "soldier", "cell 0201 slushy elev 60"),
        ("a soldier needs twice the time above 60 m", 288, "soldier", "cell 0201 elev 70"),
        ("an aerocraft needs 8 s a cell", 8, "aerocraft", "cell 0201 elev 90 slushy blocked"),
    ],
)
def test_a_hop_takes_its_time(rule: str, ticks: int, kind: str, cells: str) -> None:
    """Section 1, hop time."""
    game = Game.from_text(f"map plain-5x5\n{cells}\nred {kind} 0101\nblue tank 0505")
    game.submit("red", Move(f"{kind}0", ["0201"]))
    assert arrivals(game.advance(400), f"red:{kind}0") == [("0201", ticks)], rule


def test_a_path_is_one_order_of_many_hops() -> None:
    """Section 4, move; every hop takes its own time."""
    game = Game.from_text("map plain-5x5\ncell 0301 concealed\nred tank 0101\nblue tank 0505")
    game.submit("red", Move("tank0", ["0201", "0301", "0401"]))
    assert arrivals(game.advance(100), "red:tank0") == [("0201", 20), ("0301", 60), ("0401", 80)]


def test_a_natural_stop_lasts_75_s_and_a_new_move_may_follow_at_once() -> None:
    """Section 13: chained one-hop moves cost no delay."""
    game = Game.from_text("map plain-5x5\nred tank 0101\nblue tank 0505")
    game.submit("red", Move("tank0", ["0201"]))
    game.advance(20)
    assert game.view("red").piece("tank0").stop_left == 74  # set to 75 in the step before
    game.submit("red", Move("tank0", ["0301"]))
    assert arrivals(game.advance(20), "red:tank0") == [("0301", 40)]
    game.advance(73)
    assert in_motion(game.pieces[0])
    game.advance(1)
    assert not in_motion(game.pieces[0])


def test_a_piece_that_starts_to_move_is_no_longer_hidden() -> None:
    """Section 4, move: hidden off."""
    game = Game.from_text("map plain-5x5\nred tank 0101 hidden\nblue tank 0505")
    game.submit("red", Move("tank0", ["0201"]))
    game.advance(1)
    assert not game.view("red").piece("tank0").hidden


def test_a_stop_in_the_first_half_of_a_hop_turns_the_piece_back() -> None:
    """Section 4, stop: it stands in its cell at once, in a forced transition."""
    game = Game.from_text("map plain-5x5\nred tank 0101 moving 0201 0301\nblue tank 0505")
    game.advance(9)
    game.submit("red", Stop("tank0"))
    game.advance(1)
    tank = game.view("red").piece("tank0")
    assert (tank.cell, tank.path, tank.stop_left) == ("0101", (), 74)
    why = "red tank0 is stopping for 74 more s; until then it can only occupy"
    assert game.why_illegal("red", Hide("tank0")) == why
    assert arrivals(game.advance(74), "red:tank0") == []
    assert game.why_illegal("red", Hide("tank0")) is None


def test_a_stop_in_the_second_half_of_a_hop_finishes_it() -> None:
    """Section 4, stop: the rest of the path is dropped; then a forced transition."""
    game = Game.from_text("map plain-5x5\nred tank 0101 moving 0201 0301\nblue tank 0505")
    game.advance(10)
    game.submit("red", Stop("tank0"))
    assert arrivals(game.advance(10), "red:tank0") == [("0201", 20)]
    assert game.why_illegal("red", Move("tank0", ["0301"])) is not None
    game.advance(74)
    assert game.why_illegal("red", Move("tank0", ["0301"])) is None


def test_a_stop_in_a_cell_on_the_way_stands_at_once() -> None:
    """Section 4, stop: nothing of the next hop is done yet."""
    game = Game.from_text("map plain-5x5\nred tank 0101 moving 0201 0301\nblue tank 0505")
    game.advance(20)
    game.submit("red", Stop("tank0"))
    assert arrivals(game.advance(100), "red:tank0") == []
    assert game.view("red").piece("tank0").cell == "0201"


FULL = "map plain-7x3\nred tank 0301\nred tank 0301\nred tank 0301\nred tank 0301\nblue tank 0703\n"


def test_a_piece_waits_before_a_cell_that_holds_four_of_its_camp() -> None:
    """Section 5.6: it starts when one of them has left."""
    game = Game.from_text(FULL + "red tank 0201 moving 0301")
    assert arrivals(game.advance(60), "red:tank4") == []
    assert game.view("red").piece("tank4").speed == 0
    game.submit("red", Move("tank0", ["0401"]))
    assert arrivals(game.advance(60), "red:tank4") == [("0301", 60 + 20 + 20)]


def test_a_waiting_piece_that_stops_stands_in_a_natural_transition() -> None:
    """Section 4, stop: a piece waiting at progress 0."""
    game = Game.from_text(FULL + "red tank 0201 moving 0301")
    game.advance(30)
    game.submit("red", Stop("tank4"))
    game.advance(1)
    assert game.view("red").piece("tank4").stop_left == 74
    assert game.why_illegal("red", Hide("tank4")) is None


def test_a_piece_that_finds_its_cell_full_at_the_end_of_a_hop_starts_the_hop_again() -> None:
    """Section 5.6: two arrive for one place; the other gets progress 0 and waits."""
    game = Game.from_text("""
        map plain-7x3
        red tank 0301
        red tank 0301
        red tank 0301
        red tank 0201 moving 0301
        red tank 0401 moving 0301
        blue tank 0703
    """)
    first = of_kind(game.advance(40), "arrived")
    assert [(event.cell, event.tick) for event in first] == [("0301", 20)]
    loser = ({"red:tank3", "red:tank4"} - {first[0].piece}).pop()
    game.submit("red", Move("tank0", ["0302"]))
    assert arrivals(game.advance(60), loser) == [("0301", 40 + 20 + 20)]


def test_pieces_follow_each_other_through_a_full_cell_in_one_tick() -> None:
    """Section 5.6: repeated passes; whoever leaves makes room for whoever arrives."""
    game = Game.from_text(FULL + "red tank 0201")
    game.submit("red", [Move("tank0", ["0401"])])
    game.advance(1)
    with game.edit() as state:
        state["red:tank0"].cell = "0401"
        state["red:tank4"].path = ["0301", "0401"]
    events = game.advance(40)
    assert arrivals(events, "red:tank4") == [("0301", 21), ("0401", 41)]


def test_a_piece_on_its_way_stands_in_its_old_cell() -> None:
    """Section 13: it is judged there until it arrives."""
    game = Game.from_text("map plain-5x5\nred tank 0101 moving 0201\nblue tank 0505")
    game.advance(19)
    assert game.view("red").piece("tank0").cell == "0101"
    game.advance(1)
    assert game.view("red").piece("tank0").cell == "0201"


def test_two_enemies_that_move_into_each_others_cells_pass() -> None:
    """Section 13: no fight unless they end in one cell."""
    game = Game.from_text("map plain-5x5\nred tank 0101 moving 0201\nblue tank 0201 moving 0101")
    events = game.advance(20)
    assert [event.kind for event in events] == ["arrived", "arrived"]
    assert (game.view("red").own[0].cell, game.view("blue").own[0].cell) == ("0201", "0101")


def test_aerocraft_do_not_count_for_stacking_and_do_not_fight_hand_to_hand() -> None:
    """Section 13, aerocraft."""
    game = Game.from_text(
        FULL + "red aerocraft 0201 moving 0301\nblue aerocraft 0401 moving 0301\nred tank 0103"
    )
    events = game.advance(8)
    assert [(event.kind, event.cell) for event in events] == [("arrived", "0301")] * 2


def test_a_path_that_has_become_impossible_is_cut() -> None:
    """Section 13: natural stop, event path_blocked."""
    game = Game.from_text("map plain-5x5\ncell 0401 blocked\nred tank 0101 moving 0201 0301\nblue tank 0505")
    game.state.paths[0, 0, 1] = 4  # north-east, off the map
    events = game.advance(30)
    assert [(event.kind, event.tick) for event in events] == [("arrived", 20), ("path_blocked", 20)]
    assert game.view("red").piece("tank0").doing == "stopping"
    assert game.why_illegal("red", Hide("tank0")) is None


def test_a_tank_fires_its_gun_on_the_move_in_a_natural_stop_and_while_it_hides() -> None:
    """Section 4, shoot: the three states besides settled."""
    board = "map plain-5x5\nred tank 0101\nblue soldier 0303"
    shot = Shoot("tank0", "soldier0", "GUN")
    for word in ("moving 0102", "stopping"):
        assert (
            Game.from_text(board.replace("tank 0101", f"tank 0101 {word}")).why_illegal("red", shot) is None
        )
    game = Game.from_text(board)
    game.submit("red", Hide("tank0"))
    game.advance(30)
    assert game.why_illegal("red", shot) is None
    game.submit("red", shot)
    game.advance(200)
    assert not game.view("red").piece("tank0").hidden, "own fire cancels hiding"


def test_hiding_takes_75_s_and_may_begin_in_a_natural_stop() -> None:
    """Section 4, hide."""
    game = Game.from_text("map plain-5x5\nred tank 0101 stopping\nblue tank 0505")
    game.submit("red", Hide("tank0"))
    game.advance(74)
    assert not game.view("red").piece("tank0").hidden
    assert [event.kind for event in game.advance(1)] == ["hidden"]
    assert game.view("red").piece("tank0").hidden


def test_a_new_move_ends_the_natural_stop_transition() -> None:
    """Section 13: a new move may begin in it at once."""
    game = Game.from_text("map plain-5x5\nred tank 0101 stopping\nblue tank 0505")
    game.submit("red", Move("tank0", ["0201"]))
    game.advance(1)
    assert game.view("red").piece("tank0").stop_left == 0
    assert game.pieces[0].stop_forced == 0


def test_whoever_decompresses_before_a_full_cell_sets_out_when_it_is_free() -> None:
    """Section 4, decompress: it takes its time, room or not."""
    game = Game.from_text(FULL + "red tank 0201 suppressed moving 0301")
    game.advance(1)
    game.submit("red", [Decompress("tank4"), Move("tank0", ["0401"])])
    assert arrivals(game.advance(200), "red:tank4") == [("0301", 76 + 20)]


def test_whoever_waits_is_marked_until_it_sets_out() -> None:
    """Section 5.6: for room, or for the end of suppression."""
    game = Game.from_text(FULL + "red tank 0201 moving 0301")
    game.advance(5)
    assert game.pieces[4].waiting == 1
    game.submit("red", Move("tank0", ["0401"]))
    game.advance(21)
    assert (game.pieces[4].waiting, game.pieces[4].arrives_at) == (0, 5 + 20 + 20)
    game = Game.from_text("map plain-9x5\nred soldier 0103 suppressed moving 0203\nblue tank 0903")
    record, pieces, _, paths, _, _, log = game.state.game(0)
    pieces[0].waiting = 0
    start_hops(0, record, pieces, paths, log, *game.world.tables[:2])
    assert (pieces[0].waiting, pieces[0].arrives_at) == (1, NEVER)


def test_dice_say_who_of_two_comes_into_the_last_place() -> None:
    """Sections 5.6 and 11: in the order of dice by tick and piece."""
    winners = set()
    for tick in range(20):
        game = Game.from_text(
            "map plain-7x3\nred tank 0301\nred tank 0301\nred tank 0301\nred tank 0201\nred tank 0401\nblue tank 0703"
        )
        record, pieces, place = game.state.games[0], game.pieces, int(game.pieces[0].cell)
        record.tick = tick
        set_out(game, 3, E)
        set_out(game, 4, W)
        first = 3 if priority(record, tick, pieces[3]) < priority(record, tick, pieces[4]) else 4
        assert let_arrive(game) == 1 << first
        assert (pieces[first].cell, pieces[7 - first].waiting) == (place, 1)
        winners.add(first)
    assert winners == {3, 4}


def test_a_full_cell_has_room_for_as_many_as_leave_it_whoever_comes_first() -> None:
    """Section 5.6: repeated passes."""
    for tick in range(20):
        game = Game.from_text(FULL + "red tank 0201")
        game.state.games[0].tick = tick
        set_out(game, 4, E)
        set_out(game, 0, E)
        assert let_arrive(game) == 0b10001


def test_nothing_of_a_path_is_left_at_its_end() -> None:
    """Section 4, stop: the next move ends in a natural transition again."""
    game = Game.from_text("map plain-5x5\nred tank 0101 moving 0201 0301\nblue tank 0505")
    game.advance(15)
    game.submit("red", Stop("tank0"))
    game.advance(5)
    tank = game.pieces[0]
    assert (tank.stop_forced, tank.stop_pending, tank.path_pos, tank.path_len) == (1, 0, 0, 0)


def test_an_arrival_and_a_blocked_path_are_events_with_their_place() -> None:
    """Sections 5.6 and 13; nothing else is told."""
    game = Game.from_text("map plain-5x5\nred tank 0101\nblue tank 0505")
    record, pieces, _, paths, _, _, log = game.state.game(0)
    set_out(game, 0, E)
    let_arrive(game)
    set_out(game, 0, NE)
    pieces[0].arrives_at = NEVER
    start_hops(1, record, pieces, paths, log, *game.world.tables[:2])
    assert [int(row.event) for row in log[: record.log_count]] == [Event.ARRIVED, Event.PATH_BLOCKED]
    for row in log[: record.log_count]:
        assert (row.a, row.b, row.cell, row.extra) == (0, NO_PIECE, pieces[0].cell, 0)


def set_out(game: Game, i: int, direction: int) -> None:
    """Put a piece at the end of a hop."""
    piece = game.pieces[i]
    piece.path_pos, piece.path_len, piece.hop_need = 0, 1, 20
    piece.arrives_at = game.state.games[0].tick + 1
    game.state.paths[0, i, 0] = direction


def let_arrive(game: Game) -> int:
    """Bits of the pieces that end their hops in the present step."""
    record, pieces, _, paths, _, _, log = game.state.game(0)
    pieces.came_now = pieces.changed_now = 0
    arrived = arrive(record, pieces, paths, log, *game.world.tables[:2])
    assert (pieces.came_now == pieces.changed_now).all()
    assert arrived == pieces.came_now.any()
    return sum(1 << i for i in range(pieces.size) if pieces[i].came_now)
