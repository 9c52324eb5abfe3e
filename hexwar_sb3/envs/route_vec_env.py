"""`HexWarRoute-v0` for many games at once: a native VecEnv of Stable-Baselines3."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, wait
from typing import Any, TypeAlias, TypeVar

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.vec_env.base_vec_env import VecEnvStepReturn

from hexwar_sb3.checks import check_whole
from hexwar_sb3.engine.fields import refuse
from hexwar_sb3.envs.native_vec_env import NativeVecEnv
from hexwar_sb3.envs.route_games import Hop, RouteGames, check_leader
from hexwar_sb3.envs.route_settings import RouteSettings
from hexwar_sb3.envs.snapshots import placed
from hexwar_sb3.play.arena import Arena, Snapshot
from hexwar_sb3.play.seeds import chosen_seed
from hexwar_sb3.players.fit import check_actions
from hexwar_sb3.players.frozen_lower import make_lower
from hexwar_sb3.tasks.features import BOUND, ROUTE_WIDTH
from hexwar_sb3.tasks.route import N_ANSWERS

Obs: TypeAlias = dict[str, NDArray[Any]]
T = TypeVar("T")


def route_spaces() -> tuple[spaces.Dict, spaces.Discrete]:
    """Spaces of the route env: the same for every piece, map and scenario."""
    parts = {
        "obs": spaces.Box(-BOUND, BOUND, (ROUTE_WIDTH,), np.float32),
        "action_mask": spaces.Box(0, 1, (N_ANSWERS,), np.int8),
    }
    return spaces.Dict(list(parts.items())), spaces.Discrete(N_ANSWERS)  # type: ignore[arg-type]


class RouteVecEnv(NativeVecEnv):
    """One focal piece a game; several scenarios share the games evenly. Copy an observation that must stay.

    Args:
        n_envs: games.
        settings: the env's settings.
        seed: of the games; None draws one.
    """

    beside: Executor | None = None  # plays the games of half of the scenarios, with the same bits

    def __init__(self, n_envs: int, settings: RouteSettings, seed: int | None = None) -> None:
        check_whole("n_envs", n_envs, least=len(settings.fields))
        self.settings, self.first_seed = settings, chosen_seed(seed)
        shares = np.diff(np.linspace(0, n_envs, len(settings.fields) + 1).astype(int))
        self.fields = [
            RouteGames(int(n), settings, scenario, self.first_seed)
            for n, scenario in zip(shares, settings.fields, strict=True)
        ]
        ends = np.cumsum(shares)
        self._slices = [slice(int(end - n), int(end)) for n, end in zip(shares, ends, strict=True)]
        super().__init__(n_envs, *route_spaces())

    def reset(self) -> Obs:
        """Start new games in every slot."""
        return self._obs(self._each(_begin, self.fields))

    def step_wait(self) -> VecEnvStepReturn:
        """Give every focal piece its answer, and play until it asks again or its route is over."""
        answers = check_actions(self._actions, (self.num_envs,), axes="")
        played = self._each(_step, self.fields, [answers[part] for part in self._slices])
        hops = [hop for hop, _, _ in played]
        infos = [_info(hop, b, int(ticks[b])) for hop, ticks, _ in played for b in range(len(ticks))]
        rewards, dones = (
            np.concatenate([hop.reward for hop in hops]),
            np.concatenate([hop.over for hop in hops]),
        )
        return self._obs([seen for _, _, seen in played]), rewards, dones, infos

    def _each(self, function: Callable[..., T], *columns: Sequence[Any]) -> list[T]:
        """Call a function once a scenario: `map`, by two threads where there is a second core."""
        if self.beside is None:
            return list(map(function, *columns))
        half = len(self.fields) // 2
        others = self.beside.submit(list, map(function, *(column[half:] for column in columns)))
        try:
            own = list(map(function, *(column[:half] for column in columns)))
        finally:
            wait([others])
        return own + others.result()

    def _obs(self, seen: Iterable[tuple[NDArray[Any], NDArray[Any]]]) -> Obs:
        states, masks = zip(*seen, strict=True)
        return {"obs": np.concatenate(states), "action_mask": np.concatenate(masks)}

    def action_masks(self) -> NDArray[np.bool_]:
        """Valid answers of every game [n, 7] (sb3-contrib)."""
        return np.concatenate([games.mask for games in self.fields]).astype(np.bool_)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Count games from 0 again under this seed, or a drawn one; takes effect at the next reset."""
        self.first_seed = chosen_seed(seed)
        for games in self.fields:
            games.seed(self.first_seed)
        return [self.first_seed] * self.num_envs

    def seed_slots(self, seeds: Sequence[int]) -> None:
        """Give every slot the episodes of a seed of its own, from 0 on; takes effect at the next reset."""
        for games, part in zip(self.fields, self._slices, strict=True):
            games.seed_slots(seeds[part])

    def positions(self) -> Iterator[tuple[Arena, int, int]]:
        """Where each game is to be found, and whose eyes see it: arena, number in it, camp of the learner."""
        for games in self.fields:
            yield from games.tasks.positions()

    def set_upper(self, upper: object) -> None:
        """Let another policy give the tasks, from the next decision on."""
        for games in self.fields:
            games.set_upper(upper)

    def set_lower(self, lower: object) -> None:
        """Let another lower level lead the pieces that are not in focus."""
        made = check_leader(make_lower(lower))
        for games in self.fields:
            games.tasks.set_lower(made)

    def snapshot(self) -> Snapshot:
        """Everything that changes in play, as arrays that `np.savez` takes."""
        return {
            f"{k}/{name}": part
            for k, games in enumerate(self.fields)
            for name, part in games.snapshot().items()
        }

    def restore(self, snapshot: Snapshot) -> Obs:
        """Go on where `snapshot` was taken, in an env of the same settings; the observation there.

        Raises:
            ConfigError: it was taken on another scenario, under other rules, with other bots or more opponents.
            CheckpointError: it is broken; the env is as it was.
        """
        parts: list[Snapshot] = [{} for _ in self.fields]
        for name, array in snapshot.items():
            number, _, rest = name.partition("/")
            if number not in map(str, range(len(parts))):
                refuse(name, "an unknown name", f"games of {len(parts)} scenarios")
            parts[int(number)][rest] = array
        for k, (games, part) in enumerate(zip(self.fields, parts, strict=True)):
            with placed(str(k)):
                games.check(part)
        for games, part in zip(self.fields, parts, strict=True):
            games.restore(part)
        return self._obs(map(_look, self.fields))


def _look(games: RouteGames) -> tuple[NDArray[Any], NDArray[Any]]:
    games.look()
    return games.state, games.mask


def _begin(games: RouteGames) -> tuple[NDArray[Any], NDArray[Any]]:
    games.begin(games.all)
    return _look(games)


def _step(
    games: RouteGames, answers: NDArray[Any]
) -> tuple[Hop, NDArray[np.int64], tuple[NDArray[Any], NDArray[Any]]]:
    """The hop of every focal piece, ticks until the next route, and what is asked there."""
    hop = games.play(answers)
    waited = games.next_route(games.all[hop.over])
    return hop, waited, _look(games)


def _info(hop: Hop, b: int, waited: int) -> dict[str, Any]:
    """Say what a step was; its ticks are those of the way, and those until the next route began."""
    info: dict[str, Any] = {"ticks": int(hop.ticks[b]) + waited, "steps": float(hop.steps[b])}
    info["lower_reward"] = float(hop.lower_reward[b])
    if hop.over[b]:
        info["finished"] = bool(hop.finished[b])
        info["terminal_observation"] = {
            "obs": hop.last_state[b].copy(),
            "action_mask": hop.last_mask[b].copy(),
        }
        info["TimeLimit.truncated"] = bool(hop.cut[b])
    return info
