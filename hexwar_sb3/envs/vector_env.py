"""The batched engine as Gymnasium's vector envs: `gymnasium.make_vec(id, num_envs, "vector_entry_point")`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, TypeAlias, cast

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from hexwar_sb3.checks import check_choice, check_whole
from hexwar_sb3.envs.native_vec_env import NativeVecEnv
from hexwar_sb3.envs.registration import ENVS, FLAT_ENV, ROUTE_ENV, TASK_ENV
from hexwar_sb3.envs.screen import ARRAY, FPS
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.play.seeds import MOST_SEED, check_seed, chosen_seed

Obs: TypeAlias = dict[str, NDArray[Any]] | NDArray[Any]
Step: TypeAlias = tuple[Obs, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]


class BatchedVectorEnv(VectorEnv[Obs, NDArray[np.int64], NDArray[Any]]):
    """All games are stepped in one call: what `SyncVectorEnv` of as many single envs gives in its mode "SameStep", faster.

    An ended game starts anew in the same step: its last observation is `infos["final_obs"][b]`, its last info is in
    `infos["final_info"]`, and what is returned for it is the first observation of the next episode. Slot b plays the
    episodes of `seed + b`, as the single env does that is reset with it. Two things are counted together where single envs
    count alone: whom the learner loses to (`priority`), and which recorded games were shown (`demo`).

    Args:
        num_envs: games.
        render_mode: "rgb_array": `render` draws what the learner's camp knows in each game; None: it does not.
        autoreset_mode: "SameStep" or Gymnasium's `AutoresetMode.SAME_STEP`; there is no other.
        settings: of the env.

    Raises:
        UnknownNameError: no such choice.
        UnknownSettingError: no such setting.
        ConfigError: a setting is out of its range, or another way to start anew.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012  (Gymnasium declares it so)
        "render_modes": [ARRAY],
        "render_fps": FPS,
        "autoreset_mode": AutoresetMode.SAME_STEP,
    }
    autoreset_mode = AutoresetMode.SAME_STEP  # as `SyncVectorEnv` has it
    env_id: ClassVar[str]

    def __init__(
        self,
        num_envs: int = 1,
        render_mode: str | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.SAME_STEP,
        **settings: Any,
    ) -> None:
        if render_mode is not None:
            check_choice("render_mode", render_mode, self.metadata["render_modes"])
        if autoreset_mode not in (self.autoreset_mode, self.autoreset_mode.value):
            raise ConfigError(
                f"autoreset_mode of the batched engine is 'SameStep', got {autoreset_mode!r}: take"
                " vectorization_mode='sync' for others"
            )
        self.num_envs, self.render_mode = check_whole("num_envs", num_envs, least=1), render_mode
        self.venv = cast("NativeVecEnv", ENVS[self.env_id].make(self.num_envs, settings, None))
        self.single_observation_space = self.venv.observation_space
        self.single_action_space = self.venv.action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.venv.seed_slots(self._slot_seeds(chosen_seed(None)))

    def reset(
        self, *, seed: int | Sequence[int] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Obs, dict[str, Any]]:
        """Start the next episode in every slot; with a seed, the first one of `seed + b`, or of seed[b].

        Raises:
            ConfigError: a seed is out of its range, there are too many or too few, or slots are named
                (`options["reset_mask"]`): they start anew by themselves.
        """
        if options and "reset_mask" in options:
            raise ConfigError("no reset_mask is taken: a game that has ended starts anew in the same step")
        if seed is not None:
            self.venv.seed_slots(seeds := self._slot_seeds(seed))
            super().reset(seed=seeds[0])
        return _copied(cast("Obs", self.venv.reset())), {}

    def step(self, actions: NDArray[np.int64]) -> Step:
        """Play one step of every game.

        Args:
            actions: an action a game [n, ...].
        """
        obs, rewards, dones, rows = self.venv.step(actions)
        cut = np.array([bool(row.pop("TimeLimit.truncated", False)) for row in rows])
        infos: dict[str, Any] = {}
        for b, row in enumerate(rows):
            last = row.pop("terminal_observation", None)
            infos = self._add_info(infos, row if last is None else {"final_obs": last, "final_info": row}, b)
        return _copied(cast("Obs", obs)), rewards.astype(np.float64), dones & ~cut, dones & cut, infos

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Draw what the learner's camp knows of every game, [height, width, RGB]; None without a render mode."""
        return None if self.render_mode is None else tuple(self.venv.frames())

    def action_masks(self) -> NDArray[np.bool_]:
        """Valid actions of every game: pieces one after the other [n, N * K], or [n, K]."""
        return self.venv.action_masks()

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """What `SyncVectorEnv.call` gives: a method's answer, or an attribute, once a game."""
        if not callable(getattr(self.venv, name)):
            return self.get_attr(name)
        return tuple(self.venv.env_method(name, *args, **kwargs))

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """An attribute of the games, once for each."""
        return tuple(self.venv.get_attr(name))

    def _slot_seeds(self, seed: int | Sequence[int]) -> list[int]:
        if isinstance(seed, Sequence | np.ndarray):
            if len(seed) != self.num_envs:
                raise ConfigError(f"expected a seed for each of {self.num_envs} games, got {len(seed)}")
            return [check_seed(one) for one in seed]
        first = check_whole("seed", seed, least=0, most=MOST_SEED - self.num_envs + 1)
        return list(range(first, first + self.num_envs))


class TaskVectorEnv(BatchedVectorEnv):
    """`HexWarTask-v0` as a vector env; settings are those of `TaskSettings`.

    Example:
        >>> import gymnasium
        >>> envs = gymnasium.make_vec("HexWarTask-v0", num_envs=8, vectorization_mode="vector_entry_point")
        >>> obs, infos = envs.reset(seed=0)
        >>> obs["action_mask"].shape  # games, pieces, tasks
        (8, 7, 40)
    """

    env_id = TASK_ENV


class RouteVectorEnv(BatchedVectorEnv):
    """`HexWarRoute-v0` as a vector env; settings are those of `RouteSettings`."""

    env_id = ROUTE_ENV


class FlatVectorEnv(BatchedVectorEnv):
    """`HexWarFlat-v0` as a vector env; settings are those of `FlatEnv`."""

    env_id = FLAT_ENV


def _copied(obs: Obs) -> Obs:
    """An observation of its own: the engine's buffers are reused."""
    return {key: value.copy() for key, value in obs.items()} if isinstance(obs, dict) else obs.copy()
