"""The agent network over task sets (Fig. 4b), shared by all pieces."""

from __future__ import annotations

from abc import abstractmethod

import torch
from jaxtyping import Float, Int
from torch import Tensor, nn

from hexwar_sb3.policies.task_sets import TaskSets, pack


class TaskNetwork(nn.Module):
    """Estimates Q_i of every task in a piece's task set (Fig. 4b)."""

    piece: nn.Linear  # reads a piece's own features

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

    @abstractmethod
    def encode(self, sets: TaskSets) -> tuple[Tensor, ...]:
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
        """Q of every valid task."""
        return self.values(self.encode(sets), sets)


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

    def encode(self, sets: TaskSets) -> tuple[Float[Tensor, "row embed"], Float[Tensor, "piece hidden"]]:
        """Embed every task (h), and every piece with its whole task set (c)."""
        x = torch.relu(self.piece(sets.obs))
        h = self.embed_task(sets.tasks).add_(self.embed_piece(x).index_select(0, sets.piece)).relu_()
        h = self.embed(h).relu_()
        z = h.new_zeros(sets.n_pieces, h.shape[1]).index_add(0, sets.piece, h) / sets.sizes  # h_Sigma
        return h, self.context_piece(x) + self.context_set(z)

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

    def q_table(self, sets: TaskSets) -> Float[Tensor, "piece task"]:
        """Q of every row of every task set."""
        valid = sets.spread(torch.ones_like(sets.tasks[:, 0]), 0.0).unsqueeze(2)
        tasks = sets.tasks.new_zeros(sets.n_pieces, sets.n_tasks, sets.tasks.shape[1])
        tasks[sets.piece, sets.task] = sets.tasks
        x = torch.relu(self.piece(sets.obs)).unsqueeze(1).expand(-1, sets.n_tasks, -1)
        h = torch.relu(self.embed_first(torch.cat([tasks, x], dim=2)))
        h = torch.relu(self.embed(h))
        z = ((h * valid).sum(dim=1) / sets.sizes).unsqueeze(1).expand(-1, sets.n_tasks, -1)
        return self.value(torch.relu(self.context(torch.cat([x, z, h], dim=2)))).squeeze(2)

    def encode(self, sets: TaskSets) -> tuple[Tensor, ...]:
        """Q of all rows: nothing is left out."""
        return (self.q_table(sets),)

    def values(self, encoded: tuple[Tensor, ...], sets: TaskSets) -> Float[Tensor, " row"]:
        """Q of every valid task."""
        return encoded[0][sets.piece, sets.task]

    def chosen(
        self, encoded: tuple[Tensor, ...], sets: TaskSets, tasks: Int[Tensor, " piece"]
    ) -> Float[Tensor, " piece"]:
        """Q of one task of each piece."""
        return encoded[0].gather(1, tasks.unsqueeze(1)).squeeze(1)


NETWORKS: dict[str, type[AgentNetwork | LiteralAgentNetwork]] = {
    "additive": AgentNetwork,
    "literal": LiteralAgentNetwork,
}
