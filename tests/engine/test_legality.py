"""Every reason to refuse an order (rule book, section 4): one position and one sentence each."""

from __future__ import annotations

from typing import NamedTuple

import pytest

from hexwar_sb3.engine.codes import Code
from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.legality import order_code
from hexwar_sb3.engine.order_rows import clear_order
from hexwar_sb3.engine.orders import (
    Decompress,
    GetOff,
    GetOn,
    GuideShoot,
    Hide,
    IndirectShoot,
    Move,
    Null,
    Occupy,
    Order,
    Shoot,
    Stop,
)
from hexwar_sb3.engine.reasons import SENTENCES
from hexwar_sb3.engine.record import state_hash
from hexwar_sb3.rules.enums import Action
from hexwar_sb3.rules.indices import PieceIndex


class Case(NamedTuple):
    """A position, an order of red, and why it is refused."""

    rule: str
    board: str
    order: Order
    why: str
    moved: tuple[tuple[str, str], ...] = ()  # pieces put into another cell: a close combat cannot be a start


PLAIN = "map plain-5x5\n"
WIDE = "map plain-40x5\n"
TANK = PLAIN + "red tank 0101\nblue tank 0505\n"
DUEL = PLAIN + "red tank 0101\nblue tank 0103\n"
SQUAD = PLAIN + "red chariot 0101\nred soldier 0101\nblue tank 0505\n"
FIGHT = PLAIN + "red tank 0101\nred chariot 0301\nblue soldier 0505\nblue soldier 0404\n"
CROWD = PLAIN + "red chariot 0303\nred soldier aboard chariot0\n" + "red tank 0303\n" * 3 + "blue tank 0505\n"

CASES = [
    Case("a dead piece takes no orders", PLAIN + "red tank 0101 blood 0\nblue tank 0505", Hide("tank0"),
         "red tank0 is destroyed; only a living piece takes orders"),
    Case("a passenger takes no orders", PLAIN + "red chariot 0101\nred soldier aboard chariot0\nblue tank 0505", Hide("soldier0"),
         "red soldier0 is aboard red chariot0; it takes orders again when it has got off"),
    # move
    Case("a piece in a forced stop does not move", PLAIN + "red tank 0101 stopped\nblue tank 0505", Move("tank0", ["0201"]),
         "red tank0 is stopping for 74 more s; until then it can only occupy"),
    Case("a moving piece takes no second path", PLAIN + "red tank 0101 moving 0201\nblue tank 0505", Move("tank0", ["0102"]),
         "red tank0 is on its way already; it must stop before it moves anew"),
    Case("a suppressed soldier does not move", PLAIN + "red soldier 0101 suppressed\nblue tank 0505", Move("soldier0", ["0201"]),
         "red soldier0 is suppressed for 149 more s; it must be free before it moves"),
    Case("a path has a cell", TANK, Move("tank0", []),
         "red tank0 got a path of 0 cells; a move needs at least 1"),
    Case("a path has at most 100 cells", TANK, Move("tank0", ["0201", "0101"] * 51),
         "red tank0 got a path of 102 cells; a move has at most 100"),
    Case("a path does not jump", TANK, Move("tank0", ["0201", "0401"]),
         "red tank0 cannot go from 0201 to 0401; each hop must lead to a neighbour that a tank can enter"),
    Case("a path does not leave the map", TANK, Move("tank0", ["E", "NE"]),
         "red tank0 cannot go from 0201 to NE; each hop must lead to a neighbour that a tank can enter"),
    Case("a ground piece does not enter an impassable cell", TANK + "cell 0201 blocked", Move("tank0", ["0201"]),
         "red tank0 cannot go from 0101 to 0201; each hop must lead to a neighbour that a tank can enter"),
    Case("a vehicle does not climb more than 5 levels", TANK + "cell 0201 elev 60", Move("tank0", ["0201"]),
         "red tank0 cannot go from 0101 to 0201; each hop must lead to a neighbour that a tank can enter"),
    Case("a piece leaves a close combat only to a cell free of enemies", FIGHT, Move("tank0", ["0102"]),
         "red tank0 is in close combat and 0102 holds an enemy; it must leave to a cell free of enemies",
         (("blue:soldier0", "0101"), ("blue:soldier1", "0102"))),
    # stop, hide
    Case("only a moving piece stops", TANK, Stop("tank0"),
         "red tank0 has no path; only a moving piece can stop"),
    Case("an aerocraft does not hide", PLAIN + "red aerocraft 0101\nblue tank 0505", Hide("aerocraft0"),
         "red aerocraft0 is an aerocraft; only a ground piece hides"),
    Case("a moving piece does not hide", PLAIN + "red tank 0101 moving 0201\nblue tank 0505", Hide("tank0"),
         "red tank0 is on its way; it must have arrived before it hides"),
    Case("a piece in a forced stop does not hide", PLAIN + "red tank 0101 stopped\nblue tank 0505", Hide("tank0"),
         "red tank0 is stopping for 74 more s; until then it can only occupy"),
    Case("a suppressed piece does not hide", PLAIN + "red tank 0101 suppressed\nblue tank 0505", Hide("tank0"),
         "red tank0 is suppressed for 149 more s; it must be free before it hides"),
    Case("a hidden piece does not hide", PLAIN + "red tank 0101 hidden\nblue tank 0505", Hide("tank0"),
         "red tank0 is hidden already; only an unhidden piece hides"),
    # occupy
    Case("an aerocraft does not occupy", PLAIN + "point main 0101 80\nred aerocraft 0101\nblue tank 0505", Occupy("aerocraft0"),
         "red aerocraft0 is an aerocraft; only a ground piece occupies"),
    Case("only control points are occupied", TANK, Occupy("tank0"),
         "red tank0 stands in 0101, which is no control point; it must stand in one to occupy it"),
    Case("an own point is not occupied again", TANK + "point main 0101 80 red", Occupy("tank0"),
         "red tank0 stands in 0101, which red holds already; only a point of another camp can be occupied"),
    # shoot
    Case("a piece in close combat takes no order but to leave", FIGHT, Shoot("tank0", "soldier0", "GUN"),
         "red tank0 is in close combat; it can only move out to a cell free of enemies", (("blue:soldier0", "0101"),)),
    Case("nobody outside fires into a close combat", FIGHT, Shoot("chariot0", "soldier0", "CANNON"),
         "blue soldier0 is in close combat; nobody outside may fire at it directly", (("blue:soldier0", "0101"),)),
    Case("a weapon needs a round", PLAIN + "red tank 0101 ammo GUN 0\nblue tank 0103", Shoot("tank0", "tank0", "GUN"),
         "red tank0 has 0 rounds for GUN; it needs 1"),
    Case("a piece fires what it carries", DUEL, Shoot("tank0", "tank0", "PORT"),
         "red tank0 is a tank and carries no PORT; it has GUN, LIGHT"),
    Case("a hot piece does not shoot", PLAIN + "red tank 0101 cool 40\nblue tank 0103", Shoot("tank0", "tank0", "GUN"),
         "red tank0 cools down for 40 more s; it shoots only when it is cool"),
    Case("a suppressed soldier does not shoot", PLAIN + "red soldier 0101 suppressed\nblue tank 0103", Shoot("soldier0", "tank0", "ROCKET"),
         "red soldier0 is suppressed for 149 more s; it must be free before it shoots"),
    Case("a moving chariot does not shoot", PLAIN + "red chariot 0101 moving 0102\nblue soldier 0104", Shoot("chariot0", "blue:soldier0", "CANNON"),
         "red chariot0 is moving; it must stand for 75 s before it shoots"),
    Case("a stopping chariot does not shoot", PLAIN + "red chariot 0101 stopping\nblue soldier 0104", Shoot("chariot0", "blue:soldier0", "CANNON"),
         "red chariot0 is stopping; it must stand for 75 s before it shoots"),
    Case("a moving tank fires its gun only", PLAIN + "red tank 0101 moving 0102\nblue soldier 0104", Shoot("tank0", "blue:soldier0", "LIGHT"),
         "red tank0 is moving; it must stand for 75 s before it shoots"),
    Case("a tank in a forced stop does not fire", PLAIN + "red tank 0101 stopped\nblue soldier 0104", Shoot("tank0", "blue:soldier0", "GUN"),
         "red tank0 is stopping for 74 more s; until then it can only occupy"),
    Case("a dead target is gone", PLAIN + "red tank 0101\nblue tank 0103 blood 0", Shoot("tank0", "tank0", "GUN"),
         "blue tank0 is not in sight of red tank0; a target must be alive and seen by red tank0 itself"),
    Case("a target out of sight is gone", PLAIN + "cell 0102 0202 elev 60\ncell 0301 0302 elev 60\nred tank 0101\nblue soldier 0104", Shoot("tank0", "soldier0", "GUN"),
         "blue soldier0 is not in sight of red tank0; a target must be alive and seen by red tank0 itself"),
    Case("only enemies are shot at", SQUAD + "red tank 0102", Shoot("tank0", "red:chariot0", "GUN"),
         "red chariot0 is of the same camp as red tank0; a target must be an enemy"),
    Case("a weapon has a range", WIDE + "red chariot 0103\nblue tank 1303", Shoot("chariot0", "tank0", "CANNON"),
         "blue tank0 is at distance 12 from red chariot0; CANNON reaches 0 to 10 cells"),
    Case("a weapon without any level against a type has no range", WIDE + "red tank 0103\nblue aerocraft 0303", Shoot("tank0", "aerocraft0", "GUN"),
         "blue aerocraft0 is at distance 2 from red tank0; GUN reaches no aerocraft"),
    Case("fire uphill may leave no attack level", PLAIN + "cell 0103 elev 80\nred chariot 0101\nblue tank 0103", Shoot("chariot0", "tank0", "CANNON"),
         "blue tank0 stands 8 levels above red chariot0 at 2 cells; that leaves CANNON no attack level, it needs 1"),
    # guide-shoot
    Case("a tank does not guide", DUEL + "red chariot 0102", GuideShoot("tank0", "tank0", "chariot0"),
         "red tank0 is a tank; only a soldier or an aerocraft guides"),
    Case("missiles fly at vehicles", PLAIN + "red chariot 0101\nred soldier 0102\nblue soldier 0104", GuideShoot("soldier0", "soldier0", "chariot0"),
         "blue soldier0 is a soldier; a guided missile needs a tank or chariot as target"),
    Case("a soldier guides for its own chariot", SQUAD + "red chariot 0102", GuideShoot("soldier0", "tank0", "chariot1"),
         "red chariot1 does not fit: red soldier0 can guide-shoot only with red chariot0"),
    Case("an aerocraft guides for chariots", PLAIN + "red aerocraft 0101\nred tank 0102\nblue tank 0103", GuideShoot("aerocraft0", "tank0", "tank0"),
         "red tank0 does not fit: red aerocraft0 can guide-shoot only with a chariot of red"),
    Case("a suppressed soldier does not guide", PLAIN + "red chariot 0101\nred soldier 0101 suppressed\nblue tank 0103", GuideShoot("soldier0", "tank0", "chariot0"),
         "red soldier0 is suppressed for 149 more s; it must be free before it guides"),
    Case("a moving guider does not guide", PLAIN + "red chariot 0101\nred soldier 0101 moving 0201\nblue tank 0103", GuideShoot("soldier0", "tank0", "chariot0"),
         "red soldier0 is moving; it must stand for 75 s before it guides"),
    Case("a hot guider does not guide", PLAIN + "red chariot 0101\nred soldier 0101 cool 10\nblue tank 0103", GuideShoot("soldier0", "tank0", "chariot0"),
         "red soldier0 cools down for 10 more s; it guides only when it is cool"),
    Case("the guided chariot must stand", PLAIN + "red chariot 0101 moving 0201\nred soldier 0101\nblue tank 0103", GuideShoot("soldier0", "tank0", "chariot0"),
         "red chariot0 is moving; it must be settled, free and without an order of its own"),
    Case("the guided chariot must be cool", PLAIN + "red chariot 0101 cool 9\nred soldier 0101\nblue tank 0103", GuideShoot("soldier0", "tank0", "chariot0"),
         "red chariot0 is cooling down; it must be settled, free and without an order of its own"),
    Case("the guided chariot must not be in close combat", FIGHT + "red aerocraft 0505\nblue tank 0503", GuideShoot("aerocraft0", "tank0", "chariot0"),
         "red chariot0 is in close combat; it must be settled, free and without an order of its own",
         (("blue:soldier0", "0301"),)),
    Case("the guided chariot needs a missile", PLAIN + "red chariot 0101 ammo HEAVY 0\nred soldier 0101\nblue tank 0103", GuideShoot("soldier0", "tank0", "chariot0"),
         "red chariot0 has 0 rounds for HEAVY; it needs 1"),
    Case("missiles do not fly less than 2 cells", PLAIN + "red chariot 0101\nred soldier 0101\nblue tank 0102", GuideShoot("soldier0", "tank0", "chariot0"),
         "blue tank0 is at distance 1 from red chariot0; HEAVY reaches 2 to 20 cells"),
    # indirect-shoot
    Case("a tank has no mortar", WIDE + "red tank 0103\nblue tank 4003", IndirectShoot("tank0", "0603"),
         "red tank0 is a tank; only a chariot has a mortar"),
    Case("a suppressed chariot fires no mortar", WIDE + "red chariot 0103 suppressed\nblue tank 4003", IndirectShoot("chariot0", "0603"),
         "red chariot0 is suppressed for 149 more s; it must be free before it fires its mortar"),
    Case("a moving chariot fires no mortar", WIDE + "red chariot 0103 moving 0203\nblue tank 4003", IndirectShoot("chariot0", "0603"),
         "red chariot0 is moving; it must stand for 75 s before it fires its mortar"),
    Case("a mortar needs a round", WIDE + "red chariot 0103 ammo MORTAR 0\nblue tank 4003", IndirectShoot("chariot0", "0603"),
         "red chariot0 has 0 rounds for MORTAR; it needs 1"),
    Case("a mortar cools down", WIDE + "red chariot 0103 mortar_cool 200\nblue tank 4003", IndirectShoot("chariot0", "0603"),
         "the mortar of red chariot0 cools down for 200 more s; it fires only when it is cool"),
    Case("a mortar reaches 4 cells at least", WIDE + "red chariot 0103\nblue tank 4003", IndirectShoot("chariot0", "0403"),
         "0403 is at distance 3 from red chariot0; MORTAR reaches 4 to 20 cells"),
    Case("a mortar reaches 20 cells at most", WIDE + "red chariot 0103\nblue tank 4003", IndirectShoot("chariot0", "2203"),
         "2203 is at distance 21 from red chariot0; MORTAR reaches 4 to 20 cells"),
    # get-on, get-off
    Case("only soldiers get on", SQUAD + "red tank 0101", GetOn("tank0", "chariot0"),
         "red tank0 is a tank; only a soldier gets on"),
    Case("soldiers get on chariots of their own cell", SQUAD + "red chariot 0102", GetOn("soldier0", "chariot1"),
         "red chariot1 does not fit: red soldier0 can get-on only with a chariot of red in its own cell"),
    Case("a chariot carries one soldier", SQUAD + "red soldier aboard chariot0", GetOn("soldier0", "chariot0"),
         "red chariot0 carries a soldier already; it has room for 1"),
    Case("a suppressed soldier does not get on", PLAIN + "red chariot 0101\nred soldier 0101 suppressed\nblue tank 0505", GetOn("soldier0", "chariot0"),
         "red soldier0 is suppressed for 149 more s; it must be free before it gets on"),
    Case("a moving soldier does not get on", PLAIN + "red chariot 0101\nred soldier 0101 moving 0201\nblue tank 0505", GetOn("soldier0", "chariot0"),
         "red soldier0 is moving; it must stand for 75 s before it gets on"),
    Case("nobody gets on a suppressed chariot", PLAIN + "red chariot 0101 suppressed\nred soldier 0101\nblue tank 0505", GetOn("soldier0", "chariot0"),
         "red chariot0 is suppressed; it must be settled, free and without an order of its own"),
    Case("only chariots let somebody off", SQUAD, GetOff("soldier0", "soldier0"),
         "red soldier0 is a soldier; only a chariot lets somebody off"),
    Case("only the passenger gets off", SQUAD, GetOff("chariot0", "soldier0"),
         "red soldier0 does not fit: red chariot0 can get-off only with its passenger, and it carries none"),
    Case("nobody gets off a suppressed chariot", PLAIN + "red chariot 0101 suppressed\nred soldier aboard chariot0\nblue tank 0505", GetOff("chariot0", "soldier0"),
         "red chariot0 is suppressed for 149 more s; it must be free before it lets its passenger off"),
    Case("nobody gets off a moving chariot", PLAIN + "red chariot 0101 moving 0201\nred soldier aboard chariot0\nblue tank 0505", GetOff("chariot0", "soldier0"),
         "red chariot0 is moving; it must stand for 75 s before it lets its passenger off"),
    Case("nobody gets off into a full cell", CROWD, GetOff("chariot0", "soldier0"),
         "0303 holds 4 ground pieces of red; to set one down it may hold at most 3"),
    # decompress
    Case("only a suppressed piece decompresses", TANK, Decompress("tank0"),
         "red tank0 is not suppressed; only a suppressed piece decompresses"),
    Case("decompressing is too late in the last 75 s", PLAIN + "red tank 0101\nblue tank 0505", Decompress("tank0"),
         "red tank0 is suppressed for 75 more s; decompressing needs more than 75"),
    Case("a stopping piece does not decompress", PLAIN + "red tank 0101 stopping suppressed\nblue tank 0505", Decompress("tank0"),
         "red tank0 is stopping; it must stand for 75 s before it decompresses"),
]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.rule.replace(" ", "_"))
def test_an_illegal_order_is_refused_with_its_reason(case: Case) -> None:
    """Section 4, column "Legal when"; the sentence says who, what was found and what is needed."""
    game = Game.from_text(case.board)
    with game.edit() as state:
        for name, cell in case.moved:
            state[name].cell = cell
        if "too late" in case.rule:
            state["red:tank0"].suppressed = 75

    without = game.copy()
    without.advance(1)

    assert game.why_illegal("red", case.order) == case.why
    assert game.submit("red", [case.order], strict=False) == [case.why]
    assert [event.reason for event in game.advance(1) if event.kind == "refused"] == [case.why]
    assert state_hash(game.state, 0) == state_hash(without.state, 0)


def test_every_code_has_a_sentence() -> None:
    """Section 4: error codes are returned per order."""
    assert set(SENTENCES) == set(Code) - {Code.OK}


def test_null_is_always_legal() -> None:
    """Section 4, null; also for a destroyed piece and after the end."""
    game = Game.from_text("map plain-5x5\nticks 1\nred tank 0101 blood 0\nblue tank 0505")
    game.advance(1)
    assert game.over
    assert game.why_illegal("red", Null("tank0")) is None


def test_no_order_is_taken_after_the_end() -> None:
    """Section 4: the game must be running."""
    game = Game.from_text("map plain-5x5\nticks 2\nred tank 0101\nblue tank 0505")
    game.advance(2)
    assert (
        game.why_illegal("red", Hide("tank0")) == "the game is over since tick 2; no order is taken any more"
    )


def test_a_piece_between_two_cells_does_not_occupy() -> None:
    """Section 4, occupy: progress = 0."""
    game = Game.from_text("map plain-5x5\npoint main 0101 80\nred tank 0101 moving 0201\nblue tank 0505")
    game.advance(7)
    why = "red tank0 has done 7 of 20 s of its hop; it must be in the middle of a cell to occupy"
    assert game.why_illegal("red", Occupy("tank0")) == why


def test_a_busy_piece_takes_no_order_but_occupy() -> None:
    """Section 3: busy; here hiding, getting on and decompressing."""
    game = Game.from_text("""
        map   plain-5x5
        point main 0101 80
        red   chariot 0101
        red   soldier 0101
        red   tank 0103 suppressed
        red   tank 0301
        blue  tank 0505
    """)
    game.submit("red", [GetOn("soldier0", "chariot0"), Decompress("tank0"), Hide("tank1")])
    game.advance(5)
    for piece, doing in (("soldier0", "getting on"), ("tank0", "decompressing"), ("tank1", "hiding")):
        why = f"red {piece} is {doing} for 70 more s; until then it can only occupy"
        assert game.why_illegal("red", Move(piece, ["E"])) == why
    assert game.why_illegal("red", Occupy("chariot0")) is None


def test_two_soldiers_for_one_chariot_conflict() -> None:
    """Section 5, step 1: conflicts inside a camp go to the lower priority."""
    game = Game.from_text(
        "map plain-5x5\nred chariot 0101\nred soldier 0101\nred soldier 0101\nblue tank 0505"
    )
    assert game.submit("red", [GetOn("soldier0", "chariot0"), GetOn("soldier1", "chariot0")]) == [None, None]
    refused = [event for event in game.advance(1) if event.kind == "refused"]
    why = "another piece of red claimed red chariot0 in the same tick and goes first; one piece a tick can"
    assert [event.reason for event in refused] == [why]


def test_two_guiders_for_one_chariot_conflict() -> None:
    """Section 5, step 1."""
    game = Game.from_text("""
        map  plain-9x5
        red  chariot 0103
        red  aerocraft 0303
        red  soldier 0103
        blue tank 0603
    """)
    orders = [GuideShoot("soldier0", "tank0", "chariot0"), GuideShoot("aerocraft0", "tank0", "chariot0")]
    assert game.submit("red", orders) == [None, None]
    assert sorted(e.kind for e in game.advance(1) if e.kind in {"refused", "guided"}) == ["guided", "refused"]


def test_a_guided_chariot_with_an_order_of_its_own_is_not_guided() -> None:
    """Section 4, guide-shoot: the chariot gets no other order this step."""
    game = Game.from_text("map plain-9x5\nred chariot 0103\nred soldier 0103\nblue tank 0603")
    game.submit("red", [GuideShoot("soldier0", "tank0", "chariot0"), Hide("chariot0")])
    events = game.advance(1)
    why = "red chariot0 is under orders; it must be settled, free and without an order of its own"
    assert [event.reason for event in events if event.kind == "refused"] == [why]


def test_a_point_with_an_enemy_beside_it_is_not_occupied() -> None:
    """Section 4, occupy: no living enemy ground piece in the cell and its 6 neighbours."""
    game = Game.from_text("map plain-5x5\npoint main 0303 80\nred tank 0303\nblue tank 0403")
    assert game.submit("red", [Occupy("tank0")]) == [None]  # tested against the survivors of the step
    why = "red tank0 found an enemy in 0303 or beside it; a point is occupied only when none is there"
    assert [event.reason for event in game.advance(1)] == [why]
    assert game.view("red").points[0].owner == "green"


@pytest.mark.parametrize(("kind", "code"), [(Action.INDIRECT_SHOOT, Code.BAD_CELL), (99, Code.ORDER_UNKNOWN)])
def test_a_record_that_no_text_can_make_is_refused_too(kind: int, code: Code) -> None:
    """A policy may write records: a cell off the map, an unknown action."""
    game = Game.from_text("map plain-5x5\nred chariot 0101\nblue tank 0505")
    row = game.state.orders[0, 0]
    clear_order(row)
    row.kind = kind
    assert order_code(PieceIndex(0), row, *game.state.game(0)[:2], *game.world.tables[:2]) == code
