"""Direct fire (rule book, sections 5, 7 and 13)."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from hexwar_sb3.engine.codes import Event
from hexwar_sb3.engine.dice import die, two_dice
from hexwar_sb3.engine.fire import (
    add_result,
    attack_level,
    resolve_shot,
    soldier_correction,
    vehicle_correction,
)
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import GameEvent, of_kind
from hexwar_sb3.engine.orders import GuideShoot, Hide, Move, Order, Shoot
from hexwar_sb3.engine.records import PIECE
from hexwar_sb3.rules import adjudicate
from hexwar_sb3.rules.compiled import NO_EFFECT
from hexwar_sb3.rules.enums import Dice, PieceType, Weapon
from hexwar_sb3.rules.indices import PieceIndex
from hexwar_sb3.rules.tables import ATTACKS

WIDE = "map plain-40x5\n"
NEAR = "map plain-9x5\n"
CLASS = {"tank": "vehicle", "chariot": "vehicle", "soldier": "soldier", "aerocraft": "aerocraft"}
ARMOUR = {"tank": 4, "chariot": 2, "soldier": 0, "aerocraft": 0}


def fire(board: str, order: Order, seed: int = 0) -> tuple[Game, list[GameEvent]]:
    game = Game.from_text(board, seed)
    assert game.submit("red", order) == [None]
    return game, game.advance(1)


def first_shot(board: str, order: Order, seed: int = 0) -> GameEvent:
    return of_kind(fire(board, order, seed)[1], "shot", "guided")[0]


def until(board: str, order: Order, result: int) -> tuple[Game, list[GameEvent]]:
    """The game of the first seed whose shot has this result."""
    for seed in range(2000):
        game, events = fire(board, order, seed)
        if of_kind(events, "shot", "guided")[0].result == result:
            return game, events
    raise AssertionError(f"no seed gives {result}")


DUEL = NEAR + "red tank 0103{red}\nblue tank 0303{blue}\n{more}"
CANNON = NEAR + "red chariot 0103\nblue soldier 0303{blue}\n{more}"


@pytest.mark.parametrize(
    ("rule", "modifiers", "red", "blue", "more"),
    [
        ("a plain shot has none", 0, "", "", ""),
        ("a suppressed shooter -1", -1, " suppressed", "", ""),
        ("a moving shooter -1", -1, " moving 0102", "", ""),
        ("a shooter in its stop transition -1", -1, " stopping", "", ""),
        ("a target in a concealed cell -2", -2, "", "", "cell 0303 concealed"),
        ("a hidden target -2", -2, "", " hidden", ""),
        ("a moving target -2", -2, "", " moving 0403", ""),
        ("a target in its stop transition -2", -2, "", " stopping", ""),
        ("a stacked target +2", 2, "", "", "blue soldier 0303"),
        ("an aerocraft above does not stack", 0, "", "", "blue aerocraft 0303"),
        ("all of them add up", -6, " suppressed moving 0102", " hidden stopping", "cell 0303 concealed\nblue soldier 0303"),
    ],
)  # fmt: skip
def test_the_correction_has_its_modifiers(rule: str, modifiers: int, red: str, blue: str, more: str) -> None:
    """Section 7, correction."""
    board = DUEL.format(red=red, blue=blue, more=more)
    assert first_shot(board, Shoot("tank0", "tank0", "GUN")).modifiers == modifiers, rule


def test_a_passenger_does_not_stack() -> None:
    """Section 7: passengers are not counted."""
    board = NEAR + "red tank 0103\nblue chariot 0303\nblue soldier aboard chariot0"
    assert first_shot(board, Shoot("tank0", "chariot0", "GUN")).modifiers == 0


@pytest.mark.parametrize("target", ["tank", "chariot", "soldier", "aerocraft"])
@pytest.mark.parametrize("shooter", ["tank", "chariot", "soldier", "aerocraft"])
def test_every_result_follows_from_its_dice(shooter: str, target: str) -> None:
    """Section 7: result, roll and correction as `rules.adjudicate` says, for every pair of types."""
    board = NEAR + f"red {shooter} 0103\nblue {target} 0203"
    game = Game.from_text(board)
    shots = [o for o in game.legal_orders("red", f"{shooter}0") if isinstance(o, Shoot)]
    for seed in range(40):
        for shot in shots:
            event = first_shot(board, shot, seed)
            blood = 1 if shooter == "aerocraft" else 3
            small = shot.weapon == "SMALL"
            dice = (event.roll or 0, event.correction_roll or 0, event.modifiers or 0)
            levels = (event.level or 0, blood, ARMOUR[target])
            assert event.result == adjudicate(
                CLASS[target], *levels, *dice, small_arms=small and CLASS[target] == "vehicle"
            )


@pytest.mark.parametrize("row", ATTACKS, ids=lambda row: f"{row.weapon.name}_at_{row.target.name.lower()}")
def test_the_attack_level_of_every_weapon_at_every_distance(row: object) -> None:
    """Section 7, attack level, on level ground: every entry of every table, by blood."""
    world = Game.from_text(WIDE + "red tank 0103\nblue tank 4003").world
    rules, cells, _ = world.tables
    pieces = np.zeros(2, PIECE).view(np.recarray)
    kind = {0: PieceType.TANK, 1: PieceType.SOLDIER, 2: PieceType.AEROCRAFT}[row.target]  # type: ignore[attr-defined]
    shooter, target = pieces
    target.kind, target.blood, shooter.cell = kind, 1, world.scenario.hexmap.parse_cell("0103")
    for blood in range(1, 6):
        shooter.blood, levels = blood, row.of_blood(blood)  # type: ignore[attr-defined]
        for apart in range(25):
            target.cell = shooter.cell + apart
            k = apart - row.first_cells  # type: ignore[attr-defined]
            expected = levels[k] if 0 <= k < len(levels) else 0
            assert attack_level(row.weapon, shooter, target, rules, cells) == expected, (blood, apart)  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("uphill_m", "apart", "level"),
    [(10, 1, 10 - 2), (10, 6, 9), (20, 7, 9 - 1), (50, 1, 10 - 4), (80, 3, 10 - 5), (200, 3, 10 - 5), (80, 12, 7 - 1), (80, 13, 7), (-80, 3, 10)],
)  # fmt: skip
def test_fire_uphill_loses_levels_and_fire_downhill_gains_none(uphill_m: int, apart: int, level: int) -> None:
    """Section 7, height correction: row min(h, 8), columns 1..12, beyond them nothing."""
    low, high = ("0103", f"{1 + apart:02d}03")
    hill = f"cell {high} elev {uphill_m}" if uphill_m > 0 else f"cell {low} elev {-uphill_m}"
    board = f"{WIDE}{hill}\nred tank {low}\nblue tank {high}"
    assert first_shot(board, Shoot("tank0", "tank0", "GUN")).level == level


def test_an_aerocraft_knows_no_uphill() -> None:
    """Section 7: no height correction for it, as shooter or target."""
    board = NEAR + "cell 0203 elev 80\n"
    shot = first_shot(board + "red aerocraft 0103\nblue tank 0203", Shoot("aerocraft0", "tank0", "AIRM"))
    assert shot.level == 7
    shot = first_shot(
        board + "red chariot 0103\nblue aerocraft 0203", Shoot("chariot0", "aerocraft0", "CANNON")
    )
    assert shot.level == 3


def test_a_shot_costs_a_round_cover_and_75_s() -> None:
    """Section 4, shoot: ammunition of the pool, hidden off, cool = 75."""
    board = DUEL.format(red=" hidden", blue="", more="")
    game, _ = until(board, Shoot("tank0", "tank0", "GUN"), 0)
    tank = game.view("red").piece("tank0")
    assert (dict(tank.ammo), tank.hidden, tank.cool_left) == ({"GUN": 29, "LIGHT": 29}, False, 74)
    game.advance(73)
    assert game.why_illegal("red", Shoot("tank0", "tank0", "GUN")) is not None
    game.advance(1)
    assert game.why_illegal("red", Shoot("tank0", "tank0", "GUN")) is None


def test_losses_are_capped_at_the_targets_blood() -> None:
    """Section 7: survivors are suppressed, and nobody dies twice."""
    game, events = until(CANNON.format(blue=" blood 1", more=""), Shoot("chariot0", "soldier0", "CANNON"), 2)
    assert of_kind(events, "loss")[0].losses == 1
    assert of_kind(events, "dead")[0].piece == "blue:soldier0"
    assert not of_kind(events, "suppressed")
    assert game.margin("red") == 21


def test_a_result_of_0_suppresses_and_one_of_minus_1_does_nothing() -> None:
    """Section 7: result."""
    board = DUEL.format(red="", blue="", more="")
    game, events = until(board, Shoot("tank0", "tank0", "GUN"), 0)
    assert [event.kind for event in events] == ["shot", "suppressed"]
    assert game.pieces[1].blood == 3
    game, events = until(board, Shoot("tank0", "tank0", "GUN"), -1)
    assert [event.kind for event in events] == ["shot"]
    assert not game.pieces[1].suppressed


def test_a_suppressed_soldier_loses_one_more_squad_by_a_result_of_0() -> None:
    """Section 5.4: once per step."""
    board = CANNON.format(blue=" suppressed", more="")
    _, events = until(board, Shoot("chariot0", "soldier0", "CANNON"), 0)
    assert of_kind(events, "loss")[0].losses == 1
    two = CANNON.format(blue=" suppressed", more="red chariot 0103")
    for seed in range(500):
        game = Game.from_text(two, seed)
        game.submit("red", [Shoot(f"chariot{k}", "soldier0", "CANNON") for k in (0, 1)])
        events = game.advance(1)
        if [shot.result for shot in of_kind(events, "shot")] == [0, 0]:
            assert of_kind(events, "loss")[0].losses == 1
            return
    raise AssertionError


def test_a_suppressed_vehicle_loses_nothing_by_a_result_of_0() -> None:
    """Section 5.4 speaks of soldiers only."""
    board = DUEL.format(red="", blue=" suppressed", more="")
    _, events = until(board, Shoot("tank0", "tank0", "GUN"), 0)
    assert not of_kind(events, "loss")


def test_losses_of_one_target_add_up_and_every_shooter_pays() -> None:
    """Sections 5.4 and 13: the surplus is lost."""
    board = NEAR + "red tank 0103\nred tank 0102\nblue chariot 0203 blood 2"
    for seed in range(300):
        game = Game.from_text(board, seed)
        game.submit("red", [Shoot("tank0", "chariot0", "GUN"), Shoot("tank1", "chariot0", "GUN")])
        events = game.advance(1)
        results = [shot.result or 0 for shot in of_kind(events, "shot")]
        if min(results) >= 2:
            assert of_kind(events, "loss")[0].losses == 2
            assert [dict(game.view("red").piece(f"tank{k}").ammo)["GUN"] for k in (0, 1)] == [29, 29]
            return
    raise AssertionError


def test_a_piece_that_is_killed_in_a_step_still_fires_in_it() -> None:
    """Sections 5.3 and 13: both shots read the state at the start of the step."""
    board = NEAR + "red tank 0103 blood 1\nblue tank 0203 blood 1"
    for seed in range(500):
        game = Game.from_text(board, seed)
        game.submit("red", Shoot("tank0", "tank0", "GUN"))
        game.submit("blue", Shoot("tank0", "tank0", "GUN"))
        events = game.advance(1)
        if len(of_kind(events, "dead")) == 2:
            return
    raise AssertionError("never both")


def test_an_order_at_a_target_that_died_is_refused_and_costs_nothing() -> None:
    """Section 13: legality is checked against the state (code target_gone)."""
    board = NEAR + "red tank 0103\nred tank 0102\nblue soldier 0203 blood 1"
    game, events = until(board, Shoot("tank0", "soldier0", "GUN"), 1)
    assert of_kind(events, "dead")
    game.submit("red", Shoot("tank1", "soldier0", "GUN"), strict=False)
    assert [event.kind for event in game.advance(1)] == ["refused"]
    assert dict(game.view("red").piece("tank1").ammo)["GUN"] == 30


def test_an_aerocraft_is_destroyed_or_unhurt() -> None:
    """Section 7, aerocraft: one roll of two dice, no suppression."""
    board = NEAR + "red chariot 0103\nblue aerocraft 0203"
    _, events = until(board, Shoot("chariot0", "aerocraft0", "CANNON"), 1)
    assert [event.kind for event in events] == ["shot", "loss", "dead"]
    _, events = until(board, Shoot("chariot0", "aerocraft0", "CANNON"), -1)
    assert [event.kind for event in events] == ["shot"]


def test_a_shooter_does_not_become_visible_by_firing() -> None:
    """Section 6, but it loses its cover."""
    board = WIDE + "cell 0903 concealed\nred tank 0103\nblue soldier 0903\nblue tank 4003"
    game = Game.from_text(board)
    assert game.view("red").seen == ()
    assert game.submit("blue", Shoot("soldier0", "tank0", "PORT")) == [None]
    game.advance(1)
    assert [enemy.name for enemy in game.view("red").seen] == []


def test_orders_of_a_step_do_not_change_its_fire() -> None:
    """Section 5: all fire reads S; a move or hide order of the same step gives no shield."""
    board = NEAR + "red tank 0103\nblue tank 0303 hidden"
    game = Game.from_text(board)
    game.submit("red", Shoot("tank0", "tank0", "GUN"))
    game.submit("blue", Move("tank0", ["0403"]))
    assert of_kind(game.advance(1), "shot")[0].modifiers == -2, "still hidden, not yet moving"


def test_suppression_cancels_hiding() -> None:
    """Section 5.4: suppression cancels hide, boarding and decompressing."""
    board = DUEL.format(red="", blue="", more="")
    for seed in range(50):
        game = Game.from_text(board, seed)
        game.submit("blue", Hide("tank0"))
        game.advance(10)
        game.submit("red", Shoot("tank0", "tank0", "GUN"))
        if of_kind(game.advance(1), "suppressed"):
            assert game.view("blue").piece("tank0").hide_left == 0
            return
    raise AssertionError


def test_every_weapon_of_a_piece_shares_its_pool() -> None:
    """Section 2: GUN and LIGHT share 30 rounds, CANNON and LIGHT 40, SMALL and ROCKET 10."""
    shared = {
        "tank": ("GUN", "LIGHT", 30),
        "chariot": ("CANNON", "LIGHT", 40),
        "soldier": ("SMALL", "ROCKET", 10),
    }
    for kind, (one, other, rounds) in shared.items():
        game = Game.from_text(NEAR + f"red {kind} 0103\nblue soldier 0203\nblue tank 0202")
        assert dict(game.view("red").own[0].ammo)[other] == rounds
        target = "tank0" if one == "SMALL" else "soldier0"
        assert game.submit("red", Shoot(f"{kind}0", target, one)) == [None]
        game.advance(1)
        assert dict(game.view("red").own[0].ammo)[other] == rounds - 1


def test_weapons_have_the_rounds_of_the_rule_book() -> None:
    """Section 2: HEAVY 6, MORTAR 6, PORT 4, AIRM 4."""
    game = Game("plain")
    rounds = {"chariot0": {"HEAVY": 6, "MORTAR": 6}, "soldier0": {"PORT": 4}, "aerocraft0": {"AIRM": 4}}
    for piece, expected in rounds.items():
        assert expected.items() <= dict(game.view("red").piece(piece).ammo).items()
    assert Weapon.AIRM2.name not in dict(game.view("red").piece("aerocraft0").ammo)


def test_the_outermost_corrections_stand_for_all_beyond() -> None:
    """Section 7, correction: the tables end, modifiers add up to more."""
    world = Game.from_text(NEAR + "red tank 0103\nblue tank 0903").world
    rules, vehicles = world.tables[0], world.ruleset.table("vehicle_correction")
    for roll in range(-10, 20):
        assert soldier_correction(roll, rules) == world.ruleset.table("soldier_correction").clamped(roll)
        for armour in range(5):
            assert vehicle_correction(roll, armour, rules) == vehicles.clamped(roll, armour), (roll, armour)


@pytest.mark.parametrize(
    ("results", "kept"), [((-1,), (0, 0, 0)), ((0,), (1, 1, 0)), ((2, -1, 1), (1, 0, 3)), ((0, 90, 90), (1, 1, 100))]
)  # fmt: skip
def test_results_of_a_tick_add_up(results: tuple[int, ...], kept: tuple[int, int, int]) -> None:
    """Section 5.4: -1 is no hit; a sum beyond all blood is kept within its byte."""
    piece = np.zeros(1, PIECE).view(np.recarray)[0]
    for result in results:
        add_result(piece, result)
    assert (piece.hit_now, piece.zero_now, piece.losses_now) == kept


@pytest.mark.parametrize("exit_shot", [False, True])
@pytest.mark.parametrize("target", ["tank", "soldier"])
def test_a_shot_and_an_exit_shot_have_dice_of_their_own(target: str, exit_shot: bool) -> None:
    """Section 11: every die is a function of the tick, its purpose, shooter, target and count."""
    game = Game.from_text(NEAR + f"red tank 0103\nblue {target} 0303")
    record, pieces, *_, log = game.state.game(0)
    purposes = (Dice.EXIT_SHOT, Dice.EXIT_SHOT) if exit_shot else (Dice.DIRECT, Dice.DIRECT_CORRECTION)
    second = two_dice if target == "tank" else die
    for tick in range(20):
        record.tick, record.log_count = tick, 0
        resolve_shot(
            Event.SHOT, PieceIndex(0), PieceIndex(0), PieceIndex(1), Weapon.GUN, exit_shot, record, pieces, log,
            *game.world.tables[:2],
        )  # fmt: skip
        assert log[0].roll == two_dice(record, tick, purposes[0], pieces[0], pieces[1], 0)
        assert log[0].roll2 == second(record, tick, purposes[1], pieces[0], pieces[1], 2 if exit_shot else 0)


def test_an_aerocraft_is_shot_at_with_dice_of_its_own() -> None:
    """Sections 7 and 11: one roll, no correction."""
    game = Game.from_text(NEAR + "red chariot 0103\nblue aerocraft 0303")
    record, pieces, *_, log = game.state.game(0)
    for tick in range(20):
        record.tick, record.log_count = tick, 0
        resolve_shot(
            Event.SHOT, PieceIndex(0), PieceIndex(0), PieceIndex(1), Weapon.CANNON, False, record, pieces, log,
            *game.world.tables[:2],
        )  # fmt: skip
        assert log[0].roll == two_dice(record, tick, Dice.AIR, pieces[0], pieces[1], 0)
        assert (log[0].roll2, log[0].corr) == (0, 0)


def test_an_aerocraft_dies_by_the_very_level_that_the_table_names() -> None:
    """Section 7, aerocraft: at 2 cells a chariot's gun has level 2, which a roll of 12 asks for; level 1 is less."""
    for apart, destroyed in ((2, 1), (4, NO_EFFECT)):
        game = Game.from_text(NEAR + f"red chariot 0103\nblue aerocraft 0{1 + apart}03")
        record, pieces, *_, log = game.state.game(0)
        twelves = []
        for tick in range(200):
            record.tick, record.log_count = tick, 0
            resolve_shot(
                Event.SHOT, PieceIndex(0), PieceIndex(0), PieceIndex(1), Weapon.CANNON, False, record, pieces, log,
                *game.world.tables[:2],
            )  # fmt: skip
            twelves += [int(log[0].result)] if log[0].roll == 12 else []
        assert twelves
        assert set(twelves) == {destroyed}


@pytest.mark.parametrize("guided", [False, True])
def test_an_order_to_fire_throws_the_dice_of_direct_fire(guided: bool) -> None:
    """Section 11: of a guided shot, with the chariot as the shooter."""
    game = Game.from_text(NEAR + "red tank 0103\nred chariot 0203\nred soldier 0203\nblue tank 0503")
    before = game.state.games[0].copy()
    order: Order = GuideShoot("soldier0", "tank0", "chariot0") if guided else Shoot("tank0", "tank0", "GUN")
    assert game.submit("red", order) == [None]

    shot = of_kind(game.advance(1), "shot", "guided")[0]

    own, enemy = game.roster.index("red:chariot0" if guided else "red:tank0"), game.roster.index("blue:tank0")
    assert shot.roll == two_dice(before, 0, Dice.DIRECT, game.pieces[own], game.pieces[enemy], 0)
    assert shot.correction_roll == two_dice(
        before, 0, Dice.DIRECT_CORRECTION, game.pieces[own], game.pieces[enemy], 0
    )


@pytest.mark.parametrize(
    ("shooter", "weapon", "target"),
    [("tank", "GUN", "tank"), ("soldier", "SMALL", "tank"), ("chariot", "CANNON", "soldier"), ("chariot", "CANNON", "aerocraft")],
)  # fmt: skip
def test_a_shot_is_judged_as_a_referee_would_and_its_result_collected(
    shooter: str, weapon: str, target: str
) -> None:
    """Section 7: nothing is worse for the target than no effect."""
    game = Game.from_text(NEAR + f"red {shooter} 0103\nblue {target} 0203 stopping")
    record, pieces, *_, log = game.state.game(0)
    for tick, blood in product(range(25), (1, 3, 5)):
        record.tick, record.log_count, pieces[0].blood = tick, 0, blood
        pieces[1].hit_now = pieces[1].losses_now = 0
        resolve_shot(
            Event.SHOT, PieceIndex(0), PieceIndex(0), PieceIndex(1), Weapon[weapon], False, record, pieces, log,
            *game.world.tables[:2],
        )  # fmt: skip
        shot = log[0]
        levels = (int(shot.level), blood, ARMOUR[target])
        dice = (int(shot.roll), int(shot.roll2), int(shot.mods))
        small = weapon == "SMALL"
        assert shot.mods == -2
        assert shot.result == adjudicate(CLASS[target], *levels, *dice, small_arms=small)
        assert (pieces[1].hit_now, pieces[1].losses_now) == (shot.result >= 0, max(shot.result, 0))
