"""Networks that do not see which camp they play: on a mirrored map both are one, in the camp's own frame.

What is learned as red then serves as blue: twice the games for each.
"""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import nn

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.policies.shapes import TaskShapes
from hexwar_sb3.tasks.features import sizes


def columns_of_the_camp(shapes: TaskShapes, state_dim: int) -> tuple[list[int], list[int]]:
    """Where observation and state of the task env say which camp it is: in their last feature.

    Args:
        shapes: of the env.
        state_dim: of what the mixer reads: the true state, or all observations one after the other.

    Raises:
        ConfigError: it is another env.
    """
    if shapes.task_dim != sizes(1, 1, 1).row:
        raise ConfigError("mirrored networks are for the task env: leave `mirrored` out")
    step = shapes.obs_dim if state_dim == shapes.n_pieces * shapes.obs_dim else state_dim
    return [shapes.obs_dim - 1], list(range(step - 1, state_dim, step))


def leave_out(layer: nn.Linear, columns: Sequence[int]) -> None:
    """Let a layer never see some of its inputs: their weights are 0, and stay 0 as it learns."""
    places = torch.tensor(columns)
    with torch.no_grad():
        layer.weight.index_fill_(1, places, 0.0)
    layer.weight.register_hook(  # type: ignore[no-untyped-call]
        lambda grad: grad.index_fill(1, places.to(grad.device), 0.0)
    )
