"""What a camp's networks read: kernels that write observations, task rows and the mixer's state."""

from __future__ import annotations

from hexwar_sb3.kernels import Row, Rows, kernel


@kernel
def observe(
    camp: int, game: Row, pieces: Rows, memory: Rows, plans: Rows, rules: Row, cells: Rows, los: Rows, eta: Rows,
    tasks: Rows, mask: Rows, obs: Rows, rows: Rows, alive: Rows,
) -> None:  # fmt: skip
    """Write one camp's observation (fogged, in the camp's frame).

    Args:
        tasks, mask: the camp's task sets, from `list_tasks`, [N, K].
        obs: out, f4 [N, Do]; rows: out, f4 [N, K, Dt]; alive: out, f4 [N].
    """


@kernel
def global_state(camp: int, game: Row, pieces: Rows, rules: Row, cells: Rows, state: Rows) -> None:
    """Write the true state, for the mixer in training only: f4 [Ds], in the camp's frame."""
