"""QMIX over task sets as a Stable-Baselines3 algorithm (III-C); VDN and independent Q by the same class."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor, Future
from dataclasses import asdict
from typing import Any, ClassVar

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3.common.buffers import ReplayBuffer
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.noise import ActionNoise
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.running_mean_std import RunningMeanStd
from stable_baselines3.common.type_aliases import GymEnv, MaybeCallback, Schedule
from stable_baselines3.common.utils import LinearSchedule
from torch import Tensor

from hexwar_sb3.algorithms.beside import Here
from hexwar_sb3.algorithms.exploration import NO_TASK, Explorer, checked_masks, epsilon_at, random_tasks
from hexwar_sb3.algorithms.game_log import GameLog
from hexwar_sb3.algorithms.model_zip import ModelZip
from hexwar_sb3.algorithms.ranges import (
    COUNTER,
    COUNTERS,
    LEARNING,
    MOST_BATCH,
    NOT_NEGATIVE,
    OPTIMIZER,
    POSITIVE,
    SHARE,
    WIDTH,
    Choice,
    Misfit,
    Number,
    Parts,
    Table,
    Whole,
    flag,
    mended,
    optional,
    options,
    pair,
    row,
    scalar,
    setting,
)
from hexwar_sb3.algorithms.replay import Batch, StepReplay, situation_of
from hexwar_sb3.algorithms.squads import SquadOrders, check_ordered
from hexwar_sb3.algorithms.task_model import TaskModel
from hexwar_sb3.algorithms.td_targets import qmix_target
from hexwar_sb3.algorithms.td_update import LOSSES, TDLearner
from hexwar_sb3.engine.fields import check_form, check_names, check_range
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.policies.activations import RELU, named_activation
from hexwar_sb3.policies.agent import MEMORIES, NETWORKS
from hexwar_sb3.policies.mixers import MIXERS, Mixer
from hexwar_sb3.policies.shapes import SIZE_LIMITS, TaskShapes
from hexwar_sb3.policies.task_policy import TaskPolicy

STOP = 0  # row of every task set: stop what is under way
LEAST_SCALE = 1e-3  # of rewards: in a game without any nothing is divided by nearly 0
BELOW_ONE = Number(0.0, math.nextafter(1.0, 0.0), "in [0, 1)")
EVERY = "(n, 'episode') or (n, 'step') with n >= 1"


def update_every(value: Any) -> tuple[int, str]:
    """When to train: (n, "episode") or (n, "step"); n alone means steps of the VecEnv, as in SB3."""
    found = row(value)
    try:
        number, unit = found if isinstance(found, list | tuple) else (found, "step")
        unit = scalar(getattr(unit, "value", unit))  # of SB3's TrainFreq
        if unit in ("episode", "step"):
            return Whole()(number), str(unit)
    except (Misfit, TypeError, ValueError):
        pass
    raise Misfit(value, EVERY)


def three_figures(value: Any) -> list[float]:
    """Mean, variance and number of something."""
    found = row(value)
    kinds = Number(-sys.float_info.max, sys.float_info.max, "finite"), NOT_NEGATIVE, POSITIVE
    if not isinstance(found, list | tuple) or len(found) != len(kinds):
        raise Misfit(value, "three numbers")
    return [kind(one) for kind, one in zip(kinds, found, strict=True)]


def mixer_setting(value: Any) -> str | type[Mixer]:
    """A mixer by its name, or a class of one's own, which no file holds."""
    if isinstance(value, type) and issubclass(value, Mixer):
        return value
    return Choice("mixer", MIXERS)(value)


POLICY_KWARGS = Parts(
    {
        "mixer": mixer_setting,
        "mixer_kwargs": Parts({"embed": WIDTH, "hidden": WIDTH, "alpha": SHARE}),
        "state_dim": optional(Whole(1, SIZE_LIMITS["state_dim"])),
        "network": Choice("network", NETWORKS),
        "memory": optional(Choice("memory", MEMORIES)),
        "share_parameters": flag,
        "hidden": WIDTH,
        "embed": WIDTH,
        "mirrored": flag,
        "optimizer_kwargs": OPTIMIZER,
    },
    others=("optimizer_class",),
)


def policy_kwargs(value: Any) -> dict[str, Any]:
    """Arguments of the policy; `net_arch` and `activation_fn`, as SB3's policies have them, stand for ours.

    Raises:
        Misfit: other layers than the two of the agent network, or another function between them.
        ConfigError: a width is said twice.
    """
    found = dict(value) if isinstance(value, Mapping) else value
    if isinstance(found, dict) and "net_arch" in found:
        expected = "two widths, [hidden, embed] of the agent network"
        widths = mended("net_arch", found.pop("net_arch"), pair(WIDTH, WIDTH, expected))
        if said := sorted({"hidden", "embed"} & set(found)):
            raise ConfigError(f"policy_kwargs: net_arch is [hidden, embed], leave it or {said} out")
        found["hidden"], found["embed"] = widths
    if isinstance(found, dict) and "activation_fn" in found:
        given = found.pop("activation_fn")
        if named_activation(scalar(given)) != RELU:
            expected = "torch.nn.ReLU: the network that plays without torch has no other function"
            raise Misfit(given, expected, "activation_fn")
    return POLICY_KWARGS(found)


SETTINGS: Table = {
    **LEARNING,
    "policy_kwargs": policy_kwargs,
    "train_freq": update_every,
    "ema_tau": SHARE,
    "td_lambda": optional(SHARE),
    "double_q": flag,
    "loss": Choice("loss", LOSSES),
    "reward_scale": optional(POSITIVE),
    "individual_rewards": flag,
    "exploration_episodes": Whole(),
    "exploration_every": Whole(),
    "exploration_steps": optional(Whole()),
    "stickiness": BELOW_ONE,
    "squad_initial_share": SHARE,
    "squad_final_share": SHARE,
    "squad_episodes": Whole(),
    "chunk_size": Whole(1, MOST_BATCH),
}
"""Settings of QMIX by their arguments' names."""


class QMIX(TaskModel):
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
        train_freq: (1, "episode") trains after every finished game of any env; or (n, "step") of the VecEnv, n for short.
        gradient_steps: updates each time; those of games or steps that lie longer back are not made up for.
        target_update_interval: updates between two changes of the targets.
        ema_tau: share of the online agent network that goes into its mean, which `predict` and `freeze` take;
            more at first: it is a mean over the last tenth of the updates.
        final_learning_rate: where the learning rate ends, in a straight line over the env steps of `learn`; None keeps it.
        mixer: "qmix", "vdn", "iql", "qplex" or "ow-qmix", or a subclass of `hexwar_sb3.policies.Mixer`.
        memory: "gru": pieces remember what they saw in a game. Transitions are windows then, with `td_lambda` or 0, which
            reach back to the begin of their game: let `n_steps` be as long as games are. None: no memory.
        share_parameters: one network for all agents; False: one for each, slower, and never frozen.
        n_steps: steps of a transition; with `td_lambda` or `memory` the length of its windows.
        td_lambda: λ of λ-returns; None takes n-step returns.
        double_q: the online network picks the next tasks, the target network values them.
        loss: "huber" or "squared", of the mixed value.
        reward_scale: rewards are divided by it; values are logged in points all the same. None: by the standard deviation
            of the discounted returns so far, a saved figure.
        individual_rewards: each agent learns from its own reward, info["rewards"], as `JointActionEnv` gives it; with "iql",
            as the other mixers value the team.
        exploration_initial_eps: probability of a random task at the start.
        exploration_final_eps: and after `exploration_episodes`; pieces that stick to it explore several times as often.
        exploration_episodes: finished games until then; a saved count, so a resumed run goes on where it was.
        exploration_every: episodes between two steps down.
        exploration_steps: env steps until then, in place of games; None: games count.
        stickiness: probability that an exploring piece keeps its random task at a decision.
        squad_initial_share: share of the games, at the start, in which some pieces hold a spot together for a while
            (`SquadOrders`); 0 but for the task env.
        squad_final_share: and after `squad_episodes`.
        squad_episodes: finished games until then.
        max_grad_norm: gradients are clipped to it.
        chunk_size: transitions computed at a time; gradients add up.
        policy_kwargs: further arguments of the policy; net_arch=[64, 32], as SB3's policies have it, is hidden=64 and
            embed=32.
        stats_window_size: as in SB3.
        tensorboard_log: as in SB3.
        verbose: as in SB3.
        seed: of networks, exploration, replay and env.
        device: "auto" takes a GPU where there is one.
        _init_setup_model: build the networks now.
    """

    policy_aliases: ClassVar[dict[str, type[BasePolicy]]] = {
        "TaskPolicy": TaskPolicy,
        "MultiInputPolicy": TaskPolicy,
    }
    zip_name: ClassVar[str] = "QMIX"
    settings: ClassVar[Table] = SETTINGS
    state: ClassVar[Table] = {**COUNTERS, "_periods_trained": COUNTER, "return_figures": three_figures}
    attributes: ClassVar[Mapping[str, str]] = {**TaskModel.attributes, "train_freq": "update_every"}
    places: ClassVar[tuple[str, ...]] = (*TaskModel.places, "mixer")
    _learns = "all"  # or "mixer" alone, or "nothing"
    # Who computes a part of each update; `executor(2)`: another core, with the same bits.
    beside: Executor = Here()

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
        train_freq: int | tuple[int, str] = (1, "episode"),
        gradient_steps: int = 1,
        target_update_interval: int = 1,
        *,
        ema_tau: float = 0.002,
        final_learning_rate: float | None = None,
        mixer: str | type[Mixer] = "qmix",
        memory: str | None = None,
        share_parameters: bool = True,
        n_steps: int = 4,
        td_lambda: float | None = None,
        double_q: bool = True,
        loss: str = "huber",
        reward_scale: float | None = 50.0,
        individual_rewards: bool = False,
        exploration_initial_eps: float = 0.5,
        exploration_final_eps: float = 0.02,
        exploration_episodes: int = 4_000,
        exploration_every: int = 1,
        exploration_steps: int | None = None,
        stickiness: float = 0.8,
        squad_initial_share: float = 0.0,
        squad_final_share: float = 0.0,
        squad_episodes: int = 7_000,
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
            policy_kwargs={
                "mixer": mixer,
                **({} if memory is None else {"memory": memory}),
                **({} if share_parameters else {"share_parameters": False}),
                **setting("policy_kwargs", policy_kwargs or {}, options),
            },
            stats_window_size=stats_window_size,
            tensorboard_log=tensorboard_log,
            verbose=verbose,
            seed=seed,
            device=device,
            support_multi_env=True,
            sde_support=False,
        )
        self.update_every: Any = train_freq  # SB3 counts episodes with a single env only
        self.target_update_interval = target_update_interval
        self.final_learning_rate, self.ema_tau = final_learning_rate, ema_tau
        self.n_steps, self.td_lambda, self.double_q, self.loss = n_steps, td_lambda, double_q, loss
        self.reward_scale, self.stickiness = reward_scale, stickiness
        self.individual_rewards = individual_rewards
        self.max_grad_norm, self.chunk_size = max_grad_norm, chunk_size
        self.exploration_initial_eps = exploration_initial_eps
        self.exploration_final_eps = exploration_final_eps
        self.exploration_episodes, self.exploration_every = exploration_episodes, exploration_every
        self.exploration_steps = exploration_steps
        self.returns = RunningMeanStd(shape=())  # of discounted returns so far
        self.squad_initial_share, self.squad_final_share = squad_initial_share, squad_final_share
        self.squad_episodes = squad_episodes
        self._periods_trained = 0
        if _init_setup_model:
            self._setup_model()

    def _setup_model(self) -> None:
        """Build networks and replay; SB3's own would store every observation twice."""
        self._mend_settings()
        if self.env is not None:
            self.check_env(self.env)
        self._setup_lr_schedule()
        self.set_random_seed(self.seed)
        self.rng = np.random.default_rng(self.seed)
        shapes = TaskShapes.of(self.observation_space, self.action_space)
        self.task_sizes = asdict(shapes)
        if self.squad_initial_share or self.squad_final_share:
            check_ordered(shapes)
        if self.individual_rewards and self.policy_kwargs["mixer"] != "iql":
            raise ConfigError("individual_rewards needs mixer='iql': the others value what the team gets")
        self.policy_kwargs.setdefault("state_dim", shapes.state_dim)
        policy = self.policy_class(
            self.observation_space, self.action_space, self.lr_schedule, **self.policy_kwargs
        )
        self.policy = policy.to(self.device)  # type: ignore[assignment]
        self._give_room()
        self.learner = self._make_learner()
        self.follow_lower()
        self._begin_games()
        self._convert_train_freq()

    @classmethod
    def _checked(cls, zipped: ModelZip, given: dict[str, Any]) -> dict[str, Any]:
        mixer = given.pop("mixer", None)
        values = super()._checked(zipped, given)
        if mixer is not None:
            values["policy_kwargs"] = {**values["policy_kwargs"], "mixer": mixer}
        return values

    def _make_replay(self, buffer_size: int) -> StepReplay:
        return StepReplay(
            buffer_size,
            self.observation_space,
            self.action_space,
            self.device,
            self.n_envs,
            self.gamma,
            individual_rewards=self.individual_rewards,
        )

    def _setup_lr_schedule(self) -> None:
        """Make the schedule, of plain numbers where it falls; its progress goes on in a resumed run."""
        super()._setup_lr_schedule()
        if self.final_learning_rate is not None:
            self.lr_schedule = LinearSchedule(float(self.learning_rate), self.final_learning_rate, 1.0)  # type: ignore[arg-type]

    def _make_learner(self) -> TDLearner:
        return TDLearner(
            policy=self.policy,
            loss=self.loss,
            double_q=self.double_q,
            td_lambda=self.td_lambda,
            window=self.n_steps,
            max_grad_norm=self.max_grad_norm,
            tau=self.tau,
            target_interval=self.target_update_interval,
            ema_tau=self.ema_tau,
        )

    def _begin_games(self) -> None:
        """Forget the running games: the env was or will be reset."""
        n_pieces = self.policy.shapes.n_pieces
        self.replay_buffer.cut_short()
        self.explorer = Explorer(self.n_envs, n_pieces, self.stickiness)
        self.squads = SquadOrders(self.n_envs, n_pieces)
        self.current = np.full((self.n_envs, n_pieces), NO_TASK)
        self.recalled: Tensor | None = None  # what pieces remember [n * N, hidden]
        self.game_log = GameLog(self.n_envs, self.gamma)

    def _setup_learn(
        self,
        total_timesteps: int,
        callback: MaybeCallback = None,
        reset_num_timesteps: bool = True,
        tb_log_name: str = "run",
        progress_bar: bool = False,
    ) -> tuple[int, BaseCallback]:
        if self.env is None:
            raise ConfigError(
                "this model has no env to learn in: QMIX.load(path, env=env), or model.set_env(env)"
            )
        state_dim = TaskShapes.of(self.observation_space, self.action_space).state_dim
        if state_dim != self.policy.state_dim:
            raise ConfigError(
                f"the mixer was trained on a state of {self.policy.state_dim} numbers, the env gives {state_dim}:"
                " make it with the same privileged_state"
            )
        if reset_num_timesteps:
            self._periods_trained = 0
        if reset_num_timesteps or self._last_obs is None:
            self._begin_games()
        self.policy.agent.requires_grad_(
            self._learns != "mixer"
        )  # a refit that was interrupted left it frozen
        steps, callbacks = super()._setup_learn(
            total_timesteps, callback, reset_num_timesteps, tb_log_name, progress_bar
        )
        self._lead_evaluations(callbacks)
        return steps, callbacks

    @property
    def exploration_rate(self) -> float:
        """Epsilon now: a function of the number of finished games, or of env steps."""
        if self.exploration_steps is not None:
            ends = self.exploration_initial_eps, self.exploration_final_eps
            return epsilon_at(self.num_timesteps, *ends, self.exploration_steps)
        return epsilon_at(
            self._episode_num,
            self.exploration_initial_eps,
            self.exploration_final_eps,
            self.exploration_episodes,
            self.exploration_every,
        )

    @property
    def scale(self) -> float:
        """Points that count as 1 in what is learned."""
        if self.reward_scale is not None:
            return self.reward_scale
        return max(math.sqrt(float(self.returns.var)), LEAST_SCALE)

    @property
    def return_figures(self) -> list[float]:
        """Mean, variance and number of the discounted returns so far."""
        return [float(self.returns.mean), float(self.returns.var), float(self.returns.count)]

    @return_figures.setter
    def return_figures(self, figures: list[float]) -> None:
        self.returns.mean, self.returns.var, self.returns.count = (
            np.array(figures[0]),
            np.array(figures[1]),
            figures[2],
        )

    @property
    def squad_share(self) -> float:
        """Share of the games that begin now in which a squad has an order: a function of the finished games."""
        return epsilon_at(
            self._episode_num, self.squad_initial_share, self.squad_final_share, self.squad_episodes
        )

    def _sample_action(
        self, learning_starts: int, action_noise: ActionNoise | None = None, n_envs: int = 1
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Explore among the valid tasks, each piece of each game for itself."""
        observation: dict[str, Any] = self._last_obs  # type: ignore[assignment]
        if self.game_log.starting.any():
            value = self.learner.first_value(situation_of(observation, self.device)).mean(dim=1)
            self.game_log.predict(value.cpu().numpy() * self.scale)
        epsilon = 1.0 if self.num_timesteps < learning_starts else self.exploration_rate
        mask = checked_masks(observation["action_mask"])
        greedy, self.recalled = self.policy.act(observation, self.recalled)
        tasks = self.explorer.choose(greedy, self.current, mask, epsilon, self.rng)
        if self.squad_initial_share or self.squad_final_share:
            tasks = self.squads.lead(tasks, observation, self.squad_share, self.rng)
        return tasks, tasks

    def predict(
        self,
        observation: np.ndarray | dict[str, np.ndarray],
        state: tuple[np.ndarray, ...] | None = None,
        episode_start: np.ndarray | None = None,
        deterministic: bool = False,
    ) -> tuple[np.ndarray, tuple[np.ndarray, ...] | None]:
        """Tasks for one observation or a batch; not deterministic: each piece explores with probability epsilon."""
        self._warn_of_the_heuristic()
        tasks, state = self.policy.predict(observation, state, episode_start)
        mask = checked_masks(np.asarray(observation["action_mask"]))
        if not deterministic:
            tasks = np.where(
                self.rng.random(tasks.shape) < self.exploration_rate, random_tasks(mask, self.rng), tasks
            )
        return tasks, state

    def _store_transition(
        self,
        replay_buffer: ReplayBuffer,
        buffer_action: np.ndarray,
        new_obs: np.ndarray | dict[str, np.ndarray],
        reward: np.ndarray,
        dones: np.ndarray,
        infos: list[dict[str, Any]],
    ) -> None:
        """Store a step, and see which tasks are still under way."""
        self._log_step(buffer_action, reward, dones, infos)
        under_way = np.array([info.get("current_tasks", buffer_action[b]) for b, info in enumerate(infos)])
        self.current = np.where(dones[:, None], NO_TASK, under_way)
        self.explorer.end_games(dones)
        if self.recalled is not None:
            self.recalled = self.policy.forget(self.recalled, dones)
        self.squads.end_games(dones)
        super()._store_transition(replay_buffer, buffer_action, new_obs, reward, dones, infos)

    def _log_step(
        self, tasks: np.ndarray, reward: np.ndarray, dones: np.ndarray, infos: list[dict[str, Any]]
    ) -> None:
        alive = self._last_obs["alive"] > 0  # type: ignore[index]
        going_on = alive & (self.current != NO_TASK)
        self.logger.record("rollout/exploration_rate", self.exploration_rate)
        if alive.any():
            self.logger.record_mean("rollout/stop_share", float((tasks == STOP)[alive].mean()))
        if going_on.any():
            self.logger.record_mean("rollout/task_changes", float((tasks != self.current)[going_on].mean()))
        if self.reward_scale is None:
            self.returns.update(self.game_log.returns + self.game_log.discounts * reward)
        for predicted, returned in self.game_log.add(reward, dones, infos):
            self.logger.record_mean("rollout/predicted_return", float(predicted))
            self.logger.record_mean("rollout/discounted_return", float(returned))

    def snapshot(self) -> dict[str, NDArray[Any]]:
        """What a checkpoint needs beside the model zip, the replay and the running games: what pieces remember."""
        return {} if self.recalled is None else {"recalled": self.recalled.cpu().numpy()}

    def restore(self, parts: Mapping[str, NDArray[Any]]) -> None:
        """Take over what `snapshot` gave.

        Raises:
            CheckpointError: it is broken.
        """
        check_names(parts, ("recalled",) if parts and self.policy.memory is not None else ())
        if parts:
            shape = (self.n_envs * self.policy.shapes.n_pieces, self.policy.sizes["hidden"])
            check_form("recalled", parts["recalled"], np.float32, shape)
            check_range("recalled", parts["recalled"], -1, 1)
            self.recalled = torch.as_tensor(parts["recalled"], device=self.device)

    def take_over(self, policy: FrozenPolicy) -> None:
        """Go on from a frozen policy; its lower level leads the pieces of this model's env from now on.

        The mixer stays as it is: `refit_mixer` lets it learn what the new values come to.

        Raises:
            ConfigError: it takes other features, or its network is wider than this one's.
        """
        self.policy.take_over(policy)
        self.lead_with(policy.lower)

    def refit_mixer(self, total_timesteps: int) -> None:
        """Let the mixer alone learn for some env steps: the values of agents that came without one.

        Args:
            total_timesteps: env steps; they count as any others.
        """
        self._learn_with("mixer", total_timesteps)

    def fill_replay(self, total_timesteps: int) -> None:
        """Play for some env steps and learn nothing, so that a model that goes on does not learn from a few games alone.

        Args:
            total_timesteps: env steps; they count as any others.
        """
        self._learn_with("nothing", total_timesteps)

    def _learn_with(self, part: str, total_timesteps: int) -> None:
        self._learns = part
        try:
            self.learn(total_timesteps, reset_num_timesteps=False)
        finally:
            self._learns = "all"
            self.policy.agent.requires_grad_(True)

    def train(self, gradient_steps: int, batch_size: int = 128) -> None:
        """Make the updates that are due since the last call."""
        due = self._periods_due() * gradient_steps
        if not due or self._learns == "nothing":
            return
        self._update_learning_rate(self.policy.optimizer)
        for loss, q_total in self.updates(due, batch_size):
            self._log_update(loss, q_total)

    def updates(self, count: int, batch_size: int) -> Iterator[tuple[float, float]]:
        """Make updates; gives the loss and the mean joint value of each, in scaled points."""
        sizes = chunk_sizes(batch_size, self.chunk_size)
        drawn = self._draw(sizes * count)
        for _ in range(count):
            self.policy.optimizer.zero_grad()
            for size in sizes:
                loss, q_total = self._loss(*next(drawn))
                if loss.requires_grad:  # not where a mixer without weights is refitted
                    (loss * (size / batch_size)).backward()  # type: ignore[no-untyped-call]
            self._n_updates += 1
            self.learner.step(self._n_updates)
            yield loss.item(), q_total.mean().item()

    def _draw(self, sizes: list[int]) -> Iterator[tuple[Batch, Future[Tensor]]]:
        """Batches of these sizes with what is best after each; the next is drawn while the last is learned from."""
        upcoming = self.beside.submit(self._sample, sizes[0])
        for size in [*sizes[1:], None]:
            batch = upcoming.result()
            best = self.beside.submit(self.learner.best_tasks, batch)
            if size is not None:
                upcoming = self.beside.submit(self._sample, size)
            yield batch, best

    def _loss(self, batch: Batch, best: Future[Tensor]) -> tuple[Tensor, Tensor]:
        """Loss and joint value of a batch, in scaled points."""
        q_total = self.learner.q_total(batch)
        reward, next_value = batch.reward / self.scale, self.learner.value_of(batch, best)
        if not self._in_windows:
            target = qmix_target(reward, batch.terminated, next_value, batch.discount)
        else:
            target = self.learner.lambda_target(batch, reward, next_value)
        return self.learner.mean_loss(batch, q_total, target), q_total

    def _log_update(self, loss: float, q_total: float) -> None:
        self.logger.record("train/n_updates", self._n_updates, exclude="tensorboard")
        self.logger.record_mean("train/loss", loss)
        self.logger.record_mean("train/q_total", q_total * self.scale)

    def _periods_due(self) -> int:
        """Periods of `train_freq` that ended since the last call, as far as one vector step can end them.

        So nothing piles up before `learning_starts`, or where a model goes on with fewer games at a time.
        """
        length, unit = self.update_every
        if unit == "episode":
            periods, most = self._episode_num // length, -(-self.n_envs // length)
        else:
            periods, most = self.num_timesteps // self.n_envs // length, 1
        due, self._periods_trained = periods - self._periods_trained, periods
        return min(max(due, 0), most)

    def _sample(self, size: int) -> Batch:
        if not self._in_windows:
            return self.replay_buffer.sample(size, self.n_steps, self.rng)
        windows = max(1, size // self.n_steps)
        return self.replay_buffer.sample_windows(
            windows, self.n_steps, self.rng, reach_back=self.policy.memory is not None
        )

    @property
    def _in_windows(self) -> bool:
        """Transitions are windows of single steps."""
        return self.td_lambda is not None or self.policy.memory is not None


def chunk_sizes(total: int, limit: int) -> list[int]:
    """Cut a batch into chunks of at most `limit`."""
    return [min(limit, total - start) for start in range(0, total, limit)]
