from __future__ import annotations

import pytest

from hexwar_sb3.bots.config import bots_hash
from hexwar_sb3.play.match import play_games
from hexwar_sb3.play.recording import record_game


@pytest.mark.parametrize("seed", range(8))
def test_a_recorded_game_of_bots_is_verified(seed: int) -> None:
    """A jump to the end of the game is no reason for another state (seed 2000000 once was)."""
    record_game("MA1", "MA2", seed=2_000_000 + seed).verify()


def test_a_recorded_game_is_the_game_of_the_match() -> None:
    match = play_games("MA2", "MA1", 2, seed=5)

    replay = record_game("MA2", "MA1", seed=5, episode=1)

    assert replay.end["margin"]["red"] == match.margins[1, 0]
    assert replay.head["players"]["red"] == {"name": "MA2", "kind": "bot", "hash": bots_hash()}
