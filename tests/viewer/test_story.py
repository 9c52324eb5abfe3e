"""Stories (formats/story.md): what they say of any tick is what the game says when it is played again."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from typing import Any

import pytest

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.orders import IndirectShoot, Move, Stop
from hexwar_sb3.engine.replay import PlayerName, Replay
from hexwar_sb3.engine.roster import Roster
from hexwar_sb3.errors import ReplayFileError, UnknownNameError
from hexwar_sb3.viewer.decisions import told_decisions, told_rewards
from hexwar_sb3.viewer.story import CAMPS, VIEWS, stories

Json = dict[str, Any]
At = Callable[..., Any]
Where = Callable[[Json, int], int]


@pytest.fixture(scope="module")
def told(replay: Replay) -> dict[str, Json]:
    return stories(replay)


def check_tick(told: dict[str, Json], game: Game, at: At, where: Where) -> None:
    """Every field of every piece, of both camps' beliefs, of points and margins."""
    tick, name_of = game.tick, game.roster.names
    for camp in CAMPS:
        view, story = game.view(camp), told[camp]
        for piece in view.own:
            own = story["pieces"][f"{camp}:{piece.name}"]
            assert game.roster.cell_name(where(own, tick)) == piece.cell
            assert at(own["blood"], tick, 0) == piece.blood
            assert bool(at(own.get("hidden"), tick, 0)) == piece.hidden
            assert bool(at(own.get("suppressed"), tick, 0)) == piece.suppressed
            assert [name_of[i] for i in at(own.get("sees"), tick, [])] == list(piece.sees)
            carrier = at(own.get("carrier"), tick, -1)
            assert (None if carrier < 0 else game.roster.short(carrier)) == piece.aboard
            assert at(own["ammo"], tick, []) == [left for _, left in piece.ammo]
            assert max(0, at(own.get("cool_ends"), tick, 0) - tick) == piece.cool_left
            if any(hop[0] == tick for hop in own["hops"]):
                continue  # the order for it may be of this very tick, and then the state does not have it yet
            hop = [hop for hop in own["hops"] if hop[0] < tick < (hop[3] if len(hop) > 3 else hop[1])]
            path = [*(one[2] for one in hop), *at(own.get("then"), tick, [])]
            assert [game.roster.cell_name(cell) for cell in path] == list(piece.path)
            assert (hop[-1][1] - tick if hop else 0) == piece.hop_left
        believed = story["beliefs"][camp]
        for seen in view.seen:
            belief = believed[seen.name]
            assert (at(belief["state"], tick, 0), at(belief["blood"], tick, 0)) == (1, seen.blood)
            assert game.roster.cell_name(at(belief["cell"], tick, -1)) == seen.cell
        for lost in view.lost:
            belief = believed[lost.name]
            assert (at(belief["state"], tick, 0), at(belief["blood"], tick, 0)) == (2, lost.blood)
            assert game.roster.cell_name(at(belief["cell"], tick, -1)) == lost.cell
            assert tick - at(belief["last"], tick, 0) == lost.unseen_ticks
        for unseen in view.unseen:
            assert at(believed[unseen.name].get("state"), tick, 0) == 0
        assert at(story["known_margin"][camp], tick, 0) == view.known_margin
        assert [at(owner, tick, "green") for owner in story["owners"]] == [p.owner for p in view.points]
        assert at(told["referee"]["margin"][camp], tick, 0) == game.margin(camp)


def test_a_story_says_what_the_game_says(replay: Replay, told: dict[str, Json], at: At, where: Where) -> None:
    ticks = sorted(random.Random(0).sample(range(1801), 40))
    for game, _ in replay.ticks():
        if game.tick in (0, 1800, *ticks):
            check_tick(told, game, at, where)


def test_hops_that_are_broken_off_and_rounds_that_are_called_off(at: At, where: Where) -> None:
    """A stop order turns a piece back; a move of the owner loses a mortar round."""
    game = Game("plain", seed=9)
    game.submit("red", [Move("tank0", ["E", "E", "E"]), IndirectShoot("chariot0", "2037")])
    game.advance(5)
    game.submit("red", [Stop("tank0"), Move("chariot0", ["E"])])
    with game.edit() as state:
        state["blue:tank0"].cell = "1434"
        state["red:soldier0"].aboard = None
    game.advance(200)
    replay = Replay.of(game)

    told = stories(replay)

    for again, _ in replay.ticks():
        check_tick(told, again, at, where)
    (called_off,) = told["red"]["rounds"]
    assert called_off[2:] == [0, 150, 6]
    assert told["blue"]["rounds"] == []


def test_a_hop_under_way_has_its_start_end_and_cell(told: dict[str, Json]) -> None:
    first = told["red"]["pieces"]["red:tank0"]["hops"][0]

    assert first[:2] == [0, 20]


def test_events_of_the_referee_have_dice_and_chances_and_those_of_a_camp_have_none(
    told: dict[str, Json],
) -> None:
    shots = [event for event in told["referee"]["events"] if event["kind"] == "shot"]
    assert shots
    assert all(
        {"roll", "modifiers", "chances", "expected", "variance", "lost"} <= set(shot) for shot in shots
    )
    for camp in CAMPS:
        known = [event for event in told[camp]["events"] if event["kind"] == "shot"]
        assert known
        assert all(not {"roll", "modifiers", "raw", "chances", "lost"} & set(shot) for shot in known)


def test_a_camps_story_has_no_secrets(told: dict[str, Json]) -> None:
    for camp in CAMPS:
        text = json.dumps(told[camp])
        for secret in ('"seed"', '"margin"', '"end"', '"roll"', '"hash"', "created", "winner", '"rewards"'):
            assert secret not in text
        assert all(order[1] == camp for order in told[camp]["orders"])
        assert all(name.startswith(camp) for name in told[camp]["pieces"])


def test_orders_and_refusals_stand_in_the_story_of_their_camp() -> None:
    game = Game("plain", seed=0)
    game.submit("red", ["tank0 move E", "tank1 occupy"], strict=False)
    game.advance(5)

    told = stories(Replay.of(game), ("red",))

    ((tick, camp, given, refused),) = told["red"]["orders"]
    assert (tick, camp, given) == (0, "red", ["tank0 move E"])
    assert refused[0][0] == "tank1 occupy"
    assert "no control point" in refused[0][1]


def test_the_referees_story_comes_with_both_others() -> None:
    game = Game("plain", seed=0)
    short = Replay.of(game)

    assert set(stories(short, ("referee",))) == set(VIEWS)
    assert set(stories(short, ("blue",))) == {"blue"}


def test_a_long_name_is_cut_and_an_unknown_view_is_refused() -> None:
    replay = Replay.of(Game("plain", seed=0), PlayerName(name="x" * 9_000), PlayerName(name="<b>"))

    told = stories(replay, ("red",))["red"]

    assert [told["players"][camp]["name"] for camp in CAMPS] == ["x" * 40, "<b>"]
    with pytest.raises(UnknownNameError, match="did you mean 'red'"):
        stories(replay, ("rde",))


def test_a_camps_own_record_cannot_be_told() -> None:
    with pytest.raises(ReplayFileError, match="the record of red only; expected a whole replay"):
        stories(Replay.of(Game("plain", seed=0)).for_camp("red"))


DECISION = {
    "type": "decision",
    "tick": 150,
    "camp": "red",
    "reward": {"points": 80, "own": -7, "enemy": 10},
    "choices": [
        ["tank0", 2, ["stop", "hold 1134", "attack blue:tank0"], [12, -30, 455], "E"],
        ["tank1", 0, ["stop"], [], ""],
    ],
}


def test_decisions_name_each_task_once() -> None:
    roster = Roster(Game("plain", seed=0).world.scenario)

    told = told_decisions([DECISION], roster)

    assert told["tasks"] == ["stop", "hold 1134", "attack blue:tank0"]
    assert told["decisions"] == [[150, [[0, 2, [0, 1, 2], [12, -30, 455], "E"], [1, 0, [0], [], ""]]]]


def test_rewards_are_the_referees_alone() -> None:
    """They tell of losses that the camp did not see."""
    roster = Roster(Game("plain", seed=0).world.scenario)

    assert told_rewards([DECISION]) == {"rewards": [[150, "red", {"points": 80, "own": -7, "enemy": 10}]]}
    assert "reward" not in json.dumps(told_decisions([DECISION], roster))
    assert told_decisions([], roster) == told_rewards([]) == {}
