"""Drawn players: a member is the same in every game, families differ in every game, and they are the accepted ones."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hexwar_sb3.bots.config import ATTACK, DEFENCE, STYLE, drawn_hash
from hexwar_sb3.bots.draw import draw_player
from hexwar_sb3.bots.drawn_records import CHARACTER, SQUADS, STAGES
from hexwar_sb3.bots.registry import BOTS, DRAWN_VERSION, FAMILIES, MOST_MEMBER, Duty
from hexwar_sb3.engine.state import new_state, seed_game
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.errors import UnknownNameError
from hexwar_sb3.evaluation.acceptance import FIRST_GAMES
from hexwar_sb3.evaluation.acceptance_drawn import AcceptDrawn, failures_of
from hexwar_sb3.evaluation.seeds import Purpose, seed_for
from hexwar_sb3.maps.files import load_scenario
from hexwar_sb3.maps.spec import STANDARD
from hexwar_sb3.play.match import play_games
from hexwar_sb3.players.player import BotPlayer, make_player
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.rules.indices import CampIndex

ACCEPTED = Path(__file__).parents[2] / "results" / "bots" / "drawn.json"


def characters(family: str, members: int, seeds: int = 1, scenario: str = "plain") -> Any:
    """What is drawn for members 0.. in games of seeds 0.. [members, seeds, camp]."""
    world = load_world(scenario)
    state = new_state(world, 1)
    drawn = np.zeros((members, seeds, 2), CHARACTER)
    drawn["member"] = np.arange(members)[:, None, None]
    for seed in range(seeds):
        seed_game(state.games[0], np.uint64(seed))
        for camp in range(2):
            for member in range(members):
                draw_player(
                    BOTS[family].id,
                    CampIndex(camp),
                    state.games[0],
                    state.pieces[0],
                    drawn[member, seed, camp],
                )
    return drawn


@pytest.mark.parametrize("family", FAMILIES)
def test_a_member_is_the_same_in_every_game_and_camp_and_the_family_in_none(family: str) -> None:
    drawn = characters(family, members=3, seeds=4)
    assert (drawn[1:] == drawn[1:, :1, :1]).all()
    assert len({row.tobytes() for row in drawn[0].ravel()}) == 8
    assert len({row.tobytes() for row in drawn.ravel()}) == 8 + 2


def test_families_do_not_share_what_they_draw() -> None:
    styles = [characters(family, 2)[1, 0, 0]["style"] for family in FAMILIES]
    assert len({style.tobytes() for style in styles}) == len(FAMILIES)


def test_thresholds_lie_between_and_beyond_those_of_the_full_players() -> None:
    styles = characters("drawn", members=400)[1:, 0, 0]["style"]
    for name in STYLE.names or ():
        known = np.array([getattr(style, name) for style in (ATTACK, DEFENCE)], np.float64)
        drawn = styles[name]
        if name == "take_delay":  # not of the aerocraft, which takes nothing
            known, drawn = known[:, :3], drawn[:, :3]
        assert drawn.min() <= known.min() + 0.01, name  # 0 itself is hardly ever drawn
        assert drawn.max() >= known.max(), name


def test_timetables_run_to_the_end_of_the_game() -> None:
    drawn = characters("drawn-unseen", members=200)[:, 0, 0]
    until = drawn["until"].astype(int)
    assert until.shape == (200, SQUADS, STAGES)
    assert (np.diff(until, axis=2) >= 0).all()
    assert (until[:, :, -1] == load_world("plain").scenario.game_ticks).all()


def test_a_drawn_plan_holds_a_point_or_hunts_all_along() -> None:
    drawn = characters("drawn-plan", members=400)[1:, 0, 0]
    what, squad = drawn["what"][:, :, 0], drawn["squad"][:, :7]
    assert set(what.ravel().tolist()) == {Duty.TAKE, Duty.KEEP, Duty.CHASE}
    assert not drawn["what"][:, :, 1:].any()
    assert squad.min() == 0
    assert squad.max() == SQUADS - 1
    # Pieces 0, 1 are tanks; in some members both are of one squad because they are of one type.
    assert 0.4 < (squad[:, 0] == squad[:, 1]).mean() < 0.9


@pytest.mark.parametrize(
    "name", ["drawn:0", "drawn:-1", f"drawn:{MOST_MEMBER + 1}", "drawn:", "drawn:x", "MA1:3", "drawn:\u0663"]
)
def test_what_is_no_member_is_no_player(name: str) -> None:
    with pytest.raises(UnknownNameError):
        make_player(name)


def test_a_member_is_a_player_by_its_name() -> None:
    assert make_player("drawn:7") == BotPlayer("drawn:7", BOTS["drawn"].id, 7)
    one, again, other = (
        play_games(name, "MA1", 4, seed=3).margin.tolist() for name in ("drawn:7", "drawn:7", "drawn:8")
    )
    assert one == again != other


@pytest.fixture(scope="module")
def accepted() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(ACCEPTED.read_text(encoding="utf-8"))
    return found


def test_every_family_was_accepted_on_every_map(accepted: dict[str, Any]) -> None:
    assert sorted(accepted["maps"]) == sorted(STANDARD)
    assert (accepted["members"], accepted["games"]) == (100, 50)
    assert accepted["families"] == f"{DRAWN_VERSION} {drawn_hash()}"
    assert accepted["failures"] == []
    assert all(
        failures_of(family, found[family]) == [] for found in accepted["maps"].values() for family in FAMILIES
    )


@pytest.mark.parametrize("scenario", STANDARD)
@pytest.mark.parametrize("family", FAMILIES)
def test_they_still_play_the_accepted_games(accepted: dict[str, Any], family: str, scenario: str) -> None:
    known = accepted["maps"][scenario][family]["first_margins"]
    seed = seed_for(Purpose.REPORT, accepted["seed"])
    assert play_games(family, "MA1", FIRST_GAMES, Terms(scenario=scenario), seed).margin.tolist() == known


def test_a_missed_bar_is_named() -> None:
    found = AcceptDrawn(members=2, games=2, scenarios=("plain",)).accept("drawn", "plain")
    poor = {**found, "real": 0.2, "as red against": {"random": 0.9}, "used": {"HIDE": 0.005}}
    assert failures_of("drawn-plan", poor) == failures_of("drawn", poor)[:2]
    assert failures_of("drawn", poor) == [
        "has 0.20 members that win 0.3 against nearest",
        "wins 0.900 against random",
        "uses HIDE in 0.0050 of its games",
    ]


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("side", ["red", "blue"])
def test_a_fight_without_control_points_is_played_to_its_end(family: str, side: str) -> None:
    pointless = replace(load_scenario("plain"), name="pointless", points=())
    pair = (family, "MA1") if side == "red" else ("MA1", family)
    assert (play_games(*pair, 20, Terms(scenario=pointless), seed=1).ticks > 0).all()
