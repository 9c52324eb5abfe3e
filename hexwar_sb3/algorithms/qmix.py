"""QMIX over task sets as a Stable-Baselines3 algorithm (III-C); VDN and independent Q by the same class."""

from __future__ import annotations

import io
import pathlib
from collections.abc import Iterable
from typing import Any, ClassVar, TypeVar

import numpy as np
import torch
import torch.nn.functional as F
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.buffers import ReplayBuffer
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.noise import ActionNoise
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.type_aliases import GymEnv, MaybeCallback, Schedule
from stable_baselines3.common.utils import polyak_update
from torch import Tensor

from hexwar_sb3.algorithms.exploration import NO_TASK, Explorer, epsilon_at, random_tasks
from hexwar_sb3.algorithms.game_log import GameLog
from hexwar_sb3.algorithms.model_file import at_once, plain_objects
from hexwar_sb3.algorithms.replay import Batch, Situation, StepReplay
from hexwar_sb3.algorithms.td_targets import lambda_returns, qmix_target
from hexwar_sb3.errors import ConfigError, TrainingError
from hexwar_sb3.policies.shapes import TaskShapes
from hexwar_sb3.policies.task_policy import TaskPolicy
from hexwar_sb3.policies.task_sets import pack_observation

LOSSES = {"huber": F.smooth_l1_loss, "squared": F.mse_loss}
SelfQMIX = TypeVar("SelfQMIX", bound="QMIX")


class QMIX(OffPolicyAlgorithm):
    """Q-learning for a camp of pieces with task sets: agents' values are mixed into one that is trained.

    Takes any env with the task env's spaces: a Dict of obs, tasks, action_mask and alive, and state for the
    mixer if it is there. `JointActionEnv` makes one of any cooperative PettingZoo parallel env.
    Names of arguments are those of Stable-Baselines3's DQN where it has them.

    Args:
        policy: "TaskPolicy".
        env: a task env, or a VecEnv of them.
        learning_rate: of Adam.
        buffer_size: steps of all games together.
        learning_starts: steps before the first update; until then every piece explores.
        batch_size: transitions of an update.
        tau: share of the online networks that goes into the targets; 1 is a hard update.
        gamma: discount of 75 ticks; a step takes info["ticks"], or 75.
        train_freq: (1, "episode") trains after every finished game of any env; or (n, "step") of the VecEnv.
        gradient_steps: updates each time.
        target_update_interval: updates between two changes of the targets.
        mixer: "qmix", "vdn" or "iql".
        n_steps: steps of a transition; with `td_lambda` the length of its windows.
        td_lambda: λ of λ-returns; None takes n-step returns.
        double_q: the online network picks the next tasks, the target network values them.
        loss: "huber" or "squared", of the mixed value.
        reward_scale: rewards are divided by it; values are logged in points all the same.
        exploration_initial_eps: probability of a random task at the start.
        exploration_final_eps: and after `exploration_episodes`.
        exploration_episodes: finished games until then; a saved count, so a resumed run goes on where it was.
        exploration_every: episodes between two steps down.
        stickiness: probability that an exploring piece keeps its random task at a decision.
        max_grad_norm: gradients are clipped to it.
        chunk_size: transitions computed at a time; gradients add up.
        policy_kwargs: further arguments of the policy.
        stats_window_size: as in SB3.
        tensorboard_log: as in SB3.
        verbose: as in SB3.
        seed: of networks, exploration, replay and env.
        device: "auto" takes a GPU where there is one.
        _init_setup_model: build the networks now.
    """

    policy_aliases: ClassVar[dict[str, type[BasePolicy]]] = {"TaskPolicy": TaskPolicy, "MultiInputPolicy": TaskPolicy}
    policy: TaskPolicy
    replay_buffer: StepReplay  # type: ignore[assignment]  # ours has SB3's add(), and its own sample()

    def __init__(
        self,
        policy: str | type[BasePolicy],
        env: GymEnv | str | None,
        learning_rate: float | Schedule = 5e-4,
        buffer_size: int = 30_000,
        learning_starts: int = 1_000,
        batch_size: int = 128,
        tau: float = 0.01,
        gamma: float = 0.99,
        train_freq: tuple[int, str] = (1, "episode"),
        gradient_steps: int = 1,
        target_update_interval: int = 1,
        *,
        mixer: str = "qmix",
        n_steps: int = 4,
        td_lambda: float | None = None,
        double_q: bool = True,
        loss: str = "huber",
        reward_scale: float = 50.0,
        exploration_initial_eps: float = 0.5,
        exploration_final_eps: float = 0.05,
        exploration_episodes: int = 4_000,
        exploration_every: int = 1,
        stickiness: float = 0.8,
        max_grad_norm: float = 10.0,
        chunk_size: int = 256,
        policy_kwargs: dict[str, Any] | None = None,
        stats_window_size: int = 100,
        tensorboard_log: str | None = None,
        verbose: int = 0,
        seed: int | None = None,
        device: torch.device | str = "auto",
        _init_setup_model: bool = True,
    ) -> None:
        super().__init__(
            policy,
            env,  # type: ignore[arg-type]  # None while a model is loaded
            learning_rate,
            buffer_size,
            learning_starts,
            batch_size,
            tau,
            gamma,
            gradient_steps=gradient_steps,
            policy_kwargs={"mixer": mixer, **(policy_kwargs or {})},
            stats_window_size=stats_window_size,
            tensorboard_log=tensorboard_log,
            verbose=verbose,
            seed=seed,
            device=device,
            support_multi_env=True,
            sde_support=False,
        )
        if loss not in LOSSES or train_freq[1] not in ("episode", "step") or reward_scale <= 0 or n_steps < 1:
            raise ConfigError(f"loss {loss!r}, train_freq {train_freq}, reward_scale {reward_scale}, n_steps {n_steps}")
        self.update_every = train_freq  # SB3 counts episodes with a single env only
        self.target_update_interval, self.max_grad_norm, self.chunk_size = target_update_interval, max_grad_norm, chunk_size
        self.n_steps, self.td_lambda, self.double_q, self.loss_name = n_steps, td_lambda, double_q, loss
        self.reward_scale, self.stickiness = reward_scale, stickiness
        self.exploration_initial_eps, self.exploration_final_eps = exploration_initial_eps, exploration_final_eps
        self.exploration_episodes, self.exploration_every = exploration_episodes, exploration_every
        self._periods_trained = 0
        if _init_setup_model:
            self._setup_model()

    def _setup_model(self) -> None:
        """Build networks and buffers; SB3's own would put a Dict replay buffer there, which stores all twice."""
        self._setup_lr_schedule()
        self.set_random_seed(self.seed)
        self.rng = np.random.default_rng(self.seed)
        shapes = TaskShapes.of(self.observation_space, self.action_space)
        self.task_sizes = asdict(shapes)
        self.policy_kwargs.setdefault("state_dim", shapes.state_dim)
        self.policy = self.policy_class(
            self.observation_space, self.action_space, self.lr_schedule, **self.policy_kwargs
        ).to(self.device)  # type: ignore[assignment]
        self.replay_buffer = StepReplay(
            self.buffer_size, self.observation_space, self.action_space, self.device, self.n_envs, self.gamma  # type: ignore[arg-type]
        )
        self.explorer = Explorer(self.n_envs, shapes.n_pieces, self.stickiness)
        self.current = np.full((self.n_envs, shapes.n_pieces), NO_TASK)
        self.game_log = GameLog(self.n_envs, self.gamma)
        self._convert_train_freq()
