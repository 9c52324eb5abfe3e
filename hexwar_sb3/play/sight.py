"""What the players of a batch of games see and pick: buffers, and the kernels that fill them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.engine.records import NEVER, GameRecord, PieceRecord
from hexwar_sb3.engine.world import World
from hexwar_sb3.kernels import Rows, kernel
from hexwar_sb3.maps.cells import NO_CELL, Cells
from hexwar_sb3.play.drive import ended_tasks
from hexwar_sb3.play.records import DriveRecord
from hexwar_sb3.rules.indices import CampIndex, CellIndex
from hexwar_sb3.tasks.choose import choose_tasks
from hexwar_sb3.tasks.features import world_sizes
from hexwar_sb3.tasks.observe import global_state, observe
from hexwar_sb3.tasks.records import MAX_TASKS, TASK, MissionRecord, Missions
from hexwar_sb3.tasks.route import STAY, observe_route
from hexwar_sb3.tasks.sets import list_tasks


class Sight:
    """Buffers for one observation of `n` games by a camp each, filled in place.

    Args:
        world: scenario and rules; either camp may look, N is the pieces of the larger one.
        n: games.
        dtype: float32 or float16, of everything but masks.
        with_state: also the mixer's true state.
    """

    def __init__(self, world: World, n: int, *, dtype: str = "float32", with_state: bool = False) -> None:
        width, slots = world_sizes(world), world.n_slots
        self.rows = np.zeros((n, slots, MAX_TASKS), TASK).view(np.recarray)
        self._full: dict[str, NDArray[Any]] = {
            "obs": np.zeros((n, slots, width.obs), np.float32),
            "tasks": np.zeros((n, slots, MAX_TASKS, width.row), np.float32),
            "action_mask": np.zeros((n, slots, MAX_TASKS), np.int8),
            "alive": np.zeros((n, slots), np.float32),
            "state": np.zeros((n, width.state if with_state else 0), np.float32),
        }
        self.obs = {key: _in_dtype(value, dtype) for key, value in self._full.items()}
        if not with_state:
            del self.obs["state"]

    @property
    def out(self) -> tuple[NDArray[Any], ...]:
        """The buffers that `look_batch` fills, in its order."""
        full = self._full
        return self.rows, full["action_mask"], full["obs"], full["tasks"], full["alive"], full["state"]

    def publish(self, slots: NDArray[np.int64]) -> None:
        """Bring what `look_batch` wrote to `obs`, where that has another precision."""
        for key, value in self.obs.items():
            if value is not self._full[key]:
                value[slots] = self._full[key][slots]


def _in_dtype(full: NDArray[Any], dtype: str) -> NDArray[Any]:
    """The array itself, or one for its numbers in half precision (kernels know only full)."""
    same = full.dtype in (np.dtype(dtype), np.dtype(np.int8))
    return full if same else np.zeros(full.shape, dtype)


@kernel
def look_batch(
    slots: Rows, which: Rows, camps: Rows, games: Rows, pieces: Rows, memory: Rows, missions: Rows,
    rules_array: Rows, cells: Rows, los: Rows, eta: Rows, spots: Rows, rows: Rows, mask: Rows, obs: Rows,
    tasks: Rows, alive: Rows, state: Rows,
) -> None:  # fmt: skip
    """Fill slot slots[k] of the buffers with what camp camps[k] of game which[k] sees.

    Args:
        slots, which, camps: [n].
        rows, mask, obs, tasks, alive, state: the buffers of a `Sight`, [slots, ...].
    """
    rules = rules_array[0]
    for k in range(which.size):
        s, b, camp = slots[k], which[k], camps[k]
        list_tasks(camp, games[b], pieces[b], memory[b], rules, cells, eta, spots, rows[s], mask[s])
        observe(
            camp, games[b], pieces[b], memory[b], missions[b], rules, cells, los, eta,
            rows[s], mask[s], obs[s], tasks[s], alive[s],
        )  # fmt: skip
        if state.shape[1] > 0:
            global_state(camp, games[b], pieces[b], rules, cells, state[s])


@kernel
def choose_batch(
    slots: Rows, which: Rows, camps: Rows, actions: Rows, drives: Rows, games: Rows, missions: Rows,
    rows: Rows, mask: Rows, illegal: Rows,
) -> None:  # fmt: skip
    """Give the pieces of camp camps[k] in game which[k] the tasks that actions[k] names.

    Args:
        slots, which, camps: [n]; actions: task indices [n, N].
        rows, mask: the task sets that were seen, [slots, N, K].
        illegal: out, actions of each game that name no valid task, [n]; they stand for stop.
    """
    for k in range(which.size):
        s, b, camp = slots[k], which[k], camps[k]
        illegal[k] = count_illegal(actions[k], mask[s])
        choose_tasks(camp, actions[k], games[b], rows[s], mask[s], missions[b])
        note_decision(camp, drives[b], games[b], missions[b])


@kernel
def count_illegal(actions: Rows, mask: Rows) -> int:
    """Number of actions [N] that are out of range or masked in mask [N, K]."""
    count = 0
    for n in range(actions.size):
        if actions[n] < 0 or actions[n] >= mask.shape[1] or mask[n, actions[n]] == 0:
            count += 1
    return count


@kernel
def note_decision(camp: CampIndex, drive: DriveRecord, game: GameRecord, missions: Missions) -> None:
    """A camp has decided: it acts in this very state, and starts to wait for its next cause."""
    drive.due[camp] = 0
    drive.fresh[camp] = 1
    drive.decided_at[camp] = game.tick
    drive.ended[camp] = ended_tasks(camp, game, missions)


@kernel
def observe_routes(
    which: Rows, numbers: Rows, ways: bool, pieces: Rows, missions: Rows, rules_array: Rows, cells: Rows, eta: Rows,
    states: Rows, masks: Rows,
) -> None:  # fmt: skip
    """Write what the lower level reads of piece numbers[k] in game which[k], on its way to `mission.goal`.

    Of a piece under way it is what it will read where it is about to arrive.

    Args:
        which, numbers: [n].
        states: out, [n, Dl]; masks: out, [n, 7].
    """
    for k in range(which.size):
        piece, mission = pieces[which[k], numbers[k]], missions[which[k], numbers[k]]
        cell = heading(piece, mission, cells)
        goal = mission.goal if mission.goal != NO_CELL else cell
        observe_route(
            piece.kind, piece.camp, mission.kind, cell, goal, ways, rules_array[0], cells, eta,
            states[k], masks[k],
        )  # fmt: skip


@kernel
def heading(piece: PieceRecord, mission: MissionRecord, cells: Cells) -> CellIndex:
    """The cell that a piece is about to enter, by its last answer; else the one where it stands."""
    if piece.arrives_at == NEVER or mission.direction == STAY:
        return CellIndex(piece.cell)
    return CellIndex(cells[piece.cell].neighbour[mission.direction - 1])
