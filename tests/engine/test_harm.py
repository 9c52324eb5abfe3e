"""What fire does to whom it hits (rule book, sections 5.4, 7 and 13)."""

from __future__ import annotations

import pytest

from hexwar_sb3.engine.codes import Event
from hexwar_sb3.engine.fire import add_result
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.harm import apply_results
from hexwar_sb3.engine.orders import Hide, IndirectShoot, Move
from hexwar_sb3.engine.records import NEVER, NO_PIECE
from hexwar_sb3.kernels import Rows

SOLDIER = "map plain-9x5\nred soldier 0103{words}\nblue tank 0303"
TANK = "map plain-9x5\nred tank 0103{words}\nblue tank 0303"
CARRIED = "map plain-9x5\nred chariot 0103\nred soldier aboard chariot0\nblue tank 0303"


def at_tick_5(board: str, words: str = "") -> Game:
    game = Game.from_text(board.format(words=words))
    game.advance(5)
    return game


def changed(pieces: Rows) -> int:
    """Bits of the pieces that are to be looked at again, which are then forgotten."""
    bits = sum(1 << i for i in range(pieces.size) if pieces[i].changed_now)
    pieces.changed_now = 0
    return bits


def hit(game: Game, *results: int) -> int:
    """Apply some results to the first piece in the present tick, 0 suppresses, n are losses; bits of the dead."""
    record, pieces, *_, log = game.state.game(0)
    for result in results:
        add_result(pieces[0], result)
    apply_results(record, pieces, log, game.world.tables[0])
    return changed(pieces)


def blood(game: Game) -> list[int]:
    return [int(n) for n in game.pieces.blood]


def logged(game: Game) -> list[tuple[Event, int, int]]:
    """Events that no step has read yet, whom they befell and how much."""
    record, *_, log = game.state.game(0)
    return [(Event(row.event), int(row.a), int(row.extra)) for row in log[: record.log_count]]


@pytest.mark.parametrize(("results", "squads"), [((0,), 2), ((0, 0), 2), ((0, 1), 1), ((1, 1), 1)])
def test_a_suppressed_soldier_that_is_suppressed_again_loses_one_squad(
    results: tuple[int, ...], squads: int
) -> None:
    """Section 5.4: one squad more by the 0s of a tick, however many they are."""
    game = at_tick_5(SOLDIER, " suppressed")
    hit(game, *results)
    assert blood(game)[0] == squads


def test_losses_alone_cost_a_suppressed_soldier_no_squad_more() -> None:
    """Section 5.4: the further squad is lost by a 0, not by losses."""
    game = at_tick_5(SOLDIER, " suppressed")
    hit(game, 1)
    assert blood(game)[0] == 2


def test_a_soldier_that_is_suppressed_twice_in_one_tick_loses_no_squad() -> None:
    """Section 5.4: by fire and then by the burst that it enters; it was not suppressed when the tick began."""
    game = at_tick_5(SOLDIER)
    hit(game, 0)
    hit(game, 0)
    assert blood(game)[0] == 3


def test_the_results_of_a_tick_count_in_that_tick_only() -> None:
    """Section 5.4: what was collected is used up."""
    game = at_tick_5(SOLDIER, " suppressed")
    hit(game, 0)
    game.advance(10)
    hit(game, 1)
    assert blood(game)[0] == 1
    game.advance(10)
    left = game.view("red").piece("soldier0").suppressed_left
    hit(game)
    assert blood(game)[0] == 1
    assert game.view("red").piece("soldier0").suppressed_left == left
    game = at_tick_5(TANK)
    hit(game, 1)
    hit(game, 0)
    assert blood(game)[0] == 2


def test_a_camp_remembers_when_it_lost_something() -> None:
    """bots.md, section 2: a loss is news; suppression is none."""
    game = at_tick_5(TANK)
    hit(game, 0)
    assert game.state.games[0].loss_tick.tolist() == [-1, -1]
    hit(game, 1)
    assert game.state.games[0].loss_tick.tolist() == [6, -1]


def test_only_a_soldier_that_has_not_set_out_is_held_by_suppression() -> None:
    """Section 5.6: the hop under way is finished."""
    for words, arrives in ((" moving 0203", 144), ("", NEVER)):
        game = at_tick_5(SOLDIER, words)
        hit(game, 0)
        assert (game.pieces[0].arrives_at, game.pieces[0].waiting) == (arrives, 0)
    game = Game.from_text(SOLDIER.format(words=" moving 0203"))
    hit(game, 0)
    assert (game.pieces[0].arrives_at, game.pieces[0].waiting) == (NEVER, 1)
    game = Game.from_text(TANK.format(words=" moving 0203"))
    hit(game, 0)
    assert (game.pieces[0].arrives_at, game.pieces[0].waiting) == (20, 0)


def test_the_passenger_of_a_chariot_loses_as_many_squads() -> None:
    """Section 13: n vehicles, n squads; suppression costs it nothing."""
    game = at_tick_5(CARRIED)
    assert hit(game, 0) == 0
    assert blood(game)[:2] == [3, 3]
    assert hit(game, 1) == 0
    assert blood(game)[:2] == [2, 2]


def test_a_passenger_whose_squads_are_all_lost_is_gone_and_its_chariot_empty() -> None:
    """Section 13: min(n, squads); a boarding under way ends with it."""
    game = at_tick_5(CARRIED)
    game.pieces[1].blood = 1
    game.pieces[0].hide_ends = 60
    assert hit(game, 2) == 0b10
    assert blood(game)[:2] == [1, 0]
    assert game.pieces[0].passenger == NO_PIECE
    assert game.pieces[0].hide_ends == NEVER


def test_a_destroyed_chariot_takes_its_passenger_along() -> None:
    """Section 13: destroyed, all."""
    game = at_tick_5(CARRIED)
    assert hit(game, 3) == 0b11
    assert blood(game)[:2] == [0, 0]
    assert (game.pieces[0].passenger, game.pieces[1].carrier) == (NO_PIECE, NO_PIECE)


def test_the_dead_keep_no_timer_no_path_and_no_cover() -> None:
    """Section 13: nothing of a destroyed piece goes on."""
    game = Game.from_text("map plain-20x5\nred chariot 0103\nred soldier 0103\nblue tank 0303")
    game.submit("red", IndirectShoot("chariot0", "0903"))
    game.advance(5)
    chariot = game.pieces[0]
    chariot.hidden = chariot.suppressed = chariot.stop_forced = 1
    chariot.cool_ends = chariot.stop_ends = chariot.keep_ends = 70
    chariot.path_len, chariot.arrives_at = 2, 20
    assert chariot.mortar_ends != NEVER
    hit(game, 3)
    for field in ("cool_ends", "mortar_ends", "stop_ends", "keep_ends", "arrives_at"):
        assert chariot[field] == NEVER, field
    for field in ("hidden", "suppressed", "stop_forced", "path_len", "blood"):
        assert chariot[field] == 0, field


def test_a_piece_that_dies_while_it_hides_does_not_hide() -> None:
    """Section 4, hide: a hit calls it off."""
    game = at_tick_5(TANK)
    game.submit("red", Hide("tank0"))
    game.advance(1)
    hit(game, 3)
    assert game.pieces[0].hide_ends == NEVER
    assert [event.kind for event in game.advance(100)] == []
    assert game.why_illegal("red", Move("tank0", ["0203"])) is not None


def test_a_hit_piece_that_lives_is_suppressed_for_150_s_and_breaks_off_what_it_does() -> None:
    """Sections 3 and 5.4; losses suppress, too."""
    for result in (0, 1):
        game = at_tick_5(TANK)
        game.submit("red", Hide("tank0"))
        game.advance(1)
        hit(game, result)
        tank = game.pieces[0]
        assert (tank.suppressed, tank.keep_ends, tank.hide_ends) == (1, 6 + 150, NEVER)


def test_what_happens_to_a_piece_is_an_event() -> None:
    """Section 5.4: losses, then death or suppression."""
    game = at_tick_5(TANK)
    hit(game, 0)
    assert logged(game) == [(Event.SUPPRESSED, 0, 0)]
    game = at_tick_5(TANK)
    hit(game, 2)
    assert logged(game) == [(Event.LOSS, 0, 2), (Event.SUPPRESSED, 0, 0)]
    game = at_tick_5(TANK)
    hit(game, 4)
    assert logged(game) == [(Event.LOSS, 0, 3), (Event.DEAD, 0, 0)]


def test_what_happens_to_a_passenger_is_an_event() -> None:
    """Section 13: only losses reach it."""
    game = at_tick_5(CARRIED)
    hit(game, 0)
    assert logged(game) == [(Event.SUPPRESSED, 0, 0)]
    game = at_tick_5(CARRIED)
    hit(game, 2)
    assert logged(game)[-1] == (Event.LOSS, 1, 2)


def test_a_suppressed_vehicle_loses_nothing_by_a_0() -> None:
    """Section 5.4 speaks of soldiers only."""
    game = at_tick_5(TANK, " suppressed")
    hit(game, 0)
    assert blood(game)[0] == 3


def test_the_losses_of_a_piece_without_passenger_are_its_own() -> None:
    """Section 13."""
    game = at_tick_5(TANK)
    assert hit(game, 1) == 0
    assert blood(game) == [2, 3]


def test_a_passenger_with_one_squad_left_stays_aboard() -> None:
    """Section 13."""
    game = at_tick_5(CARRIED)
    hit(game, 2)
    assert blood(game)[:2] == [1, 1]
    assert game.pieces[0].passenger == 1
