"""Who is met how often: losses weigh, nobody is forgotten, and a resumed env counts on."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hexwar_sb3.envs.parallel import parallel_env
from hexwar_sb3.envs.registration import make_vec_env
from hexwar_sb3.errors import CheckpointError, ConfigError
from hexwar_sb3.play.encounters import FLOOR, KEPT, Encounters
from hexwar_sb3.players.player import BotPlayer, make_mixture, make_player, member_of, seat_name


def against(priority: float, opponent: Any, n_envs: int = 16) -> Any:
    return make_vec_env(
        "HexWarTask-v0", n_envs=n_envs, seed=0, opponent=opponent, priority=priority
    ).unwrapped


def play(env: Any, steps: int) -> list[int]:
    """Let every piece stop, which loses against whoever moves; the opponents of the games that are running."""
    env.reset()
    met = []
    for _ in range(steps):
        env.step(np.zeros((env.num_envs, 7), np.int64))
        met.append(env.games.opponents.copy())
    return np.concatenate(met).tolist()


def test_a_rate_is_a_running_mean_that_leaves_one_half_at_once() -> None:
    counted = Encounters(2)
    counted.note(0, 1.0)
    assert counted.rates.tolist() == [0.75, 0.5]
    for _ in range(500):
        counted.note(0, 0.0)
    assert counted.rates[0] < 0.01
    assert counted.games.tolist() == [501, 0]


def test_who_wins_is_urgent_and_who_loses_is_not_forgotten() -> None:
    counted = Encounters(3, priority=2.0)
    counted.rates[:] = 0.0, 0.5, 1.0
    assert counted.urgency.tolist() == [1.0, 0.25, FLOOR]
    assert Encounters(3).urgency.tolist() == [1.0] * 3


def test_the_env_meets_by_losses() -> None:
    """Whoever stands still loses to "nearest", and draws against one that stands still too."""
    still = type("Still", (), {"act": lambda _, obs: np.zeros(obs["action_mask"].shape[:2], np.int64)})()
    met = play(against(4.0, ["nearest", still]), 24 * 6)
    evenly = play(against(0.0, ["nearest", still]), 24 * 6)
    assert np.mean(met) < np.mean(evenly) - 0.15


def test_a_member_that_won_comes_again_until_it_loses() -> None:
    """Its further games say nothing of how the family fares, but that they were played."""
    counted, family = Encounters(2, priority=1.0), make_player("drawn")
    met = [member_of(family, counted.seat(1, family, 0, episode)) for episode in range(20)]
    assert 0 not in met
    assert len(set(met)) == 20
    counted.note(1, 0.0, met[0])
    counted.note(1, 0.0, met[1])
    counted.note(1, 1.0, met[2])
    assert counted.beaten_by == [[], met[:2]]
    rate = counted.rates[1]
    again = [member_of(family, counted.seat(1, family, 1, episode)) for episode in range(200)]
    assert 70 < sum(member in met[:2] for member in again) < 130
    assert set(met[:2]) < set(again)
    for win in (0.0, 0.5):
        counted.note(1, win, met[1])
        assert counted.rates[1] == rate
    assert counted.beaten_by == [[], met[:1]]
    assert counted.games.tolist() == [0, 5]


def test_so_many_members_are_remembered() -> None:
    counted = Encounters(1, priority=1.0)
    for member in range(1, KEPT + 6):
        counted.note(0, 0.0, member)
    assert counted.beaten_by == [list(range(6, KEPT + 6))]


@pytest.mark.parametrize(("name", "priority"), [("drawn", 0.0), ("drawn:7", 1.0), ("MA1", 1.0)])
def test_others_play_themselves(name: str, priority: float) -> None:
    player = make_player(name)
    assert Encounters(1, priority).seat(0, player, 0, 0) is player


def test_a_mixture_draws_by_urgency() -> None:
    mixture = make_mixture(["MA1", "MA2"])
    assert {mixture.draw(0, k, np.array([0.0, 1.0])) for k in range(50)} == {1}


def test_what_was_counted_stays_with_a_player_that_stays() -> None:
    env = against(1.0, ["MA1", "nearest"])
    play(env, 24 * 3)
    before = env.games.encounters.snapshot()
    env.set_opponent(["nearest", "MA2"])
    after = env.games.encounters
    assert after.games.tolist() == [before["met"][1], 0]
    assert after.rates.tolist() == [before["rates"][1], 0.5]


@pytest.mark.parametrize("opponent", [["MA1", "nearest", "drawn"], ["drawn:7", "drawn:8", "HRL0"]])
def test_a_restored_env_meets_the_same(opponent: list[str]) -> None:
    """In the middle of its games; a policy was loaded twice there, and is the same all the same."""
    env, other = (against(2.0, opponent) for _ in range(2))
    play(env, 24 * 2 + 11)
    other.reset()
    other.restore(env.snapshot())
    for each in (env, other):
        for _ in range(24 * 3):
            each.step(np.zeros((16, 7), np.int64))
        each.set_opponent(opponent)
    assert env.games.encounters.games.sum() > 16 * 3
    assert env.games.encounters.games.tolist() == other.games.encounters.games.tolist()
    assert env.games.encounters.rates.tolist() == other.games.encounters.rates.tolist()
    assert [seat_name(seat) for seat in env.games.rivals] == [seat_name(seat) for seat in other.games.rivals]
    assert [seat for seat in env.games.rivals if isinstance(seat, BotPlayer)] == [
        seat for seat in other.games.rivals if isinstance(seat, BotPlayer)
    ]
    assert env.games.encounters.beaten_by == other.games.encounters.beaten_by
    assert any(env.games.encounters.beaten_by) == ("drawn" in opponent)
    assert env.games.opponents.tolist() == other.games.opponents.tolist()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("met", np.array([-1, 0])),
        ("met", np.array([0.0, 0.0])),
        ("met", np.zeros(3, np.int64)),
        ("met", np.array(0)),
        ("rates", np.array([np.nan, 0.5])),
        ("rates", np.array([0.5, 1.5])),
        ("rates", np.array([0.5])),
        ("beaten_by", np.zeros((2, 3), np.uint32)),
        ("beaten_by", np.zeros((2, KEPT))),
    ],
)
def test_broken_counts_are_refused(name: str, value: Any) -> None:
    env = against(1.0, ["MA1", "MA2"], n_envs=1)
    env.reset()
    with pytest.raises(CheckpointError, match=name):
        env.restore({**env.snapshot(), name: value})


def test_the_parallel_env_meets_by_losses_too() -> None:
    env = parallel_env("plain", camps="red", opponent=["nearest", "drawn:7"], priority=10.0)
    env.reset(seed=0)
    env.encounters.rates[:] = 0.0, 1.0  # whoever beats it comes nearly always
    met = []
    for _ in range(20):
        env.reset()
        met.append(env._opponent)
    assert met.count(0) > 12
    while env.agents:
        env.step({})
    assert env.encounters.games.sum() == 1


@pytest.mark.parametrize("priority", [-0.1, 11, float("nan"), "1", True])
def test_a_priority_has_its_range(priority: Any) -> None:
    with pytest.raises(ConfigError, match="priority"):
        against(priority, "MA1", n_envs=1)
