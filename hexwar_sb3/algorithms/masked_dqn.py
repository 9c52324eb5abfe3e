"""DQN and QR-DQN of Stable-Baselines3 with action masks, for the lower level (III-B) and any env like it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Self, cast

import numpy as np
import torch
from gymnasium import spaces
from numpy.typing import NDArray
from sb3_contrib import QRDQN
from stable_baselines3 import DQN
from stable_baselines3.common.base_class import maybe_make_env
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.noise import ActionNoise
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.type_aliases import GymEnv, MaybeCallback, Schedule
from stable_baselines3.common.utils import update_learning_rate
from stable_baselines3.common.vec_env import VecEnv, unwrap_vec_normalize

from hexwar_sb3.algorithms.exploration import checked_masks, epsilon_at, random_tasks
from hexwar_sb3.algorithms.model_file import PlainZip
from hexwar_sb3.algorithms.plain_spaces import boxes, plain_boxes, space_of_boxes
from hexwar_sb3.algorithms.ranges import (
    COUNTER,
    COUNTERS,
    LEARNING,
    MOST_BATCH,
    MOST_LAYERS,
    MOST_STEPS,
    MOST_WIDTH,
    OPTIMIZER,
    WIDTH,
    Choice,
    Misfit,
    Parts,
    Table,
    Whole,
    flag,
    options,
    row,
    row_of,
    scalar,
    setting,
)
from hexwar_sb3.algorithms.timed_replay import TimedReplayBuffer
from hexwar_sb3.errors import ConfigError, TrainingError
from hexwar_sb3.play.seeds import rng_array, rng_state
from hexwar_sb3.policies.activations import ACTIVATIONS, named_activation
from hexwar_sb3.policies.masked import MASK, MaskedDQNPolicy, MaskedQRDQNPolicy, check_masked_spaces

Observation = Mapping[str, NDArray[Any]]
MOST_ACTIONS = 65_536


def vec_steps(value: Any) -> int:
    """When to train: after so many steps of the VecEnv; also (n, "step"), as in SB3."""
    found = row(value)
    if isinstance(found, list | tuple) and len(found) == 2 and getattr(found[1], "value", found[1]) == "step":
        found = found[0]
    try:
        return Whole(1, MOST_STEPS)(found)
    except Misfit:
        raise Misfit(value, "a number of VecEnv steps") from None


def updates_each(value: Any) -> int:
    """Updates of a round; -1: as many as env steps."""
    return -1 if scalar(value) == -1 else Whole(1, MOST_BATCH)(value)


def activation(value: Any) -> Any:
    """A function between layers: its name where torch's has one, which a file can hold, or a class."""
    found = named_activation(scalar(value))
    if isinstance(found, str):
        return Choice("activation_fn", ACTIVATIONS)(found)
    if not isinstance(found, type) or not issubclass(found, torch.nn.Module):
        raise Misfit(value, f"a class of torch.nn, or one of {', '.join(ACTIVATIONS)}")
    return found


POLICY_KWARGS: Table = {
    "net_arch": row_of(WIDTH, MOST_LAYERS),
    "activation_fn": activation,
    "normalize_images": flag,
    "optimizer_kwargs": OPTIMIZER,
    "features_extractor_kwargs": Parts({"cnn_output_dim": WIDTH, "normalized_image": flag}),
}
CLASSES = ("features_extractor_class", "optimizer_class")  # of the policy; no file holds them
SETTINGS: Table = {
    **LEARNING,
    "policy_kwargs": Parts(POLICY_KWARGS, CLASSES),
    "train_freq": vec_steps,
    "gradient_steps": updates_each,
    "learning_rate_steps": Whole(),
    "exploration_steps": Whole(),
}
"""Settings of MaskedDQN by their arguments' names."""


class MaskedExploration(OffPolicyAlgorithm):
    """Explores among the valid actions, each env for itself; epsilon is a function of a saved counter.

    SB3's epsilon follows the progress of one call of `learn`, its random actions ignore masks, and one coin
    decides for all envs.
    """

    rng: np.random.Generator
    exploration_initial_eps: float
    exploration_final_eps: float
    exploration_steps: int

    @property
    def exploration_rate(self) -> float:
        """Epsilon now: a function of the number of env steps."""
        ends = self.exploration_initial_eps, self.exploration_final_eps
        return epsilon_at(self.num_timesteps, *ends, self.exploration_steps)

    @exploration_rate.setter
    def exploration_rate(self, value: float) -> None:
        """Ignore the value of SB3's own schedule."""

    def _sample_action(
        self, learning_starts: int, action_noise: ActionNoise | None = None, n_envs: int = 1
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        observation = cast("dict[str, NDArray[Any]]", self._last_obs)
        if self.num_timesteps < learning_starts:
            actions = self.random_actions(observation)
        else:
            actions, _ = self.predict(observation)
        return actions, actions

    def predict(
        self,
        observation: np.ndarray | dict[str, np.ndarray],
        state: tuple[np.ndarray, ...] | None = None,
        episode_start: np.ndarray | None = None,
        deterministic: bool = False,
    ) -> tuple[np.ndarray, tuple[np.ndarray, ...] | None]:
        """Actions for one observation or a batch; not deterministic: each env explores with probability epsilon."""
        actions, state = self.policy.predict(observation, state, episode_start, deterministic=True)
        if not deterministic:
            explores = self.rng.random(actions.shape) < self.exploration_rate
            actions = np.where(explores, self.random_actions(cast("Observation", observation)), actions)
        else:
            checked_masks(cast("Observation", observation)[MASK])
        return actions, state

    def random_actions(self, observation: Observation) -> NDArray[np.int64]:
        """Draw a valid action for one observation or each of a batch, uniformly; any, where none is valid."""
        mask = checked_masks(observation[MASK])
        return random_tasks(mask | ~mask.any(axis=-1, keepdims=True), self.rng)


class MaskedLearner(MaskedExploration, PlainZip):
    """What the masked forms of DQN and QR-DQN share; names of arguments are SB3's where it has them.

    Observations are a Dict of Boxes with an "action_mask" of 0 and 1 [A] for Discrete(A) actions. A
    transition may last: info["steps"] is its length (1 if missing), gamma^steps its discount. An episode
    that was truncated is not done: its last observation is valued.

    Args:
        policy: "MaskedPolicy".
        env: an env, or a VecEnv of them; None only for `for_spaces`.
        learning_rate: of Adam; a function of SB3's progress starts anew with each call of `learn`.
        buffer_size: transitions of all envs together.
        learning_starts: env steps before the first update; until then every action is random.
        batch_size: transitions of an update.
        tau: share of the online network that goes into the target; 1 is a hard update.
        gamma: discount of one unit of time.
        train_freq: steps of the VecEnv between two rounds of updates; or (n, "step").
        gradient_steps: updates of a round; -1 makes as many as env steps were taken.
        target_update_interval: env steps between two changes of the target.
        final_learning_rate: where the learning rate ends, in a straight line; None keeps it.
        learning_rate_steps: env steps until then; a saved count.
        n_steps: steps of a transition, fewer at an episode's end.
        exploration_initial_eps: probability of a random action at the start.
        exploration_final_eps: and after `exploration_steps`.
        exploration_steps: env steps until then; a saved count, so a resumed run goes on where it was.
        max_grad_norm: gradients are clipped to it.
        policy_kwargs: further arguments of the policy, as net_arch, activation_fn and, for QR-DQN, n_quantiles.
        stats_window_size: as in SB3.
        tensorboard_log: as in SB3.
        verbose: as in SB3.
        seed: of network, exploration, replay and env.
        device: "auto" takes a GPU where there is one.
        _init_setup_model: build the network now.
    """

    replay_buffer: TimedReplayBuffer
    settings: ClassVar[Table] = SETTINGS
    state: ClassVar[Table] = {**COUNTERS, "_n_calls": COUNTER, "is_normalised": flag}
    sizes: ClassVar[Table] = {"boxes": boxes, "n_actions": Whole(1, MOST_ACTIONS)}
    attributes: ClassVar[Mapping[str, str]] = {
        **PlainZip.attributes,
        "train_freq": "update_every",
        "n_steps": "n_return_steps",  # SB3's own n_steps would choose its own replay
    }
    is_normalised = False  # it learned from what a VecNormalize made of the observations

    def __init__(
        self,
        policy: str | type[BasePolicy],
        env: GymEnv | str | None,
        learning_rate: float | Schedule = 5e-4,
        buffer_size: int = 100_000,
        learning_starts: int = 1_000,
        batch_size: int = 128,
        tau: float = 1.0,
        gamma: float = 0.99,
        train_freq: int | tuple[int, str] = 4,
        gradient_steps: int = 1,
        target_update_interval: int = 1_000,
        *,
        final_learning_rate: float | None = None,
        learning_rate_steps: int = 100_000,
        n_steps: int = 1,
        exploration_initial_eps: float = 1.0,
        exploration_final_eps: float = 0.05,
        exploration_steps: int = 50_000,
        max_grad_norm: float = 10.0,
        policy_kwargs: dict[str, Any] | None = None,
        stats_window_size: int = 100,
        tensorboard_log: str | None = None,
        verbose: int = 0,
        seed: int | None = None,
        device: torch.device | str = "auto",
        _init_setup_model: bool = True,
    ) -> None:
        if env is not None:
            env = maybe_make_env(env, verbose)
            check_masked_spaces(env.observation_space, env.action_space)
        batch_size = setting("batch_size", batch_size, SETTINGS["batch_size"])  # QRDQN divides by it
        super().__init__(  # type: ignore[call-arg]  # of DQN or QRDQN, next in line
            policy,
            env,  # type: ignore[arg-type]  # None while a model is loaded
            learning_rate,
            buffer_size,
            learning_starts,
            batch_size,
            tau,
            gamma,
            gradient_steps=gradient_steps,
            target_update_interval=target_update_interval,
            exploration_initial_eps=exploration_initial_eps,
            exploration_final_eps=exploration_final_eps,
            max_grad_norm=max_grad_norm,
            policy_kwargs=setting("policy_kwargs", policy_kwargs or {}, options),
            stats_window_size=stats_window_size,
            tensorboard_log=tensorboard_log,
            verbose=verbose,
            seed=seed,
            device=device,
            _init_setup_model=False,
        )
        self.update_every: Any = train_freq
        self.exploration_steps = exploration_steps
        self.final_learning_rate, self.learning_rate_steps = final_learning_rate, learning_rate_steps
        self.n_return_steps = n_steps
        if self.policy_kwargs.get("optimizer_class") is torch.optim.Adam:  # QRDQN names the default
            del self.policy_kwargs["optimizer_class"]  # a class in a zip would have to be unpickled
        if _init_setup_model:
            self._setup_model()

    @classmethod
    def for_spaces(
        cls,
        observation_space: spaces.Space[Any],
        action_space: spaces.Space[Any],
        policy: str | type[BasePolicy] = "MaskedPolicy",
        **arguments: Any,
    ) -> Self:
        """Make a model before there is an env; `set_env` gives it one of any number of envs.

        Raises:
            ConfigError: there is no mask in the observation, or a setting is out of its range.
        """
        check_masked_spaces(observation_space, action_space)
        model = cls(policy, None, **arguments, _init_setup_model=False)
        model.observation_space, model.action_space, model.n_envs = observation_space, action_space, 1
        model._setup_model()
        return model

    def _setup_model(self) -> None:
        """Build network and replay."""
        self._mend_settings()
        if self.env is not None:
            self.check_env(self.env)
        self.boxes = plain_boxes(cast("spaces.Dict", self.observation_space))
        self.n_actions = int(cast("spaces.Discrete", self.action_space).n)
        self.rng = np.random.default_rng(self.seed)
        self.train_freq = self.update_every
        self._give_room()
        super()._setup_model()
        self._note_normalisation()

    def _note_normalisation(self) -> None:
        """Note for good whether observations are normalised: a network frozen for play would see others."""
        normaliser = self._vec_normalize_env
        self.is_normalised |= normaliser is not None and bool(normaliser.norm_obs)
        self.policy.is_normalised = self.is_normalised  # type: ignore[assignment]

    def check_env(self, env: GymEnv) -> None:
        """Check that a VecNormalize leaves the masks alone.

        Raises:
            ConfigError: it does not.
        """
        normaliser = unwrap_vec_normalize(env) if isinstance(env, VecEnv) else None
        if normaliser is not None and normaliser.norm_obs and MASK in (normaliser.norm_obs_keys or ()):
            raise ConfigError(f"VecNormalize must leave the masks alone: name norm_obs_keys without {MASK!r}")

    def _update_learning_rate(self, optimizers: list[torch.optim.Optimizer] | torch.optim.Optimizer) -> None:
        """Set the learning rate, by the saved count of env steps where it falls: `learn` may be called many times."""
        super()._update_learning_rate(optimizers)
        if self.final_learning_rate is not None:
            ends = float(self.learning_rate), self.final_learning_rate  # type: ignore[arg-type]
            rate = epsilon_at(self.num_timesteps, *ends, self.learning_rate_steps)
            self.logger.record("train/learning_rate", rate)
            for optimizer in optimizers if isinstance(optimizers, list) else [optimizers]:
                update_learning_rate(optimizer, rate)

    def train(self, gradient_steps: int, batch_size: int = 100) -> None:
        """Make updates as SB3 does, and stop if the network is no longer one.

        Raises:
            TrainingError: a weight is not finite; a checkpoint that was taken before holds finite ones.
        """
        super().train(gradient_steps, batch_size)
        if not all(bool(torch.isfinite(weight).all()) for weight in self.policy.parameters()):
            raise TrainingError(
                f"update {self._n_updates}: the network's weights are not finite. Lower the learning rate, or"
                " look for rewards or observations that are not finite; the last checkpoint is as it was"
            )

    def _make_replay(self, buffer_size: int) -> TimedReplayBuffer:
        return TimedReplayBuffer(
            buffer_size,
            cast("spaces.Dict", self.observation_space),
            self.action_space,
            self.device,
            self.n_envs,
            self.gamma,
            self.n_return_steps,
        )

    @classmethod
    def made_spaces(cls, values: dict[str, Any]) -> tuple[spaces.Space[Any], spaces.Space[Any]]:
        """Make the model's spaces."""
        made = space_of_boxes(values["boxes"]), spaces.Discrete(values["n_actions"])
        try:
            check_masked_spaces(*made)
        except ConfigError as error:
            raise Misfit(str(error), "an action mask", "boxes") from error
        return made

    @classmethod
    def _check_spaces(
        cls, observation_space: spaces.Space[Any], action_space: spaces.Space[Any], env: GymEnv
    ) -> None:
        _check_same(observation_space, action_space, env)

    def set_env(self, env: GymEnv, force_reset: bool = True) -> None:
        """Go on in another env of the same spaces; as long as the replay is empty, of any number of envs.

        The first env of a model that was made without one is seeded, as the constructor does.

        Raises:
            ConfigError: other spaces, or another number of envs than the replay holds transitions of.
        """
        wrapped = self._wrap_env(env, self.verbose)
        _check_same(self.observation_space, self.action_space, wrapped)
        self.check_env(wrapped)
        is_empty, is_first = not self.replay_buffer.size(), self.env is None
        if is_empty:
            self.n_envs = wrapped.num_envs
        elif wrapped.num_envs != self.n_envs:
            raise ConfigError(
                f"the replay holds transitions of {self.n_envs} envs, got {wrapped.num_envs} envs;"
                " replay_buffer.reset() empties it"
            )
        if is_first and self.seed is not None:
            wrapped.seed(self.seed)
        super().set_env(wrapped, force_reset)
        self._note_normalisation()
        if is_empty:
            self._give_room()

    def _setup_learn(
        self,
        total_timesteps: int,
        callback: MaybeCallback = None,
        reset_num_timesteps: bool = True,
        *args: Any,
        **more: Any,
    ) -> tuple[int, BaseCallback]:
        if self.env is None:
            raise ConfigError(
                f"this model has no env to learn in: {type(self).__name__}.load(path, env=env), or model.set_env(env)"
            )
        if reset_num_timesteps or self._last_obs is None:
            self.replay_buffer.cut_short()  # SB3 resets the env
        return super()._setup_learn(total_timesteps, callback, reset_num_timesteps, *args, **more)

    def snapshot(self) -> dict[str, NDArray[Any]]:
        """What a model zip leaves out and learning needs: the replay and the state of our generator.

        Beside them a checkpoint holds the zip, torch's and numpy's global random states, the running
        episodes and `_last_obs`.
        """
        return {"random": rng_array(self.rng), **self.replay_buffer.snapshot()}

    def restore(self, parts: Mapping[str, NDArray[Any]]) -> None:
        """Take over what `snapshot` gave.

        Raises:
            ConfigError: the replay is of another number of envs, or larger than this model's.
            CheckpointError: it is broken; the model is as it was.
        """
        state = rng_state(parts.get("random"), "random")
        if self.env is None:
            self._give_room(full=True)
        self.replay_buffer.restore({name: array for name, array in parts.items() if name != "random"})
        self.rng.bit_generator.state = state


def _check_same(observation_space: spaces.Space[Any], action_space: spaces.Space[Any], env: GymEnv) -> None:
    if observation_space != env.observation_space or action_space != env.action_space:
        expected, found = (observation_space, action_space), (env.observation_space, env.action_space)
        raise ConfigError(f"the model was made for {expected}, the env has {found}")


class MaskedDQN(MaskedLearner, DQN):
    """SB3's DQN with action masks and a discount of each transition (the lower level, III-B)."""

    zip_name: ClassVar[str] = "MaskedDQN"
    policy_aliases: ClassVar[dict[str, type[BasePolicy]]] = {
        "MaskedPolicy": MaskedDQNPolicy,
        "MultiInputPolicy": MaskedDQNPolicy,
    }


class MaskedQRDQN(MaskedLearner, QRDQN):
    """SB3's QR-DQN with action masks: learns the distribution of the return; arguments as `MaskedDQN`'s."""

    zip_name: ClassVar[str] = "MaskedQRDQN"
    settings: ClassVar[Table] = {
        **SETTINGS,
        "policy_kwargs": Parts({**POLICY_KWARGS, "n_quantiles": Whole(1, MOST_WIDTH)}, CLASSES),
    }
    policy_aliases: ClassVar[dict[str, type[BasePolicy]]] = {
        "MaskedPolicy": MaskedQRDQNPolicy,
        "MultiInputPolicy": MaskedQRDQNPolicy,
    }
