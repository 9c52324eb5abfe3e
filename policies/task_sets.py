"""Task sets as the network sees them: the valid rows only, one after the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import torch
from jaxtyping import Float, Int
from torch import Tensor


@dataclass(frozen=True)
class TaskSets:
    """Task sets of some pieces, packed: masked rows are left out.

    A task set has 40 rows of which some 15 are valid: packed, the network computes a third of them.
    Rows are sorted by piece, and by task within a piece.
    """

    obs: Float[Tensor, "piece obs"]
    tasks: Float[Tensor, "row task"]
    piece: Int[Tensor, " row"]  # the piece that the row belongs to
    task: Int[Tensor, " row"]  # its index in that piece's task set
    n_tasks: int  # rows of a task set, valid or not; K

    @property
    def n_pieces(self) -> int:
        """Pieces of all games together."""
        return self.obs.shape[0]

    @cached_property
    def sizes(self) -> Float[Tensor, "piece 1"]:
        """Valid tasks of each piece; 1 for a piece without any, so that means are finite."""
        return torch.bincount(self.piece, minlength=self.n_pieces).clamp(min=1).unsqueeze(1).float()

    def spread(self, values: Float[Tensor, " row"], fill: float) -> Float[Tensor, "piece task"]:
        """One value a row, put back into the full table of [piece, task]."""
        table = values.new_full((self.n_pieces, self.n_tasks), fill)
        return table.index_put((self.piece, self.task), values)

    def rows_of(self, tasks: Int[Tensor, " piece"]) -> Int[Tensor, " piece"]:
        """Row of one valid task of each piece (0 where the task is masked)."""
        table = self.piece.new_zeros(self.n_pieces * self.n_tasks)
        table[self.piece * self.n_tasks + self.task] = torch.arange(len(self.piece), device=self.piece.device)
        return table[torch.arange(self.n_pieces, device=tasks.device) * self.n_tasks + tasks]

    def best(self, q: Float[Tensor, " row"]) -> Int[Tensor, " piece"]:
        """Valid task of the highest value for each piece; the first of equals."""
        return self.spread(q, torch.finfo(q.dtype).min).argmax(dim=1)

    def highest(self, q: Float[Tensor, " row"]) -> Float[Tensor, " piece"]:
        """Highest value of each piece's valid tasks."""
        return self.spread(q, torch.finfo(q.dtype).min).amax(dim=1)


def pack(obs: Float[Tensor, "*game piece obs"], tasks: Tensor, mask: Tensor) -> TaskSets:
    """Pack dense task sets.

    Args:
        obs: own features of each piece [..., N, Do].
        tasks: its task rows [..., N, K, Dt].
        mask: not 0 where the row is a valid task [..., N, K].
    """
    n_tasks, task_dim = tasks.shape[-2:]
    piece, task = mask.reshape(-1, n_tasks).nonzero(as_tuple=True)
    rows = tasks.reshape(-1, n_tasks, task_dim)[piece, task]
    return TaskSets(obs.reshape(-1, obs.shape[-1]), rows, piece, task, n_tasks)


def pack_observation(observation: Mapping[str, np.ndarray], device: torch.device) -> TaskSets:
    """Pack a batch of the task env's observations (keys obs, tasks, action_mask)."""
    mask = observation["action_mask"]
    n_tasks = mask.shape[-1]
    row = np.flatnonzero(mask)
    tasks = observation["tasks"].reshape(-1, observation["tasks"].shape[-1])[row]
    obs = observation["obs"].reshape(-1, observation["obs"].shape[-1])
    piece, task = np.divmod(row, n_tasks)
    return TaskSets(
        torch.as_tensor(obs, device=device).float(),
        torch.as_tensor(tasks, device=device).float(),
        torch.as_tensor(piece, device=device),
        torch.as_tensor(task, device=device),
        n_tasks,
    )
