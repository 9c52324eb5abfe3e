"""The agent network over task sets (Fig. 4b) as a kernel: no torch, the same to the bit in any batch."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hexwar_sb3.kernels import Rows, kernel


class Net(NamedTuple):
    """Weights as the kernels take them: matrices [input, output], biases [output]."""

    piece_weight: Rows
    piece_bias: Rows
    embed_piece_weight: Rows
    embed_task_weight: Rows
    embed_task_bias: Rows
    embed_weight: Rows
    embed_bias: Rows
    context_piece_weight: Rows
    context_set_weight: Rows
    context_set_bias: Rows
    context_task_weight: Rows
    value_weight: Rows
    value_bias: Rows


@kernel
def add_layer(out: Rows, inputs: Rows, weight: Rows) -> None:
    """Add `inputs @ weight` to `out`, in place; weight: [input, output]. Many inputs are 0."""
    for i in range(inputs.size):
        value = inputs[i]
        if value == 0:
            continue
        for j in range(out.size):
            out[j] += weight[i, j] * value


@kernel
def relu(values: Rows) -> None:
    """Set negative values to 0, in place."""
    for i in range(values.size):
        values[i] = max(values[i], np.float32(0))


@kernel
def embed_tasks(x: Rows, tasks: Rows, mask: Rows, net: Net, h: Rows, z: Rows) -> None:
    """Embed the valid tasks of one piece into h [task, embed], and their mean into z [embed]."""
    shared = net.embed_task_bias.copy()
    add_layer(shared, x, net.embed_piece_weight)
    z[:] = 0
    n_valid = 0
    for k in range(mask.size):
        if mask[k] == 0:
            continue
        first = shared.copy()
        add_layer(first, tasks[k], net.embed_task_weight)
        relu(first)
        h[k] = net.embed_bias
        add_layer(h[k], first, net.embed_weight)
        relu(h[k])
        z += h[k]
        n_valid += 1
    z /= np.float32(max(n_valid, 1))


@kernel
def best_task(obs: Rows, tasks: Rows, mask: Rows, net: Net, h: Rows, z: Rows, q: Rows) -> int:
    """Index of one piece's best valid task, and Q of all its tasks in q.

    Args:
        obs: own features [Do].
        tasks: task rows [K, Dt].
        mask: not 0 where a row is valid [K].
        net: the weights.
        h: scratch [K, embed].
        z: scratch [embed].
        q: values of the tasks [K]; invalid rows hold the lowest number there is.
    """
    x = net.piece_bias.copy()
    add_layer(x, obs, net.piece_weight)
    relu(x)
    embed_tasks(x, tasks, mask, net, h, z)
    context = net.context_set_bias.copy()
    add_layer(context, x, net.context_piece_weight)
    add_layer(context, z, net.context_set_weight)
    for k in range(mask.size):
        q[k] = np.finfo(np.float32).min
        if mask[k] != 0:
            value = context.copy()
            add_layer(value, h[k], net.context_task_weight)
            relu(value)
            q[k] = net.value_bias[0]
            add_layer(q[k : k + 1], value, net.value_weight)
    return int(np.argmax(q))


@kernel
def best_tasks(obs: Rows, tasks: Rows, mask: Rows, net: Net, q: Rows, best: Rows) -> None:
    """Pick the best task of every piece: obs [P, Do], tasks [P, K, Dt], mask [P, K] -> q [P, K], best [P]."""
    z = np.zeros_like(net.embed_bias)
    h = np.zeros((mask.shape[1], z.size), np.float32)
    for i in range(best.size):
        best[i] = best_task(obs[i], tasks[i], mask[i], net, h, z, q[i])
