"""Mixers (Fig. 5): monotonic, consistent with each piece's own best task, blind to the dead."""

from __future__ import annotations

from itertools import product

import pytest
import torch

from hexwar_sb3.policies.mixers import MIXERS, Mixer

GAMES, PIECES, STATE = 16, 3, 7


@pytest.fixture(params=MIXERS)
def mixer(request: pytest.FixtureRequest) -> Mixer:
    torch.manual_seed(0)
    return MIXERS[request.param](PIECES, STATE)


def test_the_joint_value_never_falls_when_a_pieces_value_rises(mixer: Mixer) -> None:
    """dQ_Σ/dQ_i >= 0 (III-C)."""
    agent_q = torch.randn(GAMES, PIECES, requires_grad=True)

    mixer(agent_q, torch.randn(GAMES, STATE), torch.ones(GAMES, PIECES)).sum().backward()

    assert agent_q.grad is not None
    assert (agent_q.grad >= 0).all()
    assert (agent_q.grad > 0).any()


@pytest.mark.parametrize("name", ["qmix", "vdn"])
def test_each_pieces_best_task_is_part_of_the_best_joint_choice(name: str) -> None:
    """A global argmax of Q_Σ is the set of the individual ones (III-C): all joint choices tried."""
    torch.manual_seed(0)
    mixer, state = MIXERS[name](PIECES, STATE), torch.randn(1, STATE)
    for seed in range(20):
        q = torch.randn(PIECES, 4, generator=torch.Generator().manual_seed(seed))
        joint = torch.tensor(list(product(range(4), repeat=PIECES)))
        agent_q = q[torch.arange(PIECES), joint]

        q_total = mixer(agent_q, state.expand(len(joint), -1), torch.ones_like(agent_q))

        assert joint[q_total.argmax()].tolist() == q.argmax(dim=1).tolist()


def test_the_dead_count_nothing(mixer: Mixer) -> None:
    state, agent_q = torch.randn(GAMES, STATE), torch.randn(GAMES, PIECES)
    alive = torch.ones(GAMES, PIECES)
    alive[:, 1] = 0.0

    before = mixer(agent_q, state, alive)
    agent_q[:, 1] = 1e6

    torch.testing.assert_close(mixer(agent_q, state, alive), before)


def test_the_sum_mixer_adds_up() -> None:
    """VDN: Q_Σ = Σ Q_i."""
    mixed = MIXERS["vdn"](PIECES, STATE)(
        torch.tensor([[1.0, 2.0, 4.0]]), torch.zeros(1, STATE), torch.ones(1, 3)
    )

    assert mixed.tolist() == [[7.0]]


def test_independent_learners_share_a_games_weight_among_the_living() -> None:
    weights = MIXERS["iql"](PIECES, STATE).weights(torch.tensor([[1.0, 0.0, 1.0], [0.0, 0.0, 0.0]]))

    assert weights.tolist() == [[0.5, 0.0, 0.5], [0.0, 0.0, 0.0]]


def test_the_state_changes_how_qmix_mixes() -> None:
    torch.manual_seed(0)
    mixer, agent_q = MIXERS["qmix"](PIECES, STATE), torch.ones(2, PIECES)

    q_total = mixer(agent_q, torch.randn(2, STATE), torch.ones(2, PIECES))

    assert q_total[0] != q_total[1]
