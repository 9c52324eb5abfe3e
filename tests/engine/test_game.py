"""The public face of one game (architecture.md, section 9)."""

from __future__ import annotations

import re
from typing import Any

import pytest

import hexwar_sb3 as hx
from hexwar_sb3.engine.edit import Editor
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import of_kind
from hexwar_sb3.engine.orders import GuideShoot, Hide, IndirectShoot, Move, Null, Order, Shoot, Stop
from hexwar_sb3.engine.record import state_hash
from hexwar_sb3.errors import ConfigError, HexWarError, OrderError, UnknownNameError
from hexwar_sb3.maps.files import load_scenario
from hexwar_sb3.rules import default_rules

DUEL = "map plain-9x5\nred tank 0103\nred chariot 0102\nblue tank 0403\nblue soldier 0503"


def test_the_example_of_the_architecture_page_runs() -> None:
    """architecture.md, section 9."""
    game = hx.Game("plain", seed=0)
    game.submit(
        "red",
        [hx.Move("tank0", ["1134", "1234"]), hx.Shoot("tank1", target="blue:chariot0", weapon="GUN")],
        strict=False,
    )
    events = game.advance(75)
    assert [event.kind for event in events] == ["refused", "arrived", "arrived"]
    assert isinstance(game.view("red"), hx.SideView)
    assert game.legal_orders("red", "tank0")
    assert game.why_illegal("red", hx.Hide("tank0")) is None
    assert (game.margin("red"), game.tick, game.over, game.outcome) == (-130, 75, False, None)
    assert "red      tank0 1234 blood 3 stopping" in str(game).splitlines()
    with game.edit() as state:
        state["blue:tank0"].cell = "4034"
    assert game.copy().view("blue").piece("tank0").cell == "4034"


def test_a_game_takes_a_name_a_path_or_a_scenario() -> None:
    scenario = load_scenario("plain")
    assert str(Game(scenario)) == str(Game("plain"))
    with pytest.raises(UnknownNameError, match="did you mean 'plain'"):
        Game("plian")
    assert Game("plain", ruleset=default_rules().with_aerocraft("heli")).pieces[6].cell > 0


def test_orders_are_for_the_current_tick_and_the_last_one_counts() -> None:
    game = Game.from_text(DUEL)
    game.submit("red", [Hide("tank0"), Move("tank0", ["0203"])])
    game.submit("red", Move("chariot0", ["0202"]))
    game.submit("red", Null("chariot0"))
    assert [event.piece for event in of_kind(game.advance(50), "arrived")] == ["red:tank0"]


def test_time_moves_only_forward_and_never_past_the_end() -> None:
    game = Game.from_text(DUEL + "\nticks 100")
    for wrong in (-1, 1.5, "75"):
        with pytest.raises(ConfigError, match=r"ticks must be an integer >= 0, got "):
            game.advance(wrong)  # type: ignore[arg-type]
    assert game.advance(0) == []
    game.advance(1000)
    assert (game.tick, game.over) == (100, True)
    assert game.advance(10) == []


def test_one_long_advance_is_many_short_ones() -> None:
    """architecture.md, section 2: the same game in any chunking."""
    one, many = Game.from_text(DUEL, seed=4), Game.from_text(DUEL, seed=4)
    orders: list[Order] = [Move("tank0", ["0203", "0303", "0304"]), Shoot("chariot0", "tank0", "HEAVY")]
    for game in (one, many):
        game.submit("red", orders)
        game.submit("blue", Shoot("tank0", "tank0", "GUN"))
    events = one.advance(300)
    assert [event for _ in range(300) for event in many.advance(1)] == events
    assert state_hash(one.state, 0) == state_hash(many.state, 0)


def test_a_copy_goes_on_in_the_same_way_and_by_itself() -> None:
    game = Game.from_text(DUEL, seed=1)
    game.submit("red", Shoot("tank0", "tank0", "GUN"))
    other = game.copy()
    assert game.advance(10) == other.advance(10)
    other.submit("red", Move("tank0", ["0203"]))
    other.advance(30)
    assert game.view("red").piece("tank0").cell == "0103"
    assert (game.tick, other.tick) == (10, 40)


def test_another_seed_is_another_game() -> None:
    def rolls(seed: int) -> list[int | None]:
        game = Game.from_text(DUEL, seed)
        game.submit("red", Shoot("tank0", "tank0", "GUN"))
        return [event.roll for event in of_kind(game.advance(1), "shot")]

    assert rolls(3) == rolls(3)
    assert len({str(rolls(seed)) for seed in range(20)}) > 3


def test_every_listed_order_is_legal_and_may_be_given() -> None:
    """Section 4: valid actions, for every piece of the built-in scenario."""
    game = Game("hills")
    for camp in ("red", "blue"):
        for piece in game.view(camp).own:
            orders = game.legal_orders(camp, piece.name)
            assert orders[0] == Null(piece.name)
            sample = (*orders[:12], *orders[12::97])
            assert [game.why_illegal(camp, order) for order in sample] == [None] * len(sample)


def test_the_orders_of_a_position_are_counted() -> None:
    """Section 4 by hand: a settled tank with one enemy vehicle and one soldier in range."""
    game = Game.from_text(DUEL)
    orders = game.legal_orders("red", "tank0")
    moves = [order.path for order in orders if isinstance(order, Move)]
    assert moves == [("0104",), ("0203",), ("0102",)], "the map ends in the west"
    shots = [(order.target, order.weapon) for order in orders if isinstance(order, Shoot)]
    assert shots == [("blue:tank0", "GUN"), ("blue:soldier0", "GUN"), ("blue:soldier0", "LIGHT")]
    assert len(orders) == 1 + 3 + 3 + 1  # null, moves, shots, hide
    game.submit("red", Move("tank0", ["0203"]))
    game.advance(1)
    kinds = [type(order) for order in game.legal_orders("red", "tank0")]
    assert kinds == [Null, Stop, Shoot, Shoot]


def test_a_shot_is_listed_with_its_level_and_chances() -> None:
    """Section 7: level 8, blood 3, armour 4: 1.44 losses, at least one with 0.81."""
    game = Game.from_text("map plain-20x3\nred chariot 0102\nred soldier 0102\nblue tank 0902")
    shot = next(
        o for o in game.legal_orders("red", "chariot0") if isinstance(o, Shoot) and o.weapon == "HEAVY"
    )
    assert shot.chances is not None
    assert (shot.chances.level, shot.chances.modifiers) == (8, 0)
    assert sum(shot.chances.losses) == pytest.approx(0.81, abs=0.005)
    assert shot.chances.expected_losses <= 1.44
    assert shot.chances.nothing + shot.chances.suppressed + sum(shot.chances.losses) == pytest.approx(1)
    guided = next(o for o in game.legal_orders("red", "soldier0") if isinstance(o, GuideShoot))
    assert guided.chances == shot.chances


def test_the_chances_of_a_shot_are_what_happens() -> None:
    """Section 7 against 600 seeds of the dice."""
    board = "map plain-9x3\nred tank 0102\nblue chariot 0402 hidden"
    shot = next(o for o in Game.from_text(board).legal_orders("red", "tank0") if isinstance(o, Shoot))
    assert shot.chances is not None
    results = []
    for seed in range(600):
        game = Game.from_text(board, seed)
        game.submit("red", shot)
        results.append(of_kind(game.advance(1), "shot")[0].result)
    expected = [shot.chances.nothing, shot.chances.suppressed, *shot.chances.losses]
    found = [sum(min(result or 0, 3) == n for result in results) / 600 for n in range(-1, 4)]
    assert found == pytest.approx(expected, abs=0.06)


# --- edits ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("who", "field", "value", "message"),
    [
        ("blue:tank0", "cell", "9901", "cell '9901' is off the map"),
        ("blue:tank0", "cell", "0301", "blue tank0 cannot stand in 0301: it is impassable"),
        ("blue:tank0", "blood", 4, "blue:tank0.blood cannot be 4: expected a whole number from 0 to 3"),
        ("blue:tank0", "clel", "0101", "blue:tank0 has no field 'clel'; did you mean 'cell'?"),
        ("blue:tank0", "ammo", {"PORT": 1}, "blue:tank0.ammo cannot be {'PORT': 1}: it carries no PORT"),
        ("blue:tank0", "path", ["0101"], "blue:tank0.path cannot be ['0101']: hop 1 is not possible"),
        ("blue:tank0", "aboard", "chariot0", "blue:tank0.aboard cannot be 'chariot0': only soldiers ride"),
        ("blue:tank9", "blood", 1, "unknown piece 'blue:tank9'"),
        ("main", "owner", "grene", "unknown camp 'grene'"),
    ],
)
def test_an_impossible_edit_changes_nothing_and_says_why(
    who: str, field: str, value: object, message: str
) -> None:
    """architecture.md, section 9: validated on exit."""
    game = Game.from_text(
        "map plain-9x5\ncell 0301 blocked\npoint main 0505 80\nred chariot 0101\nblue tank 0403"
    )
    before = state_hash(game.state, 0)

    def change(state: Editor) -> None:
        state["red:chariot0"].blood = 1
        setattr(state[who], field, value)

    with pytest.raises((ConfigError, UnknownNameError, ValueError)) as error, game.edit() as state:
        change(state)
    assert message in str(error.value)
    assert state_hash(game.state, 0) == before


def test_a_cell_holds_four_of_a_camp_after_an_edit_too() -> None:
    """Section 5.6."""
    game = Game.from_text("map plain-9x5\n" + "red tank 0101\n" * 4 + "red tank 0102\nblue tank 0403")
    with (
        pytest.raises(ConfigError, match="cell 0101 holds 5 red ground pieces; expected at most 4"),
        game.edit() as state,
    ):
        state["red:tank4"].cell = "0101"


def test_an_edit_reads_what_it_writes() -> None:
    game = Game.from_text(DUEL)
    with game.edit() as state:
        tank = state["blue:tank0"]
        tank.blood -= 1
        tank.suppressed = True
        tank.hidden = True
        tank.cool = 20
        tank.ammo = {"GUN": 5}
        tank.path = ["0303", "0203"]
        assert (tank.blood, tank.suppressed, tank.hidden, tank.cool, tank.ammo["GUN"]) == (
            2,
            149,
            True,
            20,
            5,
        )
        assert (tank.path, tank.cell) == (("0303", "0203"), "0403")
    blue = game.view("blue").piece("tank0")
    assert (blue.blood, blue.suppressed_left, blue.cool_left, blue.hop_left) == (2, 149, 20, 20)


def test_killing_by_hand_kills_the_passenger() -> None:
    """Section 13."""
    game = Game("plain")
    with game.edit() as state:
        state["red:chariot0"].blood = 0
    assert [game.view("red").piece(name).blood for name in ("chariot0", "soldier0")] == [0, 0]


def test_a_whole_game_has_mortars_listed_by_cell() -> None:
    """Section 4, indirect-shoot: every cell at 4 to 20."""
    game = Game("plain")
    cells = [order.cell for order in game.legal_orders("red", "chariot0") if isinstance(order, IndirectShoot)]
    assert len(cells) == len(set(cells)) > 700


@pytest.mark.parametrize("seed", [-1, 1.5, "x"])
def test_a_seed_is_a_whole_number(seed: Any) -> None:
    with pytest.raises(ConfigError, match="seed must be an integer >= 0, got "):
        Game(seed=seed)


@pytest.mark.parametrize("wrong", [None, 3, [None]])
def test_what_is_no_order_is_met_with_an_example(wrong: Any) -> None:
    with pytest.raises(OrderError, match=r"expected an order such as Move\("):
        Game().submit("red", wrong)


ILLEGAL = Shoot("tank0", "tank0", "GUN")


def test_an_illegal_order_is_never_lost_without_a_word() -> None:
    """Who does not say what to do with one is warned; the list says why, and the order is taken as null."""
    game = Game()
    why = game.why_illegal("red", ILLEGAL)
    with pytest.warns(hx.IllegalOrderWarning, match="tank0 shoot") as caught:
        reasons = game.submit("red", [Hide("chariot0"), ILLEGAL])
    assert why is not None
    assert why in str(caught[0].message)
    assert caught[0].filename == __file__
    assert reasons == [None, why]
    assert [event.kind for event in game.advance(1)] == ["refused"]


def test_a_strict_game_takes_none_of_a_batch_with_an_illegal_order() -> None:
    game, untouched = Game(), Game()
    with pytest.raises(OrderError, match="red, tank0 shoot"):
        game.submit("red", [Hide("chariot0"), ILLEGAL], strict=True)
    assert game.advance(75) == untouched.advance(75)
    assert str(game) == str(untouched)


@pytest.mark.parametrize("strict", [True, False, None])
def test_legal_orders_are_taken_alike(strict: bool | None) -> None:
    game, other = Game(), Game()
    orders = [Move("tank0", ["1134", "1234"]), Hide("chariot0")]
    assert game.submit("red", orders, strict=strict) == other.submit("red", orders) == [None, None]
    assert game.advance(75) == other.advance(75)


def test_who_takes_illegal_orders_on_purpose_hears_nothing() -> None:
    game = Game()
    assert game.submit("red", ILLEGAL, strict=False) == [game.why_illegal("red", ILLEGAL)]


def test_orders_may_be_text() -> None:
    texts, objects = Game("plain", seed=0), Game("plain", seed=0)

    said = texts.submit("red", "tank0 move 1134 1234; tank1 move W\n\naerocraft0 hide", strict=False)
    assert said == objects.submit(
        "red", [Move("tank0", ["1134", "1234"]), Move("tank1", "W"), Hide("aerocraft0")], strict=False
    )
    assert texts.submit("blue", ["tank0 stop", Null("tank1")], strict=False)[1] is None
    objects.submit("blue", [Stop("tank0"), Null("tank1")], strict=False)
    texts.advance(75)
    objects.advance(75)
    assert state_hash(texts.state, 0) == state_hash(objects.state, 0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("tank0 mvoe 1134", "unknown action 'mvoe'; did you mean 'move'"),
        ("tank0", "expected a piece and an action, like 'tank0 move 1134'"),
        ("tank7 hide", "unknown piece 'red:tank7'; did you mean 'red:tank"),
        ("blue:tank0 hide", "blue:tank0 does not belong to red"),
        ("tank0 move 9999", "cell '9999' is off the map"),
        ("tank0 shoot blue:tank0 GNU", "unknown weapon 'GNU'; did you mean 'GUN'"),
        ("tank0 shoot blue:tank0", "tank0 shoot: expected target weapon, found 1 parameters"),
    ],
)
def test_text_that_is_no_order_is_met_with_a_hint_and_none_is_taken(text: str, message: str) -> None:
    game = Game("plain")
    before = state_hash(game.state, 0)

    with pytest.raises(HexWarError, match=re.escape(message)):
        game.submit("red", f"tank1 move W; {text}")
    assert state_hash(game.state, 0) == before
    assert message in str(game.why_illegal("red", text))


def test_a_game_and_a_view_say_what_they_are() -> None:
    game = Game.from_text(f"{DUEL}\npoint main 0202 80")
    assert repr(game).startswith("<Game ")
    assert "tick 0 of 1800, margin red " in repr(game)
    game.submit("red", "tank0 move 0203")
    game.advance(1)

    lines = str(game.view("red")).splitlines()
    assert lines[0].startswith("red, tick 1 of 1800: own ")
    assert lines[1].startswith("  tank0 0103, blood 3, moving to 0203")
    assert any(line.startswith("  blue:tank0 seen in 0403, blood 3") for line in lines)
    assert len(lines) < 10
