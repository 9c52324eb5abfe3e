"""What fire does to whom it hits (rule book, sections 5.4, 7 and 13)."""

from __future__ import annotations

from hexwar_sb3.engine.fire import add_result
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.harm import apply_results


def hit(game: Game, piece: int, *results: int) -> None:
    """Apply some results to a piece in the present tick: 0 suppresses, n are losses."""
    record, pieces, *_, log = game.state.game(0)
    for result in results:
        add_result(pieces[piece], result)
    apply_results(record, pieces, log, game.world.tables[0])


def squads_left(*results: int) -> int:
    """Squads of a suppressed soldier after some results of one tick."""
    game = Game.from_text("map plain-9x5\nred soldier 0103 suppressed\nblue tank 0303")
    game.advance(5)
    hit(game, 0, *results)
    return int(game.pieces[0].blood)


def test_a_suppressed_soldier_that_is_suppressed_again_loses_one_squad() -> None:
    """Section 5.4; two results of 0 in one tick cost one squad, too."""
    assert squads_left(0) == 2
    assert squads_left(0, 0) == 2


def test_losses_alone_cost_a_suppressed_soldier_no_squad_more() -> None:
    """Section 5.4: the further squad is lost by a 0, not by losses."""
    assert squads_left(1) == 2
    assert squads_left(0, 1) == 1
