"""Fog: a camp's view holds what it may know, and nothing else (rule book, section 6)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.legal import Advisor
from hexwar_sb3.engine.orders import Order, Shoot
from hexwar_sb3.engine.records import NEVER, NO_PIECE, ROUND_FLYING
from hexwar_sb3.engine.roster import Roster, camp_name, enemy_of
from hexwar_sb3.engine.sight import look_all
from hexwar_sb3.engine.state import State, new_state
from hexwar_sb3.engine.view import side_view
from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.rules.enums import Camp

Play = Callable[..., State]


def knowledge(camp: Camp, state: State, world: World) -> str:
    """Everything that a camp is told: its view and its pieces' legal orders with their chances."""
    game, pieces, memory, *_ = state.game(0)
    advisor = Advisor(camp, game, pieces, memory, world)
    orders = [
        f"{order} {getattr(order, 'chances', None)}"
        for i in Roster(world.scenario).pieces_of(camp)
        for order in advisor.legal_orders(i)
    ]
    return repr((side_view(camp, state, 0, world), orders))


def change_the_unknown(camp: Camp, state: State, world: World, rng: np.random.Generator) -> int:
    """Change at random what the camp can neither see nor remember; how many enemies that touches."""
    game, _, memory, paths, rounds, *_ = state.game(0)
    roster, enemy = Roster(world.scenario), enemy_of(camp)
    unseen = [i for i in roster.pieces_of(enemy) if not memory[camp, i].seen]
    for i in unseen:
        change_piece(i, camp, state, world, rng)
        paths[i] = rng.integers(0, 6, paths.shape[1])
    memory[enemy].cell = 0
    game.seed, game.salt[:] = rng.integers(0, 2**63), rng.integers(0, 2**63, 2)
    game.loss_tick[enemy] = game.contact_tick[enemy] = 3
    for shell in rounds:
        if shell.camp == enemy and shell.status == ROUND_FLYING:
            shell.cell, shell.hit = 40, 1
    state.orders[0, list(roster.pieces_of(enemy))].kind = 1
    return len(unseen)


def change_piece(i: int, camp: Camp, state: State, world: World, rng: np.random.Generator) -> None:
    pieces, (rules, cells, los) = state.pieces[0], world.tables
    piece = pieces[i]
    piece.blood = rng.integers(0, 4)
    piece.hidden, piece.suppressed = rng.integers(0, 2, 2)
    piece.cool_ends = rng.choice([NEVER, 1700])
    piece.ammo[:] = rng.integers(0, 9, piece.ammo.size)
    old, piece.cell = int(piece.cell), rng.choice(np.flatnonzero(cells.passable))
    trial = pieces.copy()
    look_all(trial, rules, cells, los)
    known = np.bitwise_or.reduce(trial.sees[pieces.camp == camp])
    if (
        int(known) >> int(piece.slot) & 1
        or piece.carrier != NO_PIECE
        or any(pieces[j].cell == piece.cell for j in range(pieces.size) if j != i)
    ):
        piece.cell = old
        piece.hidden = 1 if piece.carrier == NO_PIECE else piece.hidden


@pytest.mark.parametrize("name", ["small", "plain", "hills"])
@pytest.mark.parametrize("camp", [Camp.RED, Camp.BLUE])
def test_what_a_camp_cannot_see_or_remember_changes_nothing_it_is_told(
    camp: Camp, name: str, small_world: World, play_randomly: Play
) -> None:
    """Section 6, byte for byte; over random positions."""
    world = small_world if name == "small" else load_world(name)
    touched = 0
    for seed in range(12):
        rng = np.random.default_rng(seed)
        state = play_randomly(world, seed, until=int(rng.integers(1, 900)), every=40)
        before = knowledge(camp, state, world)
        for _ in range(3):
            other = new_state(world, 1)
            other.copy_from(state, 0, 0)
            touched += change_the_unknown(camp, other, world, rng)
            assert knowledge(camp, other, world) == before, (seed, camp_name(camp))
    assert touched > 0


def test_an_unseen_piece_beside_a_target_does_not_show_in_the_chances() -> None:
    """Section 6: a listed order uses the camp's own knowledge only; the shot itself is stacked."""
    board = "map plain-20x3\ncell 0902 concealed\nred tank 0102\nblue tank 0902\n"
    chances = []
    for hidden in ("", "blue soldier 0902 hidden"):
        game = Game.from_text(board + hidden)
        assert len(game.view("red").seen) == 1
        chances.append([o.chances for o in game.legal_orders("red", "tank0") if isinstance(o, Shoot)])
    assert chances[0] == chances[1]
    order: Order = Shoot("tank0", "tank0", "GUN")
    game.submit("red", order)
    assert [event.modifiers for event in game.advance(1) if event.kind == "shot"] == [0], "-2 and +2"


def test_a_view_shows_own_pieces_in_full() -> None:
    """Section 6: timers as ticks left, cold_down the longest of them."""
    game = Game.from_text(
        "map plain-20x3\nred chariot 0102 cool 30 mortar_cool 200 suppressed hidden\nblue tank 0902"
    )
    own = game.view("red").own[0]
    assert (own.cool_left, own.mortar_cool_left, own.suppressed_left, own.cold_down) == (30, 200, 149, 200)
    assert (own.hidden, own.suppressed, own.sees) == (True, True, ("blue:tank0",))


def test_a_view_is_plain_values_for_a_file() -> None:
    view = Game("plain").view("blue")
    plain = view.as_dict()
    assert set(plain) == set(view.__dataclass_fields__) - {"hexmap"}
    assert plain["points"][0] == {"name": "main", "cell": "3635", "value": 80, "owner": "green"}
    assert len(plain["own"]) == 7
