"""Mixers (Fig. 5): monotonic, consistent with each piece's own best task, blind to the dead."""

from __future__ import annotations

from itertools import product

import pytest
import torch

from hexwar_sb3.policies.mixers import MIXERS, Choices, Mixer

GAMES, PIECES, STATE, FEATURES, TASKS = 16, 3, 7, 5, 4
OF_THE_CAMP = [name for name in MIXERS if name != "iql"]


def make(name: str) -> Mixer:
    """A mixer whose weights are far from those that it begins with."""
    torch.manual_seed(0)
    mixer = MIXERS[name](PIECES, STATE, FEATURES)
    for weights in mixer.parameters():
        torch.nn.init.normal_(weights, std=0.5)
    return mixer


@pytest.fixture(params=MIXERS)
def mixer(request: pytest.FixtureRequest) -> Mixer:
    return make(request.param)


def some_choices(games: int = GAMES) -> Choices:
    return Choices(torch.full((games, PIECES), 9.0), torch.randn(games, PIECES, FEATURES))


def test_the_joint_value_never_falls_when_a_pieces_value_rises(mixer: Mixer) -> None:
    """dQ_Σ/dQ_i >= 0 (III-C)."""
    agent_q = torch.randn(GAMES, PIECES, requires_grad=True)

    mixer(agent_q, torch.randn(GAMES, STATE), torch.ones(GAMES, PIECES), some_choices()).sum().backward()

    assert agent_q.grad is not None
    assert (agent_q.grad >= 0).all()
    assert (agent_q.grad > 0).any()


@pytest.mark.parametrize("name", OF_THE_CAMP)
def test_each_pieces_best_task_is_part_of_the_best_joint_choice(name: str) -> None:
    """A global argmax of Q_Σ is the set of the individual ones (III-C): all joint choices tried."""
    mixer, state, rows = make(name), torch.randn(1, STATE), torch.randn(PIECES, TASKS, FEATURES)
    for seed in range(20):
        q = torch.randn(PIECES, TASKS, generator=torch.Generator().manual_seed(seed))
        joint = torch.tensor(list(product(range(TASKS), repeat=PIECES)))
        agent_q = q[torch.arange(PIECES), joint]
        choices = Choices(q.amax(dim=1).expand(len(joint), -1), rows[torch.arange(PIECES), joint])

        q_total = mixer(agent_q, state.expand(len(joint), -1), torch.ones_like(agent_q), choices)

        assert joint[q_total[:, 0].argmax()].tolist() == q.argmax(dim=1).tolist()


def test_the_dead_count_nothing(mixer: Mixer) -> None:
    state, agent_q, choices = torch.randn(GAMES, STATE), torch.randn(GAMES, PIECES), some_choices()
    alive = torch.ones(GAMES, PIECES)
    alive[:, 1] = 0.0

    before = mixer(agent_q, state, alive, choices)
    for of_the_dead in (agent_q, choices.best_q, choices.rows):
        of_the_dead[:, 1] = 1e6

    torch.testing.assert_close(mixer(agent_q, state, alive, choices), before)


def test_optimism_targets_the_free_value_and_forgives_what_turned_out_worse() -> None:
    mixer, mixed = make("ow-qmix"), torch.tensor([[1.0, 3.0], [5.0, 3.0]])
    target = mixer.next_values(mixed)

    assert target.tolist() == [[3.0, 3.0], [3.0, 3.0]]
    weights = mixer.weights(torch.ones(2, PIECES), mixed, target)
    torch.testing.assert_close(weights, torch.tensor([[1.0, 1.0], [0.1, 1.0]]))


@pytest.mark.parametrize("name", ["qplex", "ow-qmix"])
def test_two_tasks_of_equal_value_can_be_worth_different_things_beside_what_others_do(name: str) -> None:
    mixer, agent_q = make(name), torch.ones(2, PIECES)
    choices = Choices(torch.full((2, PIECES), 2.0), torch.randn(2, PIECES, FEATURES))

    q_total = mixer(agent_q, torch.zeros(2, STATE), torch.ones(2, PIECES), choices)

    assert q_total[0, -1] != q_total[1, -1]


def test_a_mixer_that_reads_choices_says_so() -> None:
    with pytest.raises(TypeError, match="reads choices"):
        make("qplex")(torch.ones(1, PIECES), torch.zeros(1, STATE), torch.ones(1, PIECES))


def test_the_sum_mixer_adds_up() -> None:
    """VDN: Q_Σ = Σ Q_i."""
    mixed = make("vdn")(torch.tensor([[1.0, 2.0, 4.0]]), torch.zeros(1, STATE), torch.ones(1, 3))

    assert mixed.tolist() == [[7.0]]


def test_independent_learners_share_a_games_weight_among_the_living() -> None:
    alive, values = torch.tensor([[1.0, 0.0, 1.0], [0.0, 0.0, 0.0]]), torch.zeros(2, PIECES)

    weights = make("iql").weights(alive, values, values)

    assert weights.tolist() == [[0.5, 0.0, 0.5], [0.0, 0.0, 0.0]]


def test_the_state_changes_how_qmix_mixes() -> None:
    mixer, agent_q = make("qmix"), torch.ones(2, PIECES)

    q_total = mixer(agent_q, torch.randn(2, STATE), torch.ones(2, PIECES))

    assert q_total[0] != q_total[1]
