"""The PettingZoo view."""

from __future__ import annotations

import pytest
from pettingzoo.test import parallel_api_test, parallel_seed_test

from hexwar_sb3.envs.parallel import parallel_env
from hexwar_sb3.errors import UnknownNameError

SHORT = 150  # Delta-t


@pytest.mark.parametrize("camps", ["red", "both"])
def test_pettingzoo_finds_nothing_wrong(camps: str) -> None:
    parallel_api_test(parallel_env("plain", camps=camps, decision_ticks=SHORT), num_cycles=30)


def test_a_seed_is_a_game() -> None:
    parallel_seed_test(lambda: parallel_env("plain", camps="both", decision_ticks=SHORT), num_cycles=5)


def test_agents_are_pieces_and_leave_when_destroyed() -> None:
    env = parallel_env("plain", camps="red", decision_ticks=SHORT)
    env.reset(seed=0)
    assert env.agents[0] == "red:tank0"
    env.arena.state.pieces[0, 0].blood = 0  # red:tank0

    _, _, ended, _, _ = env.step(dict.fromkeys(env.agents, 0))

    assert ended["red:tank0"]
    assert "red:tank0" not in env.agents


def test_the_two_camps_rewards_mirror_each_other_without_green() -> None:
    env = parallel_env("plain", camps="both", decision_ticks=SHORT, reward="net")
    env.reset(seed=0)
    while env.agents:
        _, rewards, *_ = env.step(dict.fromkeys(env.agents, 1))
        red = {reward for agent, reward in rewards.items() if agent.startswith("red")}
        blue = {-reward for agent, reward in rewards.items() if agent.startswith("blue")}
        assert red == blue


def test_a_wrong_camp_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="both"):
        parallel_env("plain", camps="all")
