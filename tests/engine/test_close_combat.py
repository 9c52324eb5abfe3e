"""Close combat: ground pieces of both camps in one cell (rule book, section 10)."""

from __future__ import annotations

import pytest

from hexwar_sb3.engine.codes import Code, Event
from hexwar_sb3.engine.dice import throw, two_dice
from hexwar_sb3.engine.fights import (
    close_fights,
    close_target,
    fire_exchanges,
    fire_exit_shots,
    open_fights,
    spend_close_rounds,
)
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import GameEvent, of_kind
from hexwar_sb3.engine.orders import GetOn, Hide, IndirectShoot, Move, Occupy, Shoot
from hexwar_sb3.engine.records import NEVER, NO_CELL, NO_PIECE
from hexwar_sb3.kernels import Row, Rows
from hexwar_sb3.rules.enums import Action, Dice
from hexwar_sb3.rules.indices import PieceIndex

BOARD = """
    map  plain-9x5
    {cells}
    red  {red} 0303
    blue {blue} 0503
    {more}
"""


def meet(red: str, blue: str, more: str = "", cells: str = "", seed: int = 0) -> Game:
    """A game in which the first pieces of both camps have just met in 0403."""
    game = Game.from_text(BOARD.format(red=red, blue=blue, more=more, cells=cells), seed)
    with game.edit() as state:
        for camp, kind in (("red", red), ("blue", blue)):
            state[f"{camp}:{kind}0"].cell = "0403"
    return game


def shots(events: list[GameEvent], kind: str = "close_shot") -> list[tuple[int, str, str | None]]:
    return [(event.tick, event.piece, event.target) for event in of_kind(events, kind)]


def test_first_contact_stops_everybody_in_the_cell() -> None:
    """Section 5.7: paths cleared, transitions cancelled; the first exchange is in the step after."""
    game = Game.from_text("map plain-9x5\nred tank 0303 moving 0403 0503\nblue chariot 0403")
    game.submit("blue", Hide("chariot0"))
    events = game.advance(20)
    assert [(event.kind, event.tick) for event in events] == [("arrived", 20), ("first_contact", 20)]
    assert game.view("red").fights == ("0403",)
    assert game.view("red").piece("tank0").path == ()
    assert game.view("blue").piece("chariot0").hide_left == 0
    assert shots(game.advance(1)) == [(21, "red:tank0", "blue:chariot0"), (21, "blue:chariot0", "red:tank0")]


def test_exchanges_follow_every_75_s() -> None:
    """Section 10, interval."""
    for seed in range(50):
        game = meet("tank", "tank", seed=seed)
        events = game.advance(160)
        if len(shots(events)) == 6:
            assert [tick for tick, *_ in shots(events)] == [1, 1, 76, 76, 151, 151]
            return
    raise AssertionError


def test_everybody_fires_in_an_exchange_hot_suppressed_or_just_moved() -> None:
    """Section 10: ignoring cool-down and suppression of the shooter; the -1 stays."""
    game = meet("soldier", "tank")
    with game.edit() as state:
        state["red:soldier0"].suppressed = True
        state["red:soldier0"].cool = 50
    event = of_kind(game.advance(1), "close_shot")[0]
    assert (event.piece, event.modifiers, event.cells_apart) == ("red:soldier0", -1, 0)


def test_the_weapon_of_the_best_level_is_fired_and_spent() -> None:
    """Section 10: best level at distance 0, ammunition needed."""
    game = meet("soldier", "tank")
    event = of_kind(game.advance(1), "close_shot")[0]
    assert (event.weapon, event.level) == ("PORT", 7)
    assert dict(game.view("red").piece("soldier0").ammo)["PORT"] == 3
    game = meet("soldier", "tank")
    with game.edit() as state:
        state["red:soldier0"].ammo = {"PORT": 0, "ROCKET": 0}
    assert [event.piece for event in of_kind(game.advance(1), "close_shot")] == ["blue:tank0"]


def test_the_target_is_a_tank_before_a_chariot_before_a_soldier_then_the_weakest() -> None:
    """Section 10: target."""
    more = "blue chariot 0503\nblue tank 0503\nblue tank 0503 blood 2"
    game = Game.from_text(BOARD.format(red="tank", blue="soldier", more=more, cells=""))
    with game.edit() as state:
        for name in ("red:tank0", "blue:soldier0", "blue:chariot0"):
            state[name].cell = "0403"
    assert shots(game.advance(1))[0] == (1, "red:tank0", "blue:chariot0")
    game = Game.from_text(BOARD.format(red="tank", blue="soldier", more=more, cells=""))
    with game.edit() as state:
        for name in ("red:tank0", "blue:soldier0", "blue:tank0", "blue:tank1"):
            state[name].cell = "0403"
    assert shots(game.advance(1))[0] == (1, "red:tank0", "blue:tank1")


def test_a_piece_leaves_under_one_shot_of_every_enemy_there() -> None:
    """Section 10: exit shots in step 3; after it the leaver is out of the exchanges, and free on arrival."""
    for seed in range(200):
        game = meet("tank", "tank", more="blue chariot 0503", seed=seed)
        with game.edit() as state:
            state["blue:chariot0"].cell = "0403"
        game.advance(5)
        if game.pieces[0].blood == 0 or game.pieces[1:].blood.min() == 0:
            continue
        assert game.submit("red", Move("tank0", ["0303"])) == [None]
        left = {(6, "blue:tank0", "red:tank0"), (6, "blue:chariot0", "red:tank0")}
        assert set(shots(game.advance(1), "exit_shot")) == left
        if game.pieces[0].blood == 0:
            continue
        later = game.advance(80)
        assert not shots(later)
        assert [event.cell for event in of_kind(later, "arrived")] == ["0303"]
        assert game.view("red").fights == ()
        assert game.why_illegal("red", Move("tank0", ["0203"])) is None
        return
    raise AssertionError


def test_a_suppressed_soldier_cannot_leave() -> None:
    """Section 10."""
    game = meet("soldier", "tank")
    with game.edit() as state:
        state["red:soldier0"].suppressed = True
    why = "red soldier0 is suppressed for 149 more s; it must be free before it moves"
    assert game.why_illegal("red", Move("soldier0", ["0303"])) == why


def test_whoever_comes_late_changes_neither_the_clock_nor_a_path() -> None:
    """Section 5.7: a newcomer to a running close combat."""
    for seed in range(80):
        game = meet("tank", "tank", more="red chariot 0203 moving 0303 0403", seed=seed)
        events = game.advance(90)
        if len(shots(events)) >= 5 and not of_kind(events, "dead"):
            assert {tick for tick, *_ in shots(events)} == {1, 76}
            assert "red:chariot0" in [piece for _, piece, _ in shots(events)]
            assert len(of_kind(events, "first_contact")) <= 1
            return
    raise AssertionError


def test_the_fight_ends_when_only_one_camp_is_left() -> None:
    """Section 10: the survivors are free."""
    for seed in range(200):
        game = meet("tank", "soldier", seed=seed)
        with game.edit() as state:
            state["blue:soldier0"].blood = 1
        events = game.advance(200)
        if "blue:soldier0" in [event.piece for event in of_kind(events, "dead")]:
            assert game.view("red").fights == ()
            assert game.why_illegal("red", Move("tank0", ["0303"])) is None
            return
    raise AssertionError


def test_a_round_judges_pieces_in_close_combat() -> None:
    """Section 10: mortar rounds judge all."""
    for seed in range(300):
        game = Game.from_text("map plain-20x5\nred chariot 0103\nred tank 0803\nblue tank 1003", seed)
        game.submit("red", IndirectShoot("chariot0", "0903"))
        game.advance(140)
        with game.edit() as state:
            state["red:tank0"].cell = state["blue:tank0"].cell = "0903"
        events = game.advance(10)
        if of_kind(events, "mortar_landed")[0].cell == "0903" and not of_kind(events, "dead"):
            judged = {event.target for event in of_kind(events, "mortar_judged")}
            assert judged == {"red:tank0", "blue:tank0"}
            return
    raise AssertionError


def test_a_point_in_close_combat_is_occupied_by_nobody() -> None:
    """Section 10: the enemy is there."""
    game = meet("tank", "tank", cells="point main 0403 80")
    for camp in ("red", "blue"):
        why = f"{camp} tank0 is in close combat; it can only move out to a cell free of enemies"
        assert game.why_illegal(camp, Occupy("tank0")) == why


def test_close_combat_cancels_boarding() -> None:
    """Section 13: for both partners; the soldier stays where it was."""
    game = Game.from_text("map plain-9x5\nred chariot 0403\nred soldier 0403\nblue tank 0503")
    game.submit("red", GetOn("soldier0", "chariot0"))
    game.submit("blue", Move("tank0", ["0403"]))
    game.advance(20)
    assert game.view("red").piece("soldier0").doing == game.view("red").piece("chariot0").doing == "settled"
    game.advance(80)
    assert game.view("red").piece("soldier0").aboard is None


def test_an_aerocraft_above_a_fight_takes_no_part() -> None:
    """Section 13: it may share a cell with enemies."""
    game = meet("tank", "soldier", more="red aerocraft 0303\nblue aerocraft 0503")
    with game.edit() as state:
        state["red:aerocraft0"].cell = state["blue:aerocraft0"].cell = "0403"
    pieces = {piece for _, piece, _ in shots(game.advance(2))}
    assert pieces <= {"red:tank0", "blue:soldier0"}
    assert game.why_illegal("red", Shoot("aerocraft0", "soldier0", "AIRM")) is not None, (
        "no fire into the fight"
    )


def test_of_two_weapons_of_one_level_the_first_of_the_list_is_fired() -> None:
    """Section 10: SMALL and ROCKET both have level 6 at no distance."""
    game = meet("soldier", "tank")
    with game.edit() as state:
        state["red:soldier0"].ammo = {"PORT": 0}
    event = of_kind(game.advance(1), "close_shot")[0]
    assert (event.weapon, event.level) == ("SMALL", 6)


def test_a_tank_goes_before_a_chariot_even_if_it_is_stronger() -> None:
    """Section 10: target; blood counts within a type only."""
    for red in ("tank", "chariot"):
        fight = Fight(f"red {red} 0403\nblue tank 0503\nblue chariot 0503 blood 1\nblue soldier 0503 blood 1")
        assert fight.target(0) == 1


def test_among_equals_the_weakest_is_the_target_wherever_it_stands_in_the_list() -> None:
    """Section 10: target."""
    for strong in range(4):
        words = ["" if k != strong else " blood 1" for k in range(4)]
        tanks = "\n".join(f"blue tank 0503{word}" for word in words)
        for tick in range(5):
            fight = Fight(f"red tank 0403\n{tanks}")
            fight.record.tick = tick
            assert fight.target(0) == 1 + strong


def test_dice_choose_among_equals() -> None:
    """Section 11: ties."""
    fight = Fight("red tank 0403\nblue tank 0503\nblue tank 0503")
    found = set()
    for tick in range(40):
        fight.record.tick = tick
        shooter, *targets = fight.pieces
        dice = [int(throw(fight.record, tick, Dice.CLOSE_TIE, shooter, target, 0)) for target in targets]
        assert fight.target(0) == 1 + dice.index(min(dice))
        found.add(int(fight.target(0)))
    assert found == {1, 2}


def test_exchanges_have_the_dice_of_shots_and_exit_shots_their_own() -> None:
    """Section 11."""
    for tick in range(10):
        fight = Fight("red tank 0403\nblue tank 0503")
        fight.record.tick, (red, blue) = tick, fight.pieces
        fire_exchanges(fight.record, fight.pieces, fight.log, *fight.tables)
        assert fight.log[0].roll == two_dice(fight.record, tick, Dice.DIRECT, red, blue, 0)
        fight.exit_shots(1)
        assert fight.log[0].roll == two_dice(fight.record, tick, Dice.EXIT_SHOT, red, blue, 0)


def test_exchanges_are_75_s_apart_and_each_shot_costs_one_round() -> None:
    """Section 10: the clock of the fight, not of the shooter."""
    fight = Fight("red tank 0403\nblue tank 0503")
    for tick in range(160):
        fight.record.tick = tick
        fire_exchanges(fight.record, fight.pieces, fight.log, *fight.tables)
    ticks = [int(row.tick) for row in fight.log[: fight.record.log_count]]
    assert ticks == [1, 1, 76, 76, 151, 151]
    assert fight.pieces.spent_now[:, 0].tolist() == [3, 3]


def test_whoever_leaves_is_out_of_the_exchanges() -> None:
    """Section 10: it neither fires nor is fired at."""
    fight = Fight("red tank 0403\nblue tank 0503")
    fight.pieces[0].path_len = 1
    assert fight.target(1) == NO_PIECE
    fire_exchanges(fight.record, fight.pieces, fight.log, *fight.tables)
    assert fight.record.log_count == 0


def test_each_enemy_in_the_cell_has_one_shot_at_who_leaves() -> None:
    """Section 10: not those beside it, nor those that leave themselves; it costs a round."""
    fight = Fight("red tank 0403\nblue tank 0503\nblue tank 0503\nblue tank 0503\nblue tank 0603")
    fight.pieces[2].path_len = 1
    assert fight.exit_shots(0) == [1, 3]
    assert fight.pieces.spent_now[:, 0].tolist() == [0, 1, 0, 1, 0]


def test_a_move_that_is_refused_or_another_order_draws_no_shot() -> None:
    """Section 10: only who leaves is shot at."""
    fight = Fight("red tank 0403\nblue tank 0503")
    assert fight.exit_shots(0, code=Code.NO_HOP) == []
    assert fight.exit_shots(0, kind=Action.HIDE) == []
    assert fight.exit_shots(0) == [1]
    assert Fight("red tank 0403\nblue tank 0503").exit_shots(1) == [0]


def test_an_aerocraft_leaves_the_cell_of_enemies_unharmed() -> None:
    """Section 13: it is in no close combat."""
    fight = Fight("red tank 0403\nred aerocraft 0403\nblue chariot 0503")
    assert fight.exit_shots(1) == []


def test_close_combat_costs_rounds_and_the_cover_of_who_fired() -> None:
    """Section 10; section 4: own fire ends hiding. Rounds never fall below 0."""
    fight = Fight("red tank 0403 hidden\nred tank 0103 hidden\nblue tank 0503")
    fight.pieces[0].spent_now[0], fight.pieces[2].spent_now[0] = 2, 1
    fight.pieces[0].ammo[0] = 1
    for _ in range(2):
        spend_close_rounds(fight.pieces)
        assert fight.pieces.ammo[:, 0].tolist() == [0, 30, 29]
        assert fight.pieces.hidden.tolist() == [0, 1, 0]
        assert not fight.pieces.spent_now.any()


@pytest.mark.parametrize("gone", [0, 1])
def test_the_clock_of_a_fight_stops_when_either_camp_is_gone(gone: int) -> None:
    """Section 10: until one camp is left there."""
    fight = Fight("red tank 0403\nblue tank 0503")
    close_fights(fight.record, fight.pieces)
    assert fight.record.fight_cell[0] == fight.cell
    fight.pieces[gone].blood = 0
    close_fights(fight.record, fight.pieces)
    assert (fight.record.fight_cell[0], fight.record.fight_next[0]) == (NO_CELL, NEVER)


def opened(record: Row, pieces: Rows, log: Rows) -> int:
    """Begin fights; bits of the pieces that are to be looked at again, which are then forgotten."""
    open_fights(record, pieces, log)
    bits = sum(1 << i for i in range(pieces.size) if pieces[i].changed_now)
    pieces.changed_now = 0
    return bits


def test_first_contact_stops_all_in_the_cell_and_the_first_exchange_is_in_the_next_step() -> None:
    """Section 5.7: the bits tell whom to look at again."""
    game = Game.from_text("map plain-9x5\nred tank 0403 stopped\nblue tank 0503\nred aerocraft 0403")
    record, pieces, *_, log = game.state.game(0)
    pieces[2].cell = pieces[0].cell
    assert opened(record, pieces, log) == 0b101
    assert record.fight_next[0] == 1
    assert (pieces[0].stop_ends, pieces[0].stop_forced) == (NEVER, 0)
    assert opened(record, pieces, log) == 0, "the fight is on already"


def test_aerocraft_and_passengers_begin_no_fight() -> None:
    """Section 13: they are in no close combat."""
    game = Game.from_text(
        "map plain-9x5\nred chariot 0303\nred soldier aboard chariot0\nred aerocraft 0303\nblue tank 0503"
    )
    record, pieces, *_, log = game.state.game(0)
    pieces[1].cell = pieces[2].cell = pieces[3].cell
    assert opened(record, pieces, log) == 0
    pieces[0].cell = pieces[3].cell
    assert opened(record, pieces, log) == 0b1001


def test_only_those_in_the_cell_are_stopped_by_a_first_contact() -> None:
    """Section 5.7; the event says where."""
    game = Game.from_text("map plain-9x5\nred tank 0103 stopping\nred tank 0403\nblue tank 0503")
    record, pieces, *_, log = game.state.game(0)
    pieces[2].cell = pieces[1].cell
    assert opened(record, pieces, log) == 0b110
    assert pieces[0].stop_ends != NEVER
    assert record.log_count == 1
    assert (log[0].event, log[0].a, log[0].cell) == (Event.FIRST_CONTACT, 1, pieces[1].cell)
    assert (log[0].b, log[0].extra) == (NO_PIECE, 0)


class Fight:
    """A close combat in 0403: all blue pieces of 0503 have come in; nobody has fired."""

    def __init__(self, lines: str) -> None:
        game = Game.from_text(f"map plain-9x5\n{lines}")
        cell = game.world.scenario.hexmap.parse_cell
        self.record, self.pieces, *_, self.orders, self.log = game.state.game(0)
        self.pieces.cell[self.pieces.cell == cell("0503")] = cell("0403")
        self.tables = game.world.tables[:2]
        self.cell = cell("0403")
        self.record.fight_cell[0], self.record.fight_next[0] = self.cell, 0
        self.record.n_fights = 1

    def target(self, i: int) -> int:
        """Whom piece i fires at."""
        return close_target(PieceIndex(i), self.cell, self.record, self.pieces, *self.tables)

    def exit_shots(self, i: int, kind: Action = Action.MOVE, code: Code = Code.OK) -> list[int]:
        """Who fires at piece i when it is ordered to move."""
        self.record.log_count = 0
        self.orders[i].kind, self.orders[i].code = kind, code
        fire_exit_shots(self.record, self.pieces, self.orders, self.log, *self.tables)
        return [int(row.a) for row in self.log[: self.record.log_count]]
