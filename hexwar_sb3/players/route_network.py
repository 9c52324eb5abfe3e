"""The network of the lower level as a kernel: two layers of 64, as in the paper (III-C)."""

from __future__ import annotations

import numpy as np

from hexwar_sb3.kernels import Row, Rows, kernel
from hexwar_sb3.players.task_network import add_layer, relu
from hexwar_sb3.tasks.features import ROUTE_WIDTH
from hexwar_sb3.tasks.route import N_ANSWERS, STAY

HIDDEN = 64  # width of both layers ("no sophisticated architecture", III-C)

LOWER_NET = np.dtype(
    [
        ("weight1", "f4", (ROUTE_WIDTH, HIDDEN)),  # [input, output], like the others
        ("bias1", "f4", (HIDDEN,)),
        ("weight2", "f4", (HIDDEN, HIDDEN)),
        ("bias2", "f4", (HIDDEN,)),
        ("weight3", "f4", (HIDDEN, N_ANSWERS)),
        ("bias3", "f4", (N_ANSWERS,)),
        ("tie", "f4"),  # values that differ by no more are equal
        ("ways", "u1"),  # 1: it was trained with the fastest ways in its state
    ],
    align=True,
)
"""One network of the lower level, as the drive loop reads it."""


@kernel
def route_values(state: Rows, net: Row, q: Rows) -> None:
    """Values of the answers, valid or not: state f4 [Dl] -> q f4 [7]."""
    first = net.bias1.copy()
    add_layer(first, state, net.weight1)
    relu(first)
    second = net.bias2.copy()
    add_layer(second, first, net.weight2)
    relu(second)
    q[:] = net.bias3
    add_layer(q, second, net.weight3)


@kernel
def best_answer(q: Rows, mask: Rows, tie: float) -> int:
    """The valid answer of the highest value, the first of those at most `tie` below it: q [7], mask [7]."""
    best = STAY
    for a in range(q.size):
        if mask[a] != 0 and (q[a] > q[best] or mask[best] == 0):
            best = a
    for a in range(best):
        if mask[a] != 0 and q[a] >= q[best] - tie:
            return a
    return best
