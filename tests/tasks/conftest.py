"""A position under test: pieces put where a test wants them, and what the camps then know and may do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hexwar_sb3.engine.records import NO_PIECE
from hexwar_sb3.engine.sight import look_all, remember
from hexwar_sb3.engine.state import new_state, reset_game
from hexwar_sb3.engine.step import has_orders, next_due, process
from hexwar_sb3.engine.text import parse_board
from hexwar_sb3.engine.world import World, load_world
from hexwar_sb3.kernels import Row
from hexwar_sb3.rules.enums import Action, Camp
from hexwar_sb3.rules.indices import CampIndex, CellIndex, PieceIndex
from hexwar_sb3.tasks.choose import assign, choose_tasks, new_missions
from hexwar_sb3.tasks.execute import execute_tasks
from hexwar_sb3.tasks.features import feature_index, sizes
from hexwar_sb3.tasks.observe import observe
from hexwar_sb3.tasks.records import MAX_TASKS, TASK, TaskKind
from hexwar_sb3.tasks.sets import list_tasks
from hexwar_sb3.tasks.spots import load_spots

DECISION_TICKS = 75
N = 7  # pieces a side

OPEN_FIELD = """
    map   plain-41x21
    point main 2111 80
    point second 2117 50
    red   tank 0411
    red   tank 0415
    red   chariot 0512
    red   chariot 0514
    red   soldier aboard chariot0
    red   soldier aboard chariot1
    red   aerocraft 0313
    blue  tank 3811
    blue  tank 3815
    blue  chariot 3612
    blue  chariot 3614
    blue  soldier aboard chariot0
    blue  soldier aboard chariot1
    blue  aerocraft 3913
"""

Mask = NDArray[np.int8]
Choose = Callable[["Board", CampIndex, Any, Mask], NDArray[np.int64]]


class Board:
    """One game, opened for tests."""

    def __init__(self, world: World, seed: int = 0) -> None:
        self.world = world
        self.state = new_state(world, 1)
        reset_game(self.state, 0, world, seed)
        self.game, self.pieces, self.memory, self.paths, self.rounds, self.orders, self.log = self.state.game(
            0
        )
        self.missions = new_missions(1, world.n_pieces)[0]
        self.rules, self.cells, self.los = world.tables
        self.eta = world.eta
        self.spots = load_spots(world)
        self.codes: list[int] = []
        self.actions = np.zeros(len(Action), np.int64)

    def i(self, name: str) -> PieceIndex:
        """Index of "tank0", or of an enemy "blue:tank0"."""
        camp, _, own = name.rpartition(":")
        names = self.world.piece_names(Camp.BLUE if camp == "blue" else Camp.RED)
        return PieceIndex((N if camp == "blue" else 0) + names.index(own))

    def cell(self, x: int, y: int) -> CellIndex:
        return CellIndex(y * self.world.scenario.hexmap.width + x)

    def put(self, name: str, cell: int, **fields: int) -> Row:
        """Stand a piece in a cell, and set some of its fields."""
        piece = self.pieces[self.i(name)]
        piece.cell = cell
        for field, value in fields.items():
            piece[field] = value
        if piece.passenger != NO_PIECE:
            self.pieces[piece.passenger].cell = cell
        return piece

    def land(self, name: str) -> Row:
        """Take a soldier out of its chariot."""
        soldier = self.pieces[self.i(name)]
        self.pieces[soldier.carrier].passenger = NO_PIECE
        soldier.carrier = NO_PIECE
        return soldier

    def look(self) -> None:
        """Let both camps see and remember the position as it stands."""
        look_all(self.pieces, self.rules, self.cells, self.los)
        remember(self.game, self.pieces, self.memory, self.paths, self.cells)

    def sets(self, camp: CampIndex = Camp.RED, k: int = MAX_TASKS) -> tuple[Any, Mask]:
        """Task sets [N, K] and mask of a camp."""
        tasks: Any = np.zeros((N, k), TASK).view(np.recarray)
        mask = np.zeros((N, k), np.int8)
        list_tasks(
            camp,
            self.game,
            self.pieces,
            self.memory,
            self.rules,
            self.cells,
            self.eta,
            self.spots,
            tasks,
            mask,
        )
        return tasks, mask

    def listed(self, name: str) -> list[tuple[TaskKind, int, int]]:
        """The task set of a piece as (kind, target, cell)."""
        i = self.i(name)
        tasks, mask = self.sets(Camp(i // N))
        rows = tasks[i % N][mask[i % N] == 1]
        return [(TaskKind(row.kind), int(row.target), int(row.cell)) for row in rows]

    def kinds(self, name: str) -> set[TaskKind]:
        return {kind for kind, _, _ in self.listed(name)}

    def observation(self, camp: CampIndex = Camp.RED) -> dict[str, NDArray[Any]]:
        """obs, rows, mask and alive of a camp."""
        width = sizes(N, N, len(self.world.scenario.points))
        tasks, mask = self.sets(camp)
        out = {
            "obs": np.full((N, width.obs), np.nan, np.float32),
            "rows": np.full((N, MAX_TASKS, width.row), np.nan, np.float32),
            "alive": np.full(N, np.nan, np.float32),
        }
        observe(
            camp, self.game, self.pieces, self.memory, self.missions, self.rules, self.cells, self.los, self.eta,
            tasks, mask, out["obs"], out["rows"], out["alive"],
        )  # fmt: skip
        return out | {"mask": mask, "tasks": tasks}

    def feature(self, name: str, feature: str) -> list[float]:
        """Numbers of one feature of a red piece's observation."""
        place = feature_index("obs", N, N, len(self.world.scenario.points))[feature]
        return [float(x) for x in self.observation()["obs"][self.i(name), place]]

    def row_feature(
        self, name: str, kind: TaskKind, feature: str, target: PieceIndex = NO_PIECE
    ) -> list[float]:
        """Numbers of one feature of the first task row of a kind (and a target) of a red piece."""
        seen = self.observation()
        tasks = seen["tasks"][self.i(name)]
        fits = (tasks.kind == kind) & ((tasks.target == target) | (target == NO_PIECE))
        k = np.flatnonzero(fits & (seen["mask"][self.i(name)] == 1))[0]
        return [
            float(x) for x in seen["rows"][self.i(name), k, feature_index("row", N, N, 2)[f"task: {feature}"]]
        ]

    def task(self, name: str, kind: TaskKind, target: int = NO_PIECE, cell: int = -1) -> Row:
        """Give a piece a task now; returns its mission."""
        mission = self.missions[self.i(name)]
        assign(mission, kind, PieceIndex(target), CellIndex(cell), self.game.tick)
        return mission

    def execute(self, camp: CampIndex = Camp.RED) -> None:
        execute_tasks(
            camp, self.game, self.pieces, self.memory, self.paths, self.rounds, self.orders, self.missions,
            self.rules, self.cells, self.los, self.eta,
        )  # fmt: skip

    def ordered(self, name: str) -> Action:
        """What `execute` orders a piece now."""
        i = self.i(name)
        self.orders.kind = Action.NULL
        self.execute(Camp(i // N))
        return Action(self.orders[i].kind)

    def run(self, until: int) -> None:
        """Play on under the tasks given, to tick `until` or the end; notes the codes of all orders."""
        while not self.game.over and self.game.tick < until:
            self.execute(Camp.RED)
            self.execute(Camp.BLUE)
            given = self.orders.kind.copy()
            if not has_orders(self.orders):
                due = int(next_due(self.game, self.pieces, self.rounds))
                if due >= until:
                    self.game.tick = until
                    return
                self.game.tick = due
            process(
                self.game, self.pieces, self.memory, self.paths, self.rounds, self.orders, self.log,
                self.rules, self.cells, self.los,
            )  # fmt: skip
            self.codes += self.orders.code[given != Action.NULL].tolist()
            np.add.at(self.actions, given, 1)

    def decide(self, camp: CampIndex, choose: Choose) -> None:
        """Let a chooser give the tasks of a camp."""
        tasks, mask = self.sets(camp)
        choose_tasks(camp, choose(self, camp, tasks, mask), self.game, tasks, mask, self.missions)

    def play(self, ticks: int, choose: Choose) -> None:
        """Play with both camps' tasks chosen every 75 ticks."""
        end = min(self.game.tick + ticks, int(self.game.end_tick))
        while self.game.tick < end and not self.game.over:
            for camp in (Camp.RED, Camp.BLUE):
                self.decide(camp, choose)
            self.run(min(end, int(self.game.tick) + DECISION_TICKS))


def sticky_choice(seed: int) -> Choose:
    """A chooser that keeps a random task for a few decisions; the same for both camps."""
    rng = np.random.default_rng(seed)
    draws = rng.random((1000, N))

    def choose(board: Board, camp: CampIndex, _tasks: Any, mask: Mask) -> NDArray[np.int64]:
        decision = int(board.game.tick) // DECISION_TICKS
        salt = draws[decision // 5 + 100 * camp]
        return (salt * mask.sum(axis=1)).astype(np.int64)

    return choose


@pytest.fixture(scope="session")
def world() -> World:
    return load_world("plain")


@pytest.fixture
def board(world: World) -> Board:
    """The start of the scenario "plain"."""
    return Board(world)


@pytest.fixture(scope="session")
def open_world() -> World:
    return load_world(parse_board(OPEN_FIELD).scenario)


@pytest.fixture
def field(open_world: World) -> Board:
    """The same pieces on a flat, empty map, where everything in range is seen."""
    return Board(open_world)


@pytest.fixture
def middle(world: World) -> Callable[[int], Board]:
    """A position from the middle of a game of random tasks, by seed."""

    def play(seed: int) -> Board:
        board = Board(world, seed)
        board.play(300 + 150 * (seed % 8), sticky_choice(seed))
        return board

    return play


@pytest.fixture
def sticky() -> Callable[[int], Choose]:
    return sticky_choice
