"""The agent network over task sets (Fig. 4b), shared by all pieces."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Iterator

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from hexwar_sb3.policies.task_sets import TaskSets, pack


class TaskNetwork(nn.Module):
    """Estimates Q_i of every task in a piece's task set (Fig. 4b)."""

    piece: nn.Linear  # reads a piece's own features
    remembers: bool = False

    @property
    def piece_layers(self) -> list[nn.Linear]:
        """Layers that read a piece's own features."""
        return [self.piece]

    def forward(
        self,
        obs: Float[Tensor, "*game piece obs"],
        tasks: Float[Tensor, "*game piece task feature"],
        mask: Tensor,
    ) -> Float[Tensor, "*game piece task"]:
        """Q of every task, from dense task sets; masked rows hold the lowest number there is.

        Args:
            obs: own features of each piece [..., N, Do].
            tasks: its task rows [..., N, K, Dt].
            mask: not 0 where the row is a valid task [..., N, K].
        """
        sets = pack(obs, tasks, mask)
        return sets.spread(self.q_values(sets), torch.finfo(obs.dtype).min).reshape(mask.shape)

    def own(
        self, sets: TaskSets, memory: Float[Tensor, "piece hidden"] | None = None
    ) -> Float[Tensor, "piece hidden"]:
        """What is computed of each piece alone; of a network that `remembers`, its memory after this situation.

        Args:
            sets: of some pieces.
            memory: before it; None where a game begins.
        """
        return torch.relu(self.piece(sets.obs))

    def own_in_turn(self, sets: TaskSets, steps: int, n_pieces: int) -> Float[Tensor, "piece hidden"]:
        """The same over runs of situations, each with the memory of those before it.

        Args:
            sets: of all pieces, run by run and step by step [runs * steps * N].
            steps: situations of a run.
            n_pieces: of a game, N.
        """
        return self.own(sets)

    @abstractmethod
    def encode(self, sets: TaskSets, own: Float[Tensor, "piece hidden"]) -> tuple[Tensor, ...]:
        """All that is computed of task sets before it is known which task is asked for."""

    @abstractmethod
    def chosen(
        self, encoded: tuple[Tensor, ...], sets: TaskSets, tasks: Int[Tensor, " piece"]
    ) -> Float[Tensor, " piece"]:
        """Q of one task of each piece, from what `encode` gave."""

    @abstractmethod
    def values(self, encoded: tuple[Tensor, ...], sets: TaskSets) -> Float[Tensor, " row"]:
        """Q of every valid task, from what `encode` gave."""

    def q_values(self, sets: TaskSets) -> Float[Tensor, " row"]:
        """Q of every valid task, without a memory."""
        return self.values(self.encode(sets, self.own(sets)), sets)


class AgentNetwork(TaskNetwork):
    """The network of Fig. 4(b) with additive first layers.

    A layer over a concatenation is the sum of one layer a part: L [x, f] = L_x x + L_f f. So the part
    of the piece is computed once for all of its tasks, and the functions are the same (learning.md, section 1).
    """

    def __init__(self, obs_dim: int, task_dim: int, hidden: int = 64, embed: int = 32) -> None:
        super().__init__()
        self.piece = nn.Linear(obs_dim, hidden)  # L_o
        self.embed_piece = nn.Linear(hidden, embed, bias=False)  # L_e
        self.embed_task = nn.Linear(task_dim, embed)  # L_f
        self.embed = nn.Linear(embed, embed)  # L_2
        self.context_piece = nn.Linear(hidden, hidden, bias=False)  # L_c
        self.context_set = nn.Linear(embed, hidden)  # L_z
        self.context_task = nn.Linear(embed, hidden, bias=False)  # L_k
        self.value = nn.Linear(hidden, 1)  # w

    def encode(
        self, sets: TaskSets, own: Float[Tensor, "piece hidden"]
    ) -> tuple[Float[Tensor, "row embed"], Float[Tensor, "piece hidden"]]:
        """Embed every task (h), and every piece with its whole task set (c)."""
        h = self.embed_task(sets.tasks).add_(self.embed_piece(own).index_select(0, sets.piece)).relu_()
        h = self.embed(h).relu_()
        z = h.new_zeros(sets.n_pieces, h.shape[1]).index_add(0, sets.piece, h) / sets.sizes  # h_Sigma
        return h, self.context_piece(own) + self.context_set(z)

    def values(self, encoded: tuple[Tensor, ...], sets: TaskSets) -> Float[Tensor, " row"]:
        """Q of every valid task."""
        h, c = encoded
        return self.estimate(c.index_select(0, sets.piece), h)

    def chosen(
        self, encoded: tuple[Tensor, ...], sets: TaskSets, tasks: Int[Tensor, " piece"]
    ) -> Float[Tensor, " piece"]:
        """Q of one task of each piece: the estimating module runs for that task only."""
        h, c = encoded
        return self.estimate(c, h.index_select(0, sets.rows_of(tasks)))

    def estimate(
        self, c: Float[Tensor, "any hidden"], h: Float[Tensor, "any embed"]
    ) -> Float[Tensor, " any"]:
        """Estimate Q from a piece's context and a task's embedding (the estimating module)."""
        return self.value(self.context_task(h).add_(c).relu_()).squeeze(1)


class MemoryAgentNetwork(AgentNetwork):
    """An agent network whose pieces remember: a GRU cell stands behind the layer that reads their own features."""

    remembers = True

    def __init__(self, obs_dim: int, task_dim: int, hidden: int = 64, embed: int = 32) -> None:
        super().__init__(obs_dim, task_dim, hidden, embed)
        self.cell = nn.GRUCell(hidden, hidden)

    def own(
        self, sets: TaskSets, memory: Float[Tensor, "piece hidden"] | None = None
    ) -> Float[Tensor, "piece hidden"]:
        """Memory of each piece after this situation."""
        after: Tensor = self.cell(super().own(sets), memory)
        return after

    def own_in_turn(self, sets: TaskSets, steps: int, n_pieces: int) -> Float[Tensor, "piece hidden"]:
        """The same over runs of situations; the memory of a run is empty where it begins."""
        seen = super().own(sets)
        runs = seen.view(-1, steps, n_pieces, seen.shape[1]).transpose(0, 1).flatten(1, 2)
        memory, found = None, []
        for now in runs:
            memory = self.cell(now, memory)
            found.append(memory)
        after = torch.stack(found).view(steps, -1, n_pieces, seen.shape[1])
        return after.transpose(0, 1).reshape_as(seen)


class LiteralAgentNetwork(TaskNetwork):
    """Fig. 4(b) to the letter: layers over concatenations, every row of every task set computed.

    The measure of what `AgentNetwork` saves, and the proof that it computes the same functions.
    """

    def __init__(self, obs_dim: int, task_dim: int, hidden: int = 64, embed: int = 32) -> None:
        super().__init__()
        self.piece = nn.Linear(obs_dim, hidden)
        self.embed_first = nn.Linear(task_dim + hidden, embed)
        self.embed = nn.Linear(embed, embed)
        self.context = nn.Linear(hidden + embed + embed, hidden)
        self.value = nn.Linear(hidden, 1)

    def q_table(self, sets: TaskSets, own: Float[Tensor, "piece hidden"]) -> Float[Tensor, "piece task"]:
        """Q of every row of every task set."""
        valid = sets.spread(torch.ones_like(sets.tasks[:, 0]), 0.0).unsqueeze(2)
        tasks = sets.tasks.new_zeros(sets.n_pieces, sets.n_tasks, sets.tasks.shape[1])
        tasks[sets.piece, sets.task] = sets.tasks
        x = own.unsqueeze(1).expand(-1, sets.n_tasks, -1)
        h = torch.relu(self.embed_first(torch.cat([tasks, x], dim=2)))
        h = torch.relu(self.embed(h))
        z = ((h * valid).sum(dim=1) / sets.sizes).unsqueeze(1).expand(-1, sets.n_tasks, -1)
        return self.value(torch.relu(self.context(torch.cat([x, z, h], dim=2)))).squeeze(2)

    def encode(self, sets: TaskSets, own: Float[Tensor, "piece hidden"]) -> tuple[Tensor, ...]:
        """Q of all rows: nothing is left out."""
        return (self.q_table(sets, own),)

    def values(self, encoded: tuple[Tensor, ...], sets: TaskSets) -> Float[Tensor, " row"]:
        """Q of every valid task."""
        return encoded[0][sets.piece, sets.task]

    def chosen(
        self, encoded: tuple[Tensor, ...], sets: TaskSets, tasks: Int[Tensor, " piece"]
    ) -> Float[Tensor, " piece"]:
        """Q of one task of each piece."""
        return encoded[0].gather(1, tasks.unsqueeze(1)).squeeze(1)


class SeparateNetworks(TaskNetwork):
    """A network for each piece, by its slot: for agents that are too different for one.

    Args:
        networks: of the slots, in their order; all of one kind.
    """

    def __init__(self, networks: Iterable[TaskNetwork]) -> None:
        super().__init__()
        self.networks = nn.ModuleList(networks)
        self.remembers = bool(self._networks[0].remembers)

    @property
    def _networks(self) -> list[TaskNetwork]:
        return list(self.networks)  # type: ignore[arg-type]  # a ModuleList of them

    @property
    def piece_layers(self) -> list[nn.Linear]:
        """Layers that read a piece's own features."""
        return [layer for network in self._networks for layer in network.piece_layers]

    def _dealt(self, sets: TaskSets) -> Iterator[tuple[TaskNetwork, Tensor, Tensor, TaskSets]]:
        """Each network with the pieces that are its own, their rows, and their task sets."""
        n = len(self.networks)
        for slot, network in enumerate(self._networks):
            pieces = torch.arange(slot, sets.n_pieces, n, device=sets.obs.device)
            rows = (sets.piece % n == slot).nonzero().squeeze(1)
            piece, task = sets.piece[rows] // n, sets.task[rows]
            yield (
                network,
                pieces,
                rows,
                TaskSets(sets.obs[pieces], sets.tasks[rows], piece, task, sets.n_tasks),
            )

    def own(
        self, sets: TaskSets, memory: Float[Tensor, "piece hidden"] | None = None
    ) -> Float[Tensor, "piece hidden"]:
        """What is computed of each piece alone, by its own network."""
        found = [
            network.own(its, None if memory is None else memory[pieces])
            for network, pieces, _, its in self._dealt(sets)
        ]
        return torch.stack(found, dim=1).flatten(0, 1)

    def own_in_turn(self, sets: TaskSets, steps: int, n_pieces: int) -> Float[Tensor, "piece hidden"]:
        """The same over runs of situations."""
        found = [network.own_in_turn(its, steps, 1) for network, _, _, its in self._dealt(sets)]
        return torch.stack(found, dim=1).flatten(0, 1)

    def encode(self, sets: TaskSets, own: Float[Tensor, "piece hidden"]) -> tuple[Tensor, ...]:
        """What each network computes of its pieces' task sets, one network after the other."""
        return tuple(
            part for network, pieces, _, its in self._dealt(sets) for part in network.encode(its, own[pieces])
        )

    def _parts(self, encoded: tuple[Tensor, ...]) -> Iterator[tuple[Tensor, ...]]:
        """What `encode` gave, network by network."""
        size = len(encoded) // len(self.networks)
        return (encoded[at : at + size] for at in range(0, len(encoded), size))

    def values(self, encoded: tuple[Tensor, ...], sets: TaskSets) -> Float[Tensor, " row"]:
        """Q of every valid task."""
        found = sets.tasks.new_zeros(len(sets.piece))
        for (network, _, rows, its), part in zip(self._dealt(sets), self._parts(encoded), strict=True):
            found = found.index_copy(0, rows, network.values(part, its))
        return found

    def chosen(
        self, encoded: tuple[Tensor, ...], sets: TaskSets, tasks: Int[Tensor, " piece"]
    ) -> Float[Tensor, " piece"]:
        """Q of one task of each piece."""
        found = [
            network.chosen(part, its, tasks[pieces])
            for (network, pieces, _, its), part in zip(self._dealt(sets), self._parts(encoded), strict=True)
        ]
        return torch.stack(found, dim=1).flatten()


NETWORKS: dict[str, type[AgentNetwork | LiteralAgentNetwork]] = {
    "additive": AgentNetwork,
    "literal": LiteralAgentNetwork,
}
MEMORIES: dict[str, type[AgentNetwork]] = {"gru": MemoryAgentNetwork}
