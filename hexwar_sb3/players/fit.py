"""Whether a player fits the games it enters: their pieces, tasks and features; and whether its answers do."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from hexwar_sb3.engine.roster import camp_name
from hexwar_sb3.engine.world import World
from hexwar_sb3.errors import ConfigError, shortened
from hexwar_sb3.players.flat import FlatPlayer
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.player import BotPlayer, ModelPlayer, Seat, seat_name
from hexwar_sb3.rules.enums import Camp
from hexwar_sb3.tasks.features import world_sizes
from hexwar_sb3.tasks.records import MAX_TASKS
from hexwar_sb3.tasks.route import N_ANSWERS

Shape = tuple[int, ...]


def check_fit(seat: Seat, world: World, camp: int, name: str | None = None) -> None:
    """Check that a player can play a camp of a scenario, as far as it says what it was made for.

    Args:
        seat: from `make_player`.
        world: of the games.
        camp: that it is to play.
        name: what it is called in the message, if not by its type.

    Raises:
        ConfigError: it is for other pieces, tasks or features; with the expected sizes and its own.
    """
    problem = why_unfit(seat, world)
    if problem:
        where = f"{camp_name(Camp(camp))} of scenario {world.scenario.name!r}"
        raise ConfigError(f"player {name or seat_name(seat)!r} cannot play {where}: {problem}")


def why_unfit(seat: Seat, world: World) -> str | None:
    """Say what does not fit in either camp of a world, or None."""
    if isinstance(seat, BotPlayer):
        return None
    shapes = _shapes(world)
    pieces, tasks = shapes["action_mask"]
    if isinstance(seat, FrozenPolicy):
        found = (seat.n_pieces, seat.n_tasks, seat.sizes["obs"], seat.sizes["task"])
        expected = (pieces, tasks, shapes["obs"][-1], shapes["tasks"][-1])
        return _difference("(pieces, tasks, features, task features)", found, expected)
    if isinstance(seat, FlatPlayer):
        width = shapes["obs"][-1] + tasks * shapes["tasks"][-1]
        its = seat.model.observation_space.shape
        return _difference("observations of the shape", its, (width,)) or _why_other_actions(
            seat.model, spaces.Discrete(tasks * N_ANSWERS)
        )
    if isinstance(seat, ModelPlayer):
        return _why_other_observations(seat.model, shapes) or _why_other_actions(
            seat.model, spaces.MultiDiscrete([tasks] * pieces)
        )
    return None


def _shapes(world: World) -> dict[str, Shape]:
    """What a player of either camp sees, apart from the axis of games."""
    width, pieces = world_sizes(world), world.n_slots
    return {
        "obs": (pieces, width.obs),
        "tasks": (pieces, MAX_TASKS, width.row),
        "action_mask": (pieces, MAX_TASKS),
        "alive": (pieces,),
    }


def _difference(what: str, found: object, expected: object) -> str | None:
    return None if found == expected else f"expected {what} {expected}, found {found}"


def _why_other_observations(model: Any, shapes: Mapping[str, Shape]) -> str | None:
    space = getattr(model, "observation_space", None)
    if space is None:
        return None
    if not isinstance(space, spaces.Dict):
        return f"expected a Dict of observations {dict(shapes)}, found {shortened(str(space))}"
    found = {key: part.shape for key, part in space.spaces.items()}
    if hasattr(getattr(model, "policy", None), "lower"):  # of ours, which acts without the mixer's state
        found.pop("state", None)
    unknown = sorted(found.keys() - shapes.keys())
    if unknown:
        return f"it reads {unknown}, players see {sorted(shapes)}"
    return _difference("observations", found, {key: shapes[key] for key in found})


def _why_other_actions(model: Any, expected: spaces.Space[Any]) -> str | None:
    space = getattr(model, "action_space", None)
    return None if space is None else _difference("actions", space, expected)


def check_actions(actions: object, expected: Shape, axes: str = "(games, pieces) = ") -> NDArray[np.int64]:
    """Return actions as whole numbers, before a kernel takes their shape for granted.

    Raises:
        ConfigError: they are no whole numbers, or too many or too few.
    """
    rule = f"actions must be whole numbers of shape {axes}{expected}"
    try:
        found = np.asarray(actions)
    except (ValueError, TypeError, RuntimeError) as error:  # ragged lists, tensors of another device
        raise ConfigError(f"{rule}: {error}") from error
    if found.shape != expected or found.dtype.kind not in "iu":
        raise ConfigError(f"{rule}, got {found.dtype} {found.shape}")
    return np.array(found, np.int64, order="C")  # a copy: kernels take no read-only ones


def check_tasks(tasks: object, expected: Shape) -> NDArray[np.int64]:
    """Return what a player picked: task indices, whether valid now or not.

    Raises:
        ConfigError: they are none.
    """
    picked = check_actions(tasks, expected)
    if ((picked < 0) | (picked >= MAX_TASKS)).any():
        found = f"{picked.min()}..{picked.max()}"
        raise ConfigError(f"tasks must be in 0..{MAX_TASKS - 1}, got {found}")
    return picked
