"""The hash of the scripted players names what they do: a comment changes nothing, another move does.

`python tests/bots/test_hash.py` prints the digests that `hexwar_sb3/bots/config.py` records.
"""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

from hexwar_sb3.bots import config
from hexwar_sb3.bots.config import DRAWN_GAMES, GAMES, bots_hash, drawn_hash
from hexwar_sb3.bots.registry import BOTS, FAMILIES
from hexwar_sb3.maps.spec import STANDARD
from hexwar_sb3.play.match import play_games
from hexwar_sb3.players.terms import Terms


def digest_of(players: list[str]) -> str:
    """Digest of two games of each pair, each map: margins, lengths, and orders by kind."""
    digest = hashlib.sha256()
    for scenario in STANDARD:
        for player in players:
            for opponent in ("MA1", "MA2"):
                games = play_games(player, opponent, 2, Terms(scenario=scenario), seed=7)
                for array in (games.margins, games.ticks, games.actions):
                    digest.update(np.ascontiguousarray(array, "<i8").tobytes())
    return digest.hexdigest()[:16]


def digests() -> tuple[str, str]:
    """Of the players one by one, and of the families."""
    return digest_of([name for name in BOTS if name not in FAMILIES]), digest_of(list(FAMILIES))


def test_the_players_do_what_their_hash_says() -> None:
    assert digests() == (GAMES, DRAWN_GAMES)


def test_version_1_keeps_the_hash_under_which_its_results_were_published(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert bots_hash() == "7f6e55ae39a679b8"
    drawn = drawn_hash()
    monkeypatch.setattr(config, "GAMES", "another behaviour")
    monkeypatch.setattr(config, "DRAWN_GAMES", "another behaviour")
    assert bots_hash() != "7f6e55ae39a679b8"
    assert drawn_hash() != drawn


if __name__ == "__main__":
    print("GAMES, DRAWN_GAMES =", digests())  # noqa: T201  # for who runs it
