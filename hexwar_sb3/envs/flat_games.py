"""The core of the flat env: the learner's pieces decide one after the other, each by one plain action."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from hexwar_sb3.engine.fields import check_all, check_range
from hexwar_sb3.engine.state import State
from hexwar_sb3.envs.settings import TaskSettings, task_settings
from hexwar_sb3.envs.task_games import Obs, Span, TaskGames
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.kernels import Rows
from hexwar_sb3.play.arena import Games, Snapshot
from hexwar_sb3.players.fit import check_actions
from hexwar_sb3.players.flat import flat_observation
from hexwar_sb3.rules.indices import CampIndex
from hexwar_sb3.tasks.features import BOUND
from hexwar_sb3.tasks.records import MAX_TASKS
from hexwar_sb3.tasks.route import N_ANSWERS

BEFORE_ALL = -1  # the slot that is followed by the first
_REFUSED = {
    "lower": "its actions give the directions themselves",
    "privileged_state": "its observation is the acting piece's alone",
}


class FlatGames(TaskGames):
    """Games in which a step is the turn of one living piece, by slot; time goes on after the last.

    A piece sees the state of the decision: the turns that others had before it change nothing yet. The
    direction of an action is kept from cell to cell until it is illegal or the piece has its next turn.
    The turns of who shows a game are named by the nearest tasks and the hops that its pieces are about to make.
    """

    keeps_answers = True

    def __init__(self, n_games: int, settings: TaskSettings, seed: int | None = None) -> None:
        super().__init__(n_games, settings, seed)
        shape = self.sight.rows.shape[:2]
        self._first = self.arena.world.sides[:, 0]
        self.acting = np.zeros(n_games, np.int64)  # slot of the piece whose turn it is [n]
        self.picked = np.zeros(shape, np.int64)  # task indices of this decision so far [n, N]
        self.answers = np.zeros(shape, np.int64)  # 0 stay, or 1 + a direction in the camp's frame [n, N]
        self._unshown: dict[int, Snapshot] = {}  # games that are shown, as they were seen at this decision

    def begin(self, which: Games) -> None:
        """Start the next episodes in these slots, up to the first piece's turn."""
        super().begin(which)
        self._open(which)

    def observe(self) -> NDArray[Any]:
        """What the acting pieces see [n, width]."""
        return flat_observation(self.sight.obs, self.all, self.acting)

    def masks(self) -> NDArray[np.bool_]:
        """Legal actions of the acting pieces: a valid task, and a way from the cell or staying [n, K * 7]."""
        _, ways = self.arena.look_routes(self.all, self._first[self.camps] + self.acting, ways=False)
        tasks = self.sight.obs["action_mask"][self.all, self.acting]
        return (tasks[:, :, None] * ways[:, None, :]).reshape(self.n_games, -1).astype(np.bool_)

    def play(self, actions: object) -> Span:
        """Give every acting piece its action; play on to the next decision where it was the last one's turn.

        Args:
            actions: task index * 7 + answer [n]; an illegal one stands for stop, or for staying.

        Raises:
            ConfigError: they are no whole numbers, or of another shape; or no game has begun.
        """
        self.check_begun()
        picked = check_actions(actions, (self.n_games,), axes="")
        before, start = self.scores(), self.arena.state.games.tick.astype(np.int64)
        known = (picked >= 0) & (picked < MAX_TASKS * N_ANSWERS)
        illegal = ~(known & self.masks()[self.all, np.where(known, picked, 0)]) & ~self.demos
        acting = self.all, self.acting
        shown = self.picked[acting] * N_ANSWERS + self.answers[acting]
        demo = {int(b): shown[b] for b in self.all[self.demos]}
        self.picked[acting], self.answers[acting] = np.divmod(np.where(self.demos, shown, picked), N_ANSWERS)
        self._decide(self._pass_on(self.all, self.acting))
        return Span(
            reward=(self.scores() - before).astype(np.float32),
            over=self.arena.over(self.all),
            ticks=self.arena.state.games.tick - start,
            illegal=illegal.astype(np.int64),
            demo=demo,
        )

    def under_way(self) -> NDArray[np.int64]:
        """Action that the acting piece of each game is carrying out; -1: its task is not in its task set [n]."""
        tasks = self.current_tasks(self.sight.obs)[self.all, self.acting]
        kept = self.arena.drives.kept[self.all, self._first[self.camps] + self.acting]
        return np.where(tasks < 0, -1, tasks * N_ANSWERS + kept)

    def _pass_on(self, which: Games, after: NDArray[np.int64] | int) -> Games:
        """Give the turn to the next living piece of each game after a slot; the games that have none."""
        alive = self.sight.obs["alive"][which] > 0
        later = alive & (np.arange(alive.shape[1]) > np.reshape(after, (-1, 1)))
        has_next = later.any(axis=1)
        self.acting[which[has_next]] = later[has_next].argmax(axis=1)
        return which[~has_next]

    def _decide(self, which: Games) -> None:
        """Carry out the decisions of these games, and play to the next ones; a wiped-out camp has none but the end."""
        while which.size:
            learns = which[~self.demos[which]]
            if learns.size:
                self.arena.choose(learns, learns, self.camps[learns], self.picked[learns], self.sight)
                self.arena.keep_answers(learns, self.camps[learns], self.answers[learns])
            self._advance(which)
            lifeless = self._open(which)
            which = lifeless[~self.arena.over(lifeless)]

    def _open(self, which: Games) -> Games:
        """Look, and give the turn to the first living piece of each game; the games that have none."""
        self._take_over(which)
        self.look(which)
        self.picked[which], self.answers[which] = 0, 0
        self._name_turns(which[self.demos[which]])
        return self._pass_on(which, BEFORE_ALL)

    def _name_turns(self, shown: Games) -> None:
        """Let who shows a game make its moves of this decision, and keep the game as it was seen before."""
        self._unshown |= {int(b): self.arena.snapshot_of(int(b)) for b in shown}
        for b, tasks in self._show(shown).items():
            self.picked[b], self.answers[b] = tasks, self.arena.name_moves(b, CampIndex(self.camps[b]))

    def snapshot(self) -> Snapshot:
        """Everything that changes in play; a game that is shown as it was before its moves were made."""
        snapshot = super().snapshot()
        for b in self.all[self.demos]:
            for name, row in self._unshown[b].items():
                snapshot[name][b] = row
        return snapshot

    def restore(self, snapshot: Snapshot, waiting: NDArray[np.bool_] | None = None) -> Obs:
        """Go on where `snapshot` was taken, as `TaskGames.restore`."""
        obs = super().restore(snapshot, waiting)
        self._name_turns(self.all[self.demos])
        return obs

    def _check_slots(self, snapshot: Snapshot, state: State, drives: Rows) -> None:
        super()._check_slots(snapshot, state, drives)
        check_range("answers", snapshot["answers"], 0, N_ANSWERS - 1)
        acting, own = snapshot["acting"], np.diff(self.arena.world.sides, axis=1)[snapshot["camps"], 0]
        check_range("acting", acting, 0, "last", {"last": own - 1})
        lives = state.pieces.blood[self.all, self._first[snapshot["camps"]] + acting] > 0
        check_all("acting", lives | (state.games.over == 1), acting, "a living piece")

    def _slots(self) -> Snapshot:
        return {**super()._slots(), "acting": self.acting, "picked": self.picked, "answers": self.answers}


def flat_spaces(games: FlatGames) -> tuple[spaces.Box, spaces.Discrete]:
    """Spaces of the flat env."""
    sample = games.observe()[0]
    return spaces.Box(-BOUND, BOUND, sample.shape, sample.dtype.type), spaces.Discrete(MAX_TASKS * N_ANSWERS)


def flat_settings(settings: dict[str, Any]) -> TaskSettings:
    """Settings from keywords.

    Raises:
        UnknownSettingError: no such setting.
        ConfigError: one that the flat env cannot have.
    """
    for name in settings:
        if name in _REFUSED:
            raise ConfigError(f"the flat env has no {name}: {_REFUSED[name]}")
    return task_settings(settings)
