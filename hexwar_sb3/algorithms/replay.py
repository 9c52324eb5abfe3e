"""The replay buffer: each step of each game is stored once, n steps are put together when drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import torch
from gymnasium import spaces
from jaxtyping import Bool, Float, Int
from numpy.typing import NDArray
from torch import Tensor

from hexwar_sb3.algorithms.checkpoint_arrays import FLAGS, MOST_REWARD, Joined, check_box, check_flags
from hexwar_sb3.algorithms.td_targets import n_step_return, row_discount
from hexwar_sb3.engine.fields import check_all, check_form, check_names, check_range, refuse
from hexwar_sb3.errors import ConfigError, TrainingError
from hexwar_sb3.players.terms import DECISION_TICKS
from hexwar_sb3.policies.shapes import TaskShapes
from hexwar_sb3.policies.task_sets import TaskSets, pack_observation

AGE_EXPONENT = 2  # new steps are drawn more often than old ones; 1 draws evenly
HALF_BOUND = 16.0  # features of at most this size lose nothing that matters in float16


@dataclass(frozen=True)
class Situation:
    """What the networks see of a batch of situations."""

    sets: TaskSets  # of B * N pieces
    state: Float[Tensor, "batch state"]
    alive: Float[Tensor, "batch piece"]


@dataclass(frozen=True)
class Batch:
    """Transitions over one or more steps each."""

    now: Situation
    then: Situation  # after the steps
    tasks: Int[Tensor, " batch*piece"]  # the task that each piece was given
    reward: Float[Tensor, "batch reward"]  # return over the steps, in points; each agent's own, if they have
    discount: Float[Tensor, "batch 1"]
    terminated: Float[Tensor, "batch 1"]
    inside: Bool[Tensor, " batch"]  # False for padding after an episode's end


def situation_of(observation: Mapping[str, NDArray[Any]], device: torch.device) -> Situation:
    """Situation of a batch of observations, as the env gives them."""
    obs = observation["obs"]
    state = observation.get("state", obs.reshape(len(obs), -1))
    return Situation(
        pack_observation(observation, device),
        torch.as_tensor(state, device=device).float(),
        torch.as_tensor(observation["alive"], device=device).float(),
    )


class StepReplay:
    """A ring of steps for each game, float16 where harmless.

    A row holds the observation of a step and what followed; the observation after it is the next row's.
    An episode that was cut short ends with a row that holds its last observation only. Of the task sets, most of
    which is masked, the valid rows alone are kept.

    Args:
        buffer_size: steps of all games together.
        observation_space: of the task env.
        action_space: of the task env.
        device: of the batches.
        n_envs: games at a time.
        gamma: discount of 75 ticks.
        individual_rewards: keep info["rewards"], each agent's own, in place of the team's.
    """

    def __init__(
        self,
        buffer_size: int,
        observation_space: spaces.Space[Any],
        action_space: spaces.Space[Any],
        device: torch.device,
        n_envs: int,
        gamma: float = 0.99,
        *,
        individual_rewards: bool = False,
    ) -> None:
        shapes = TaskShapes.of(observation_space, action_space)
        self.n_envs, self.rows, self.device, self.gamma = n_envs, max(buffer_size // n_envs, 2), device, gamma
        self.n_pieces, self.n_tasks = shapes.n_pieces, shapes.n_tasks
        size = (n_envs, self.rows)
        boxes = self._boxes = dict(cast("spaces.Dict", observation_space).items())
        features = boxes.pop("tasks")
        self.obs = {key: np.zeros((*size, *(box.shape or ())), _storage(box)) for key, box in boxes.items()}
        self._none = np.zeros((0, shapes.task_dim), _storage(features))
        ends = (
            cast("spaces.Box", features).low.min(axis=(0, 1)),
            cast("spaces.Box", features).high.max(axis=(0, 1)),
        )
        self._row_box = spaces.Box(*ends, dtype=cast("Any", features.dtype))  # of one row of a task set
        # Valid rows of all pieces [n, task_dim], of each step: number game * rows + row.
        self.sets = [self._none] * (n_envs * self.rows)
        self.tasks = np.zeros((*size, shapes.n_pieces), np.int16)
        self._own_rewards = individual_rewards
        self.reward = np.zeros((*size, shapes.n_pieces) if individual_rewards else size, np.float32)
        self.discount = np.zeros(size, np.float32)
        self.terminated = np.zeros(size, bool)
        self.done = np.zeros(size, bool)
        self.is_step = np.zeros(size, bool)  # a whole step, not only an observation
        self.next_row = np.zeros(n_envs, np.int64)
        self.used = 0  # rows that were ever written

    def add(
        self,
        obs: Mapping[str, NDArray[Any]],
        next_obs: Mapping[str, NDArray[Any]],
        action: NDArray[np.int64],
        reward: NDArray[np.float32],
        done: NDArray[np.bool_],
        infos: list[dict[str, Any]],
    ) -> None:
        """Store one step of every game; `next_obs` holds the last observation of games that ended.

        Of `infos` it reads `ticks` (one decision if missing), `demo_actions` (what another player did in
        the learner's seat: stored instead of `action`) and SB3's `TimeLimit.truncated`.

        Raises:
            TrainingError: a stored task was masked.
        """
        game = np.arange(self.n_envs)
        row = self.next_row
        cut = np.array([info.get("TimeLimit.truncated", False) for info in infos])
        self._write(row, obs)
        self.tasks[game, row] = [info.get("demo_actions", action[b]) for b, info in enumerate(infos)]
        self._check_tasks(row)
        self.reward[game, row] = self._rewards_of(infos) if self._own_rewards else reward
        self.discount[game, row] = [
            row_discount(self.gamma, info.get("ticks", DECISION_TICKS)) for info in infos
        ]
        self.terminated[game, row] = done & ~cut
        self.done[game, row] = done
        self.is_step[game, row] = True
        after = (row + 1) % self.rows
        self._write(after, next_obs)
        self.is_step[game, after] = False
        self.next_row = np.where(cut, (after + 1) % self.rows, after)
        self.is_step[game, self.next_row] = False
        self.used = self.rows if (after < row).any() else max(self.used, int(after.max()) + 1)

    def _rewards_of(self, infos: list[dict[str, Any]]) -> NDArray[Any]:
        """Each agent's own reward [n_envs, N]."""
        rewards: list[Any] = [info.get("rewards", ()) for info in infos]
        for one in rewards:
            if np.shape(one) != (self.n_pieces,):
                raise ConfigError(
                    f"individual_rewards needs info['rewards'], a number for each of {self.n_pieces} agents, as"
                    f" JointActionEnv gives it; found {np.size(one)} numbers"
                )
        return np.array(rewards, np.float32)

    def _write(self, row: NDArray[np.int64], obs: Mapping[str, NDArray[Any]]) -> None:
        game = np.arange(self.n_envs)
        for key, stored in self.obs.items():
            stored[game, row] = obs[key]
        mask = obs["action_mask"] != 0
        self._keep_sets(game * self.rows + row, mask, obs["tasks"][mask].astype(self._none.dtype))

    def _keep_sets(self, steps: NDArray[np.int64], mask: NDArray[np.bool_], valid: NDArray[Any]) -> None:
        """Deal valid rows [n, task_dim] out to their steps [B], by the steps' masks [B, N, K]."""
        counts = mask.sum(axis=(1, 2))
        ends = counts.cumsum()
        for step, start, end in zip(steps.tolist(), (ends - counts).tolist(), ends.tolist(), strict=True):
            self.sets[step] = valid[start:end]

    def _check_tasks(self, row: NDArray[np.int64]) -> None:
        game = np.arange(self.n_envs)
        tasks = self.tasks[game, row].astype(np.int64)
        known = (tasks >= 0) & (tasks < self.n_tasks)
        valid = np.take_along_axis(
            self.obs["action_mask"][game, row], np.where(known, tasks, 0)[..., None], axis=-1
        )
        if not (known & (valid[..., 0] != 0)).all():
            raise TrainingError(f"a masked task was played or demonstrated: tasks {tasks.tolist()}")

    def cut_short(self) -> None:
        """End the running episodes where they are: the env was reset between two steps."""
        game = np.arange(self.n_envs)
        last = (self.next_row - 1) % self.rows
        running = self.is_step[game, last] & ~self.done[game, last]
        self.done[game, last] |= running
        self.next_row = np.where(running, (self.next_row + 1) % self.rows, self.next_row)
        self.is_step[game, self.next_row] = False

    def __len__(self) -> int:
        """Steps that can be drawn."""
        return int(self.is_step.sum())

    def sample(self, batch_size: int, n_steps: int, rng: np.random.Generator) -> Batch:
        """Draw transitions over up to `n_steps` steps; fewer at an episode's end and at the newest row."""
        game, start = self._draw(batch_size, rng)
        rows, inside = self._walk(game, start, n_steps)
        at = (game[:, None], rows)
        reward, discount = n_step_return(
            self._rewards(at),
            self._tensor(self.discount[at]),
            torch.as_tensor(inside, device=self.device),
        )
        last = rows[np.arange(batch_size), inside.sum(axis=1) - 1]
        return self._batch(game, start, last, reward, discount, np.ones(batch_size, bool))

    def sample_windows(
        self, n_windows: int, length: int, rng: np.random.Generator, *, reach_back: bool = False
    ) -> Batch:
        """Draw runs of `length` single steps [n_windows * length], for λ-returns.

        Args:
            n_windows: runs.
            length: steps of each; those past the end of a game are not `inside`.
            rng: draws.
            reach_back: a run begins where its game does, or as far back as the step that was drawn is still in it.
        """
        game, start = self._draw(n_windows, rng)
        if reach_back:
            start = self._back(game, start, length - 1)
        rows, inside = self._walk(game, start, length)
        game, flat = game.repeat(length), rows.reshape(-1)
        reward, discount = self._rewards((game, flat)), self._tensor(self.discount[game, flat, None])
        return self._batch(game, flat, flat, reward, discount, inside.reshape(-1))

    def _rewards(self, at: tuple[NDArray[np.int64], NDArray[np.int64]]) -> Tensor:
        """Rewards of some steps, on a last axis: the team's, or the agents'."""
        return self._tensor(self.reward[at] if self._own_rewards else self.reward[at][..., None])

    def _draw(self, count: int, rng: np.random.Generator) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Game and row of some steps, new ones more often: the newest tenth makes a third of what is drawn."""
        if not self.is_step.any():
            raise ConfigError("the replay buffer is empty: nothing can be learned before the first step")
        games, rows = np.zeros((2, 0), np.int64)
        while len(games) < count:
            game = rng.integers(self.n_envs, size=count)
            age = (rng.random(count) ** AGE_EXPONENT * self.used).astype(np.int64)
            row = (
                self.next_row[game] - 1 - age
            ) % self.used  # whatever a file says of `next_row`: all of them
            drawn = self.is_step[game, row]
            games, rows = np.append(games, game[drawn]), np.append(rows, row[drawn])
        return games[:count], rows[:count]

    def _walk(
        self, game: NDArray[np.int64], start: NDArray[np.int64], length: int
    ) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Rows of the steps from `start` on [B, length], and whether each is still the same episode's."""
        rows = (start[:, None] + np.arange(length)) % self.rows
        at = (game[:, None], rows)
        goes_on = self.is_step[at][:, 1:] & ~self.done[at][:, :-1]
        inside = np.concatenate([np.ones((len(game), 1), bool), goes_on], axis=1)
        return rows, np.logical_and.accumulate(inside, axis=1)

    def _back(self, game: NDArray[np.int64], row: NDArray[np.int64], most: int) -> NDArray[np.int64]:
        """Rows of steps of the same episodes up to so many steps earlier."""
        for _ in range(most):
            before = (row - 1) % self.rows
            goes_on = self.is_step[game, before] & ~self.done[game, before]
            if not goes_on.any():
                break
            row = np.where(goes_on, before, row)
        return row

    def _batch(
        self,
        game: NDArray[np.int64],
        start: NDArray[np.int64],
        last: NDArray[np.int64],
        reward: Tensor,
        discount: Tensor,
        inside: NDArray[np.bool_],
    ) -> Batch:
        return Batch(
            now=self._situation(game, start),
            then=self._situation(game, (last + 1) % self.rows),
            tasks=torch.as_tensor(self.tasks[game, start].reshape(-1), device=self.device).long(),
            reward=reward,
            discount=discount,
            terminated=self._tensor(self.terminated[game, last, None]),
            inside=torch.as_tensor(inside, device=self.device),
        )

    def _situation(self, game: NDArray[np.int64], row: NDArray[np.int64]) -> Situation:
        """Gather the valid task rows and nothing else of the task sets."""
        step = game * self.rows + row
        mask = _by_step(self.obs["action_mask"])[step].reshape(-1, self.n_tasks)
        piece, task = np.nonzero(mask)
        features = np.concatenate([self.sets[k] for k in step.tolist()])
        obs = self._tensor(_by_step(self.obs["obs"])[step])
        state = self._tensor(_by_step(self.obs["state"])[step]) if "state" in self.obs else obs.flatten(1)
        index = (torch.as_tensor(piece, device=self.device), torch.as_tensor(task, device=self.device))
        sets = TaskSets(obs.flatten(0, 1), self._tensor(features), *index, self.n_tasks)
        return Situation(sets, state, self._tensor(_by_step(self.obs["alive"])[step]))

    def _tensor(self, values: NDArray[Any]) -> Tensor:
        return torch.as_tensor(values, device=self.device).float()

    def snapshot(self) -> dict[str, Any]:
        """Everything that is stored, by name, without rows that were never written; for `write_arrays`."""
        parts = {name: array[:, : self.used] for name, array in self._arrays().items()}
        sets = Joined([self._none, *(self.sets[k] for k in self._used_steps().tolist())])
        return {**parts, "sets": sets, "next_row": self.next_row}

    def _used_steps(self) -> NDArray[np.int64]:
        """Numbers of the steps that were ever written, game by game."""
        return (np.arange(self.n_envs)[:, None] * self.rows + np.arange(self.used)).ravel()

    def restore(self, parts: Mapping[str, NDArray[Any]]) -> None:
        """Take over what `snapshot` gave.

        Raises:
            ConfigError: it is of another number of games, or larger than this replay.
            CheckpointError: it is broken; the replay is as it was.
        """
        parts = {name: np.asarray(array) for name, array in parts.items()}  # a `Joined` too
        self.used = used = self._check(parts)
        self.is_step[:] = False
        for name, array in self._arrays().items():
            array[:, :used] = parts[name]
        mask = self.obs["action_mask"][:, :used].reshape(-1, self.n_pieces, self.n_tasks) != 0
        self._keep_sets(self._used_steps(), mask, parts["sets"])
        self.next_row = np.array(parts["next_row"])

    def _check(self, parts: Mapping[str, NDArray[Any]]) -> int:
        """Check what another replay gave; the rows that it used."""
        own = self._arrays()
        check_names(parts, [*own, "sets", "next_row"])
        games, used = (
            shape if len(shape := np.shape(parts["done"])) == 2 else refuse("done", shape, "two axes")
        )
        if games != self.n_envs or used > self.rows:
            found, room = f"{used} steps of {games} games", f"{self.rows} of {self.n_envs}"
            raise ConfigError(f"the stored replay holds {found}, this one has room for {room}")
        for name, array in own.items():
            check_form(name, parts[name], array.dtype, (games, used, *array.shape[2:]))
        for key, box in self._boxes.items():
            check_box(f"obs_{key}", parts[f"obs_{key}"], box)
        for key in FLAGS:
            check_flags(f"obs_{key}", parts[f"obs_{key}"])
        mask = parts["obs_action_mask"]
        check_form(
            "sets", parts["sets"], self._none.dtype, (int(mask.sum(dtype=np.int64)), *self._none.shape[1:])
        )
        check_box("sets", parts["sets"], self._row_box)
        self._check_steps(parts, mask, used)
        return used

    def _check_steps(self, parts: Mapping[str, NDArray[Any]], mask: NDArray[Any], used: int) -> None:
        reward, done, is_step = parts["reward"], parts["done"], parts["is_step"]
        check_range("reward", reward, -MOST_REWARD, MOST_REWARD)
        check_range("discount", parts["discount"], 0.0, 1.0)
        check_all("terminated", done | ~parts["terminated"], parts["terminated"], "the end of a game")
        tasks = parts["tasks"].astype(np.int64)
        check_range("tasks", tasks, 0, self.n_tasks - 1)
        valid = np.take_along_axis(mask, tasks[..., None], axis=-1)[..., 0] != 0
        check_all("tasks", valid | ~is_step[..., None], tasks, "tasks that were not masked")
        next_row = parts["next_row"]
        check_form("next_row", next_row, np.int64, (self.n_envs,))
        check_range("next_row", next_row, 0, self.rows - 1)
        written = np.flatnonzero(next_row < used)
        steps = is_step[written, next_row[written]]
        check_all("next_row", ~steps, next_row[written], "a row without a step")

    def _arrays(self) -> dict[str, NDArray[Any]]:
        names = ("tasks", "reward", "discount", "terminated", "done", "is_step")
        return {
            **{f"obs_{key}": array for key, array in self.obs.items()},
            **{name: getattr(self, name) for name in names},
        }


def _by_step(values: NDArray[Any]) -> NDArray[Any]:
    """Rows of all games in one axis."""
    return values.reshape(-1, *values.shape[2:])


def _storage(box: spaces.Space[Any]) -> np.dtype[Any]:
    """Type to store a part of the observation in."""
    if not isinstance(box, spaces.Box):
        raise ConfigError(f"every part of a task env's observation is a Box, got {box}")
    small = bool(np.all(np.abs(box.low) <= HALF_BOUND) and np.all(np.abs(box.high) <= HALF_BOUND))
    return np.dtype(np.float16) if small and box.dtype == np.float32 else box.dtype
