"""Three pieces against five: both camps see as many slots as the larger one has pieces."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.envs.flat_env import FlatEnv
from hexwar_sb3.envs.parallel import parallel_env
from hexwar_sb3.envs.registration import FLAT_ENV, TASK_ENV, make_vec_env
from hexwar_sb3.envs.route_env import RouteEnv
from hexwar_sb3.envs.route_games import RouteGames
from hexwar_sb3.envs.route_settings import RouteSettings
from hexwar_sb3.envs.settings import TaskSettings
from hexwar_sb3.envs.task_env import TaskEnv
from hexwar_sb3.envs.task_games import TaskGames
from hexwar_sb3.evaluation.matches import play_match
from hexwar_sb3.maps.scenario import Scenario
from hexwar_sb3.play.recording import record_game
from hexwar_sb3.play.sight import Sight
from hexwar_sb3.players.terms import Terms
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.server.hints import Adviser
from hexwar_sb3.tasks.features import feature_index, sizes

OWN = {"red": 3, "blue": 5}
SLOTS = 5
GAME = """
    map   plain-20x11
    point main 1006 80
    red   tank 0203
    red   chariot 0205
    red   soldier aboard chariot0
    blue  tank 1703
    blue  chariot 1705
    blue  soldier aboard chariot0
    blue  tank 1707
    blue  aerocraft 1804
"""


def scenario() -> Scenario:
    return Game.from_text(GAME).world.scenario


def games(side: str = "both", n: int = 4) -> TaskGames:
    made = TaskGames(
        n, TaskSettings(scenario=scenario(), side=side, opponent="random", privileged_state=True), 0
    )
    made.begin(made.all)
    made.look(made.all)
    return made


def firsts(mask: NDArray[Any], rng: np.random.Generator) -> NDArray[np.int64]:
    """A valid task for every slot [n, N]."""
    return np.asarray((rng.random(mask.shape) * mask).argmax(axis=-1))


def test_a_slot_without_a_piece_reads_as_a_destroyed_one_whoever_looked_before() -> None:
    made, rng = games(n=3), np.random.default_rng(0)  # odd: a slot has either camp in turn
    seen = set()
    for _ in range(60):
        obs = made.sight.obs
        for b in made.all:
            own = OWN[("red", "blue")[made.camps[b]]]
            seen.add(own)
            assert not obs["obs"][b, own:].any()
            assert not obs["tasks"][b, own:].any()
            assert not obs["alive"][b, own:].any()
            assert obs["action_mask"][b, own:].sum(axis=-1).tolist() == [1] * (SLOTS - own)
            assert (obs["action_mask"][b, own:, 0] == 1).all()
        span = made.play(firsts(obs["action_mask"], rng))
        made.begin(made.all[span.over])
        made.look(made.all)
    assert seen == set(OWN.values())


@pytest.mark.parametrize("side", ["red", "blue"])
def test_both_camps_have_the_same_features_in_the_same_places(side: str) -> None:
    made = games(side, 1)
    obs, state = made.sight.obs["obs"][0], made.sight.obs["state"][0]
    places, truth = (feature_index(name, SLOTS, SLOTS, 1) for name in ("obs", "state"))
    own, enemies = OWN[side], OWN["blue" if side == "red" else "red"]

    assert obs.shape == (SLOTS, sizes(SLOTS, SLOTS, 1).obs)
    assert [int(obs[n, places["self: slot"]].argmax()) for n in range(own)] == list(range(own))
    alive = [obs[0, places[f"own piece {k}: alive, aboard"]][0] for k in range(SLOTS)]
    assert alive == [1.0] * own + [0.0] * (SLOTS - own)
    unseen = [
        obs[0, places[f"enemy {k}: never seen, destroyed, seen, seen by this piece"]] for k in range(SLOTS)
    ]
    assert [bool(one.any()) for one in unseen] == [True] * enemies + [False] * (SLOTS - enemies)
    assert obs[0, places["point 0: value"]] == 1.0
    assert obs[0, places["game: time left"]] == obs[own - 1, places["game: time left"]] > 0
    assert obs[0, places["game: blue"]] == (side == "blue")
    living = [state[truth[f"piece {k}: alive, aboard"]][0] for k in range(2 * SLOTS)]
    assert living == [1.0] * own + [0.0] * (SLOTS - own) + [1.0] * enemies + [0.0] * (SLOTS - enemies)
    assert state[truth["game: time left"]] == obs[0, places["game: time left"]]


@pytest.mark.parametrize("env", [TaskEnv, RouteEnv, FlatEnv])
@pytest.mark.parametrize("side", ["red", "blue", "both"])
def test_every_env_takes_the_scenario(env: Any, side: str) -> None:
    check_env(env(scenario=scenario(), side=side, opponent="random"), skip_render_check=True)


def test_pieces_that_are_led_are_the_learners_own() -> None:
    where = scenario()
    routes = RouteGames(4, RouteSettings(scenario=where, side="both", opponent="random"), where, 0)
    routes.begin(routes.all)
    rng, sides, led = (
        np.random.default_rng(0),
        load_world(where).sides,
        {Camp.RED: set[int](), Camp.BLUE: set[int]()},
    )
    for _ in range(300):
        routes.look()
        for piece, camp in zip(routes.focus.piece.tolist(), routes.tasks.camps.tolist(), strict=True):
            assert sides[camp, 0] <= piece < sides[camp, 1]
            led[Camp(camp)].add(piece)
        hop = routes.play(firsts(routes.mask, rng))
        routes.next_route(routes.all[hop.over])
    assert led == {Camp.RED: {0, 1, 2}, Camp.BLUE: {3, 4, 5, 6, 7}}


def test_a_snapshot_of_a_slot_without_a_piece_is_refused() -> None:
    env = FlatEnv(scenario=scenario(), side="red", opponent="random")
    env.reset(seed=0)
    snapshot = env.games.snapshot()
    snapshot["acting"][0] = 4
    with pytest.raises(Exception, match="acting"):
        env.games.restore(snapshot)


def test_only_pieces_are_agents() -> None:
    env = parallel_env(scenario(), opponent="random")
    seen, _ = env.reset(seed=0)
    assert list(seen) == [
        f"{camp}:{name}" for camp in OWN for name in env.arena.world.piece_names(camp == "blue")
    ]
    assert env.step(dict.fromkeys(seen, 0))[1].keys() == seen.keys()


def test_a_policy_plays_either_camp_where_some_of_its_pieces_are_missing() -> None:
    """HRL0 knows seven pieces and two control points: here blue lacks two of them."""
    plain = load_world("plain").scenario
    fewer = replace(plain, name="fewer", pieces=plain.pieces[:-2])
    assert [len(load_world(fewer).piece_names(camp)) for camp in (0, 1)] == [7, 5]

    whole = [play_match(*pair, games=40).red.margins.mean() for pair in (("HRL0", "MA1"), ("MA1", "HRL0"))]
    less = [
        play_match(*pair, games=40, scenario=fewer).red.margins.mean()
        for pair in (("HRL0", "MA1"), ("MA1", "HRL0"))
    ]
    assert less[0] > whole[0]
    assert less[1] > whole[1]


@pytest.mark.parametrize("kind", [TASK_ENV, FLAT_ENV])
def test_a_recorded_game_shows_either_camp_how_to_play(kind: str, tmp_path: Path) -> None:
    """Seven against five; the smaller camp is shown, too."""
    plain = load_world("plain").scenario
    fewer = replace(plain, name="fewer", pieces=plain.pieces[:-2])
    for pair in (("HRL0", "MA1"), ("MA1", "HRL0")):
        record_game(*pair, Terms(scenario=fewer), seed=1).save(tmp_path / f"{pair[0]}.hwr")
    shows: dict[str, Any] = {"demo": str(tmp_path), "demo_share": 1.0, "side": "both", "opponent": "MA1"}
    env = make_vec_env(kind, n_envs=2, seed=0, scenario=fewer, **shows)
    env.reset()

    sides = set()
    for _ in range(200):
        _, _, dones, infos = env.step(np.zeros((2, *(env.action_space.shape or ())), np.int64))
        assert all("demo_actions" in info for info in infos)
        sides |= {info["side"] for done, info in zip(dones, infos, strict=True) if done}
    assert sides == {"red", "blue"}


@pytest.mark.parametrize("camp", ["red", "blue"])
def test_a_policy_advises_either_camp(camp: str) -> None:
    plain = load_world("plain").scenario
    game = Game(replace(plain, name="fewer", pieces=plain.pieces[:-2]), seed=0)
    hint = Adviser("HRL0", "HRL0", game, camp).hint("tank0")
    assert 0 <= hint["chosen"] < len(hint["tasks"])


def test_buffers_that_are_used_again_hold_what_new_ones_would() -> None:
    """Also where a slot was the larger camp's, and where a piece had more tasks before."""
    made, rng = games(n=3), np.random.default_rng(0)  # odd: a slot has either camp in turn
    for _ in range(60):  # more than two games each, in both camps
        mask = made.sight.obs["action_mask"]
        span = made.play((rng.random(mask.shape) * mask).argmax(-1))
        made.turn()
        made.look(made.all)
        if span.over.any():
            made.begin(made.all[span.over])
            made.look(made.all[span.over])
        new = Sight(made.arena.world, made.n_games, with_state=True)
        made.arena.look(made.all, made.all, made.camps, new)
        for name, array in new.obs.items():
            np.testing.assert_array_equal(made.sight.obs[name], array, name)
