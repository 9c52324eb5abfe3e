"""What holds for every scripted player in every game (bots.md)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from hexwar_sb3.bots.act import bot_act
from hexwar_sb3.bots.registry import BOTS
from hexwar_sb3.bots.weigh import known_lead
from hexwar_sb3.engine.codes import Code
from hexwar_sb3.maps.spec import STANDARD
from hexwar_sb3.play.match import play_games
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.rules.enums import Action, Camp, PieceType
from hexwar_sb3.rules.indices import CampIndex

if TYPE_CHECKING:
    from hexwar_sb3.play.arena import Arena
    from tests.bots.conftest import BotGames

    Games = Callable[..., BotGames]

FULL = ("MA1", "MA2")


def think(arena: Arena, camp: int) -> dict[str, np.ndarray]:
    """What a player decides in game 0 as it stands: its missions, its orders and its brain; nothing is kept."""
    before = arena.snapshot()
    state, world = arena.state, arena.world
    state.orders[0].kind = Action.NULL
    bot_act(
        arena.drives[0].seat[camp], CampIndex(camp), state.games[0], state.pieces[0], state.memory[0], state.rounds[0],
        state.orders[0], arena.missions[0], arena.brains[0],
        world.rules[0], world.cells, world.los, world.eta, arena.atlas[0],
    )  # fmt: skip
    own = world.side(camp)
    decided = {
        "missions": arena.missions[0, own].copy(),
        "orders": state.orders[0, own].copy(),
        "brain": arena.brains[0, camp].copy(),
    }
    arena.restore(before)
    return decided


@pytest.mark.parametrize("player", BOTS)
@pytest.mark.parametrize("camp", [Camp.RED, Camp.BLUE])
def test_what_a_player_cannot_know_changes_nothing_that_it_decides(
    player: str, camp: Camp, bot_games: Games, scramble: Callable[..., None]
) -> None:
    games = bot_games(*((player, "MA1") if camp == Camp.RED else ("MA1", player)))
    rng = np.random.default_rng(0)
    seen_something = False
    for _ in games.thoughts():
        plain = think(games.arena, camp)
        before = games.arena.snapshot()
        scramble(games.arena, 0, camp, rng)
        for secret in ("seed", "salt"):  # of the dice; the random player's own choices are drawn with them
            games.arena.state.games[secret] = before["games"][secret]
        scrambled = think(games.arena, camp)
        games.arena.restore(before)
        assert all(np.array_equal(plain[key], scrambled[key]) for key in plain)
        seen_something = seen_something or bool(games.arena.state.memory[0, camp].seen.any())
    assert seen_something or player == "random"


@pytest.mark.parametrize("scenario", STANDARD)
@pytest.mark.parametrize("red", [*FULL, "nearest", "two-hold", "drawn", "drawn-unseen"])
def test_the_mirrored_game_is_the_mirrored_game(scenario: str, red: str, bot_games: Games) -> None:
    """Colours and the dice's salts changed over: every margin changes over too."""
    one, other = bot_games(red, "MA2", scenario, games=4), bot_games("MA2", red, scenario, games=4)
    salts = other.arena.state.games.salt
    salts[:] = salts[:, ::-1].copy()
    one.played_out(), other.played_out()
    assert one.margins(Camp.RED) == other.margins(Camp.BLUE)
    assert one.arena.state.games.tick.tolist() == other.arena.state.games.tick.tolist()


@pytest.mark.parametrize("player", BOTS)
def test_a_player_has_no_memory_of_earlier_games(player: str, bot_games: Games) -> None:
    alone = bot_games(player, "MA1", games=1).played_out().margins(Camp.RED)
    assert bot_games(player, "MA1", games=3).played_out().margins(Camp.RED)[:1] == alone


def test_the_random_player_orders_only_what_is_legal(bot_games: Games) -> None:
    games = bot_games("random", "random")
    arena, ordered = games.arena, 0
    for _ in games.thoughts():
        for camp in Camp.RED, Camp.BLUE:
            ordered += int((think(arena, camp)["orders"]["kind"] != Action.NULL).sum())
        assert np.isin(arena.state.orders[0].code, [Code.OK]).all()
    assert ordered > 100


@pytest.mark.parametrize("player", FULL)
def test_a_full_player_uses_every_action(player: str) -> None:
    """Of the eleven; the null action is what a piece without an order does."""
    actions = np.concatenate(
        [
            play_games(player, "nearest", 60, Terms(scenario=name), seed=1).actions[:, Camp.RED]
            for name in STANDARD
        ]
    )
    used = (actions > 0).mean(axis=0)
    assert (used[1:] > 0).all(), dict(zip(Action, used, strict=True))


@pytest.mark.parametrize("player", FULL)
def test_a_held_point_keeps_a_guard_while_a_soldier_is_there(player: str, bot_games: Games) -> None:
    guarded = 0
    games = bot_games(player, "random")
    for _ in games.thoughts():
        arena = games.arena
        game, pieces, brain = arena.state.games[0], arena.state.pieces[0], arena.brains[0, Camp.RED]
        if brain.thoughts == 0:
            continue
        for k in range(game.n_points):
            slot = brain.keeper[k]
            if slot >= 0:
                guarded += 1
                assert game.point_owner[k] == Camp.RED
                assert pieces[slot].kind == PieceType.SOLDIER
                assert arena.missions[0, slot].cell == game.point_cell[k] or pieces[slot].blood == 0
    assert guarded > 0


@pytest.mark.parametrize("player", FULL)
def test_a_player_that_is_behind_near_the_end_rushes_the_points(player: str, bot_games: Games) -> None:
    rushed: list[bool] = []
    for opponent in ("MA1", "MA2", "nearest"):
        games = bot_games(player, opponent, "hills")
        arena: Any = games.arena
        for tick in games.thoughts():
            state = arena.state
            lead = known_lead(
                Camp.RED, state.games[0], state.pieces[0], state.memory[0], arena.world.rules[0]
            )
            brain = think(arena, Camp.RED)["brain"]
            assert bool(brain["rush"]) == (tick >= arena.atlas[0].config.endgame_tick and lead < 0)
            rushed.append(bool(brain["rush"]))
    assert set(rushed) == {True, False}, (
        "the games must show both cases, or the comparison above proved little"
    )
