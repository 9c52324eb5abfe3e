"""What the algorithms of the task level share: their zips, the envs that they fit, who leads the pieces there."""

from __future__ import annotations

import warnings
from abc import abstractmethod
from collections.abc import Iterator
from typing import Any, ClassVar, TypeVar, cast

import numpy as np
from gymnasium import spaces
from stable_baselines3.common.callbacks import BaseCallback, CallbackList
from stable_baselines3.common.type_aliases import GymEnv
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper, VecFrameStack, VecNormalize

from hexwar_sb3.algorithms.model_file import PlainZip
from hexwar_sb3.algorithms.model_zip import File, ModelZip
from hexwar_sb3.algorithms.ranges import NOT_NEGATIVE, Misfit, Parts, Table, Whole, flag
from hexwar_sb3.algorithms.replay import StepReplay
from hexwar_sb3.algorithms.tensors import check_forms, pack
from hexwar_sb3.errors import CheckpointError, ConfigError
from hexwar_sb3.players.frozen_lower import FORMAT as LOWER_FORMAT
from hexwar_sb3.players.frozen_lower import HEURISTIC_LOWER, SIZES, FrozenLower, Lower
from hexwar_sb3.policies.shapes import SIZE_LIMITS, TaskShapes
from hexwar_sb3.policies.task_policy import TaskPolicy

Env = TypeVar("Env")
LEADER = "leader"  # part of a zip: the network that leads the pieces of its model
LEADER_FORMS = {
    name: (np.dtype(np.float32), tuple(SIZES[axis] for axis in axes))
    for name, axes in LOWER_FORMAT.layers.items()
}


class TaskModel(PlainZip):
    """An algorithm of Stable-Baselines3 in a task env; its sizes, `task_sizes`, are what the spaces are made of."""

    policy: TaskPolicy
    replay_buffer: StepReplay  # has SB3's add(), and its own sample()
    sizes: ClassVar[Table] = {
        "task_sizes": Parts({name: Whole(1, most) for name, most in SIZE_LIMITS.items()}),
        "leading": lambda value: None if value is None else Parts({"ways": flag, "tie": NOT_NEGATIVE})(value),
    }
    _leading: dict[str, Any] | None = None  # as a zip says
    _eval_envs: tuple[Any, ...] = ()  # of the callbacks, while it learns

    @classmethod
    def made_spaces(cls, values: dict[str, Any]) -> tuple[spaces.Space[Any], spaces.Space[Any]]:
        """Make the acting spaces of the sizes in a zip.

        Raises:
            Misfit: a size is missing, or they are too large together.
        """
        if set(values["task_sizes"]) != set(SIZE_LIMITS):
            raise Misfit(values["task_sizes"], f"{', '.join(SIZE_LIMITS)}", "task_sizes")
        shapes = TaskShapes(**values["task_sizes"])
        if problem := shapes.why_too_large():
            raise Misfit(values["task_sizes"], problem, "task_sizes")
        return shapes.observation_space(), shapes.action_space()

    def check_env(self, env: GymEnv) -> None:
        """Check that no wrapper changes what is learned from: it is stored as the env gives it.

        Raises:
            ConfigError: one does.
        """
        for wrapper in wrappers(env):
            if isinstance(wrapper, VecNormalize | VecFrameStack):
                raise ConfigError(
                    f"{type(self).__name__} takes observations and rewards as the env gives them, got an env in"
                    f" {type(wrapper).__name__}: leave it out (features are scaled by themselves, rewards by reward_scale)"
                )

    @classmethod
    def _check_spaces(
        cls, observation_space: spaces.Space[Any], action_space: spaces.Space[Any], env: GymEnv
    ) -> None:
        check_alike(TaskShapes.of(observation_space, action_space), env)

    def set_env(self, env: GymEnv, force_reset: bool = True) -> None:
        """Go on in another env of the same sizes; to train, it must give the mixer the same state.

        As long as the replay is empty, it may have any number of games.

        Raises:
            ConfigError: other sizes, a wrapper that changes what is learned, or another number of games than the replay's.
        """
        wrapped = self._wrap_env(env, self.verbose)
        self.check_env(wrapped)
        check_alike(self.policy.shapes, wrapped)
        if not self.replay_buffer.used:
            self.n_envs = wrapped.num_envs
        elif wrapped.num_envs != self.n_envs:
            raise ConfigError(
                f"the replay holds steps of {self.n_envs} games at a time, got an env of {wrapped.num_envs};"
                f" {type(self).__name__}.load(path, env=env) starts with an empty one"
            )
        self.observation_space, self.action_space = wrapped.observation_space, wrapped.action_space
        super().set_env(wrapped, force_reset)
        if not self.replay_buffer.used:
            self._give_room()
            self._begin_games()
        self.follow_lower()

    @abstractmethod
    def _begin_games(self) -> None:
        """Forget the running games."""

    def load_replay_buffer(self, path: File, truncate_last_traj: bool = True) -> None:
        """Read what `save_replay_buffer` wrote; the games that were running then end there."""
        super().load_replay_buffer(path, truncate_last_traj)
        self.replay_buffer.cut_short()

    # Who leads the pieces.

    def follow_lower(self) -> None:
        """Let the pieces of a frozen copy be led as the env's are, where tasks are carried out by a lower level."""
        if self.env is not None and self.env.has_attr("lower_level"):
            self.policy.lower = self.env.get_attr("lower_level")[0]

    def lead_with(self, lower: Lower) -> None:
        """Let a lower level lead the pieces of this model's envs, and of its frozen copies."""
        self.policy.lower = lower
        self._lead_own()

    def _lead_own(self) -> None:
        for env in (self.env, *self._eval_envs):
            if env is not None and env.has_attr("lower_level"):
                env.env_method("set_lower", self.policy.lower)

    def lead(self, env: Env) -> Env:
        """Let the lower level that belongs to this model lead the pieces of an env of yours, for example to watch it play.

        Its own env and those of `EvalCallback` are led by themselves. Call it again when the model has learned on.

        Args:
            env: a VecEnv or a Gymnasium env of the task level, wrapped or not.

        Returns:
            The same env.

        Raises:
            ConfigError: nobody leads pieces there.

        Example:
            >>> model = HierarchicalQMIX("HierarchicalPolicy", make_vec_env())  # or HierarchicalQMIX.load("model.zip")
            >>> env = model.lead(make_vec_env(opponent="MA1"))
        """
        if isinstance(env, VecEnv) and env.has_attr("lower_level"):
            env.env_method("set_lower", self.policy.lower)
        elif not isinstance(env, VecEnv) and hasattr(env, "get_wrapper_attr"):
            try:
                env.get_wrapper_attr("set_lower")(self.policy.lower)
            except AttributeError as error:
                raise ConfigError(f"nobody leads pieces in {env}") from error
        else:
            raise ConfigError(f"nobody leads pieces in {env}")
        return env

    def _warn_of_the_heuristic(self) -> None:
        """Say once that the tasks of a model without an env are carried out by another lower level than its own."""
        if self.env is None and not self.policy.lower_is_known and self.policy.lower != HEURISTIC_LOWER:
            warnings.warn(
                "this model has a lower level of its own, but in an env of yours the heuristic leads the pieces:"
                " model.lead(env) or model.set_env(env) lets its own lead there",
                stacklevel=3,
            )

    def _lead_evaluations(self, callback: BaseCallback) -> None:
        """Let the envs of `EvalCallback`s be led as the model's own, as long as it learns."""
        self._eval_envs = tuple(eval_envs(callback))
        if self.policy.lower != HEURISTIC_LOWER:
            self._lead_own()

    # The zip.

    @property
    def leading(self) -> dict[str, Any] | None:
        """Settings of the network that leads, for a zip that holds it."""
        lower = self.policy.lower
        return {"ways": bool(lower.ways), "tie": float(lower.tie)} if isinstance(lower, FrozenLower) else None

    @leading.setter
    def leading(self, value: dict[str, Any] | None) -> None:
        self._leading = value

    def _packed(self) -> dict[str, bytes]:
        lower = self.policy.lower
        more = {LEADER: pack(lower.weights)} if isinstance(lower, FrozenLower) else {}
        return {**super()._packed(), **more}

    def _take(self, zipped: ModelZip) -> None:
        """Take the weights of a zip, and the network that leads; with an env, the env's own leads."""
        weights = dict(zipped.weights)
        tensors = weights.pop(LEADER, None)
        if (tensors is None) != (self._leading is None):
            found = "nothing" if tensors is None else "a network"
            raise CheckpointError(zipped.name, LEADER, found=found, expected=f"by data: {self._leading}")
        super()._take(ModelZip(zipped.name, zipped.data, weights))
        if tensors is not None:
            check_forms(tensors, LEADER_FORMS, zipped.name, LEADER)
            self._take_leader(FrozenLower(tensors, **cast("dict[str, Any]", self._leading)))

    def _take_leader(self, lower: FrozenLower) -> None:
        if self.env is None:
            self.policy.lower = lower
        elif self.policy.lower == HEURISTIC_LOWER:
            warnings.warn(
                "this model learned over a network as lower level, and the heuristic leads the pieces of its env now:"
                " make the env with the same lower=, or call model.lead_with(...)",
                stacklevel=5,
            )


def wrappers(env: GymEnv) -> Iterator[VecEnvWrapper]:
    """Wrappers of a VecEnv, from the outside."""
    while isinstance(env, VecEnvWrapper):
        yield env
        env = env.venv


def eval_envs(callback: BaseCallback | None) -> Iterator[VecEnv]:
    """Envs for evaluation of a callback, and of those within it."""
    if callback is None:
        return
    env = getattr(callback, "eval_env", None)
    if isinstance(env, VecEnv):
        yield env
    children = callback.callbacks if isinstance(callback, CallbackList) else []
    inner = (getattr(callback, name, None) for name in ("callback", "callback_on_new_best"))
    for child in (*children, *inner):
        if isinstance(child, BaseCallback):
            yield from eval_envs(child)


def check_alike(shapes: TaskShapes, env: GymEnv) -> None:
    """Check that a model of these sizes can act in an env.

    Raises:
        ConfigError: it cannot.
    """
    found = TaskShapes.of(env.observation_space, env.action_space)
    if not shapes.acting_alike(found):
        raise ConfigError(f"the model was made for {shapes}, the env has {found}")
