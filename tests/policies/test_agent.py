"""The agent network of Fig. 4(b): what may not change its values, and that both forms are the same."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from hexwar_sb3.policies.agent import (
    AgentNetwork,
    LiteralAgentNetwork,
    MemoryAgentNetwork,
    SeparateNetworks,
    TaskNetwork,
)
from hexwar_sb3.policies.task_sets import pack

OBS, TASK = 11, 5
LOWEST = torch.finfo(torch.float32).min

Sets = tuple[Tensor, Tensor, Tensor]


def random_sets(games: int = 3, pieces: int = 4, tasks: int = 6, seed: int = 0) -> Sets:
    """Task sets in which some rows are masked, never all of them: obs, tasks, mask."""
    random = torch.Generator().manual_seed(seed)
    mask = torch.rand(games, pieces, tasks, generator=random) < 0.5
    mask[..., 0] = True
    obs = torch.randn(games, pieces, OBS, generator=random)
    return obs, torch.randn(games, pieces, tasks, TASK, generator=random), mask


@pytest.fixture(params=[AgentNetwork, LiteralAgentNetwork])
def network(request: pytest.FixtureRequest) -> TaskNetwork:
    torch.manual_seed(0)
    made: TaskNetwork = request.param(OBS, TASK)
    return made


def test_permuting_tasks_permutes_their_values(network: TaskNetwork) -> None:
    obs, tasks, mask = random_sets()
    order = torch.randperm(tasks.shape[2], generator=torch.Generator().manual_seed(1))

    q = network(obs, tasks, mask)
    permuted = network(obs, tasks[:, :, order], mask[:, :, order])

    torch.testing.assert_close(permuted, q[:, :, order])


def test_adding_masked_tasks_changes_nothing(network: TaskNetwork) -> None:
    obs, tasks, mask = random_sets()
    more_tasks = torch.cat([tasks, torch.full_like(tasks, 1e6)], dim=2)
    more_mask = torch.cat([mask, torch.zeros_like(mask)], dim=2)

    q = network(obs, tasks, mask)
    padded = network(obs, more_tasks, more_mask)

    torch.testing.assert_close(padded[:, :, : q.shape[2]], q)
    assert (padded[:, :, q.shape[2] :] == LOWEST).all()


def test_masked_tasks_hold_the_lowest_finite_number(network: TaskNetwork) -> None:
    obs, tasks, mask = random_sets()

    q = network(obs, tasks, mask)

    assert (q[~mask] == LOWEST).all()
    assert (q[mask] > LOWEST).all()


@pytest.mark.parametrize(("pieces", "tasks"), [(1, 6), (4, 1), (1, 1)])
def test_one_piece_and_one_task_work(network: TaskNetwork, pieces: int, tasks: int) -> None:
    sets = random_sets(pieces=pieces, tasks=tasks)

    assert network(*sets).shape == (3, pieces, tasks)


def test_a_piece_without_a_valid_task_gives_no_nan(network: TaskNetwork) -> None:
    obs, tasks, mask = random_sets()
    mask[0, 0] = False

    assert torch.isfinite(network(obs, tasks, mask)).all()


def test_pieces_do_not_see_one_another(network: TaskNetwork) -> None:
    """The execution is decentralised: another piece's observation and tasks do not matter (III-C)."""
    obs, tasks, mask = random_sets()
    before = network(obs, tasks, mask)
    obs[:, 1:], tasks[:, 1:] = 0.0, 0.0

    torch.testing.assert_close(network(obs, tasks, mask)[:, 0], before[:, 0])


def test_the_value_of_the_chosen_task_is_that_of_the_whole_table(network: TaskNetwork) -> None:
    obs, tasks, mask = random_sets()
    table = network(obs, tasks, mask).flatten(0, 1)
    chosen = mask.flatten(0, 1).float().multinomial(1, generator=torch.Generator().manual_seed(2)).squeeze(1)
    sets = pack(obs, tasks, mask)

    q = network.chosen(network.encode(sets, network.own(sets)), sets, chosen)

    torch.testing.assert_close(q, table.gather(1, chosen.unsqueeze(1)).squeeze(1))


def test_layers_over_concatenations_are_sums_of_layers() -> None:
    """Every function of the literal form is one of the additive form, and the other way round."""
    torch.manual_seed(0)
    literal, additive = LiteralAgentNetwork(OBS, TASK), AgentNetwork(OBS, TASK)
    hidden, embed = additive.piece.out_features, additive.embed.out_features
    of_task, of_piece = torch.split(literal.embed_first.weight, [TASK, hidden], dim=1)
    context_piece, context_set, context_task = torch.split(
        literal.context.weight, [hidden, embed, embed], dim=1
    )
    additive.load_state_dict(
        {
            "piece.weight": literal.piece.weight,
            "piece.bias": literal.piece.bias,
            "embed_piece.weight": of_piece,
            "embed_task.weight": of_task,
            "embed_task.bias": literal.embed_first.bias,
            "embed.weight": literal.embed.weight,
            "embed.bias": literal.embed.bias,
            "context_piece.weight": context_piece,
            "context_set.weight": context_set,
            "context_set.bias": literal.context.bias,
            "context_task.weight": context_task,
            "value.weight": literal.value.weight,
            "value.bias": literal.value.bias,
        }
    )

    for sets in (random_sets(), random_sets(pieces=1, tasks=9, seed=1)):
        torch.testing.assert_close(additive(*sets), literal(*sets))


def test_gradients_of_the_packed_form_are_those_of_the_table() -> None:
    """Leaving masked rows out of the gradient pass changes no gradient."""
    torch.manual_seed(0)
    agent = AgentNetwork(OBS, TASK)
    obs, tasks, mask = random_sets()
    chosen = torch.zeros(12, dtype=torch.long)

    sets = pack(obs, tasks, mask)
    agent.chosen(agent.encode(sets, agent.own(sets)), sets, chosen).sum().backward()  # type: ignore[no-untyped-call]
    packed = [parameter.grad.clone() for parameter in agent.parameters() if parameter.grad is not None]
    agent.zero_grad()
    agent(obs, tasks, mask)[:, :, 0].sum().backward()
    whole = [parameter.grad for parameter in agent.parameters() if parameter.grad is not None]

    torch.testing.assert_close(packed, whole)


@pytest.mark.parametrize("separate", [False, True])
def test_a_memory_is_carried_from_step_to_step(separate: bool) -> None:
    """Runs at once are what their steps are one after the other; what was seen before counts."""
    torch.manual_seed(0)
    runs, steps, pieces = 2, 5, 3
    agent = (
        SeparateNetworks(MemoryAgentNetwork(OBS, TASK) for _ in range(pieces))
        if separate
        else MemoryAgentNetwork(OBS, TASK)
    )
    obs = torch.randn(runs, steps, pieces, OBS)
    tasks, mask = torch.randn(runs, steps, pieces, 2, TASK), torch.ones(runs, steps, pieces, 2)

    at_once = agent.own_in_turn(pack(obs, tasks, mask), steps, pieces).view(runs, steps, pieces, -1)

    memory = None
    for k in range(steps):
        memory = agent.own(pack(obs[:, k], tasks[:, k], mask[:, k]), memory)
        torch.testing.assert_close(at_once[:, k].flatten(0, 1), memory)
    obs[0, 0, 0] += 1.0
    other = agent.own_in_turn(pack(obs, tasks, mask), steps, pieces).view(runs, steps, pieces, -1)
    assert not torch.allclose(other[0, -1, 0], at_once[0, -1, 0])
    torch.testing.assert_close(other[1], at_once[1])
    torch.testing.assert_close(other[0, :, 1:], at_once[0, :, 1:])


@pytest.mark.parametrize("kind", [AgentNetwork, LiteralAgentNetwork, MemoryAgentNetwork])
def test_separate_networks_give_each_piece_what_its_own_gives_it(
    kind: type[AgentNetwork | LiteralAgentNetwork],
) -> None:
    torch.manual_seed(0)
    games, pieces = 3, 4
    (obs, tasks, mask), networks = random_sets(games, pieces), [kind(OBS, TASK) for _ in range(pieces)]
    together, sets = SeparateNetworks(networks), pack(obs, tasks, mask)
    chosen = torch.tensor([0] * (games * pieces))
    its = torch.stack([network(obs, tasks, mask)[:, slot] for slot, network in enumerate(networks)], dim=1)

    torch.testing.assert_close(together(obs, tasks, mask), its)
    torch.testing.assert_close(
        together.chosen(together.encode(sets, together.own(sets)), sets, chosen), its[:, :, 0].flatten()
    )
    assert together.remembers == (kind is MemoryAgentNetwork)
    assert together.piece_layers == [network.piece for network in networks]
