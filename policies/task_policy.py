"""The policy class for Stable-Baselines3: agent network, its mean, mixer, targets, optimiser."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.type_aliases import PyTorchObs, Schedule
from torch import Tensor

from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.frozen_lower import HEURISTIC_LOWER, Lower
from hexwar_sb3.policies.agent import MEMORIES, NETWORKS, AgentNetwork, SeparateNetworks, TaskNetwork
from hexwar_sb3.policies.mirrored import columns_of_the_camp, leave_out
from hexwar_sb3.policies.mixers import Mixer, mixer_of
from hexwar_sb3.policies.shapes import TaskShapes
from hexwar_sb3.policies.task_sets import pack_observation
from hexwar_sb3.policies.trusted import TrustedFiles

Observation = Mapping[str, np.ndarray]


class TaskPolicy(TrustedFiles, BasePolicy):
    """Picks a task for every piece: the valid one with the highest Q_i.

    In training the agent network plays as it is; `predict` and `freeze` take its mean over the last updates. Which task
    is the best one changes from update to update where values are nearly alike, and now and then that loses every game
    against somebody; the mean does not jump.

    Args:
        observation_space: the task env's Dict; its `state` is not needed to act.
        action_space: a task of each piece.
        lr_schedule: learning rate as a function of SB3's progress.
        mixer: "qmix", "vdn", "iql", "qplex" or "ow-qmix", or a subclass of `Mixer`.
        mixer_kwargs: further arguments of the mixer.
        state_dim: size of the mixer's state; None reads it from the observation space.
        network: "additive", or "literal" for layers over concatenations (the same functions, slower).
        memory: "gru": pieces remember what they saw in a game; None: they see the present alone.
        share_parameters: one network for all pieces; False: one for each, as agents of different kinds may need.
        hidden: width of the agent network.
        embed: width of a task's embedding.
        mirrored: the networks do not see which camp they play; for maps that are their own mirror images.
        optimizer_class: Adam by default.
        optimizer_kwargs: its arguments beside the learning rate.
    """

    def __init__(
        self,
        observation_space: spaces.Space[Any],
        action_space: spaces.Space[Any],
        lr_schedule: Schedule,
        *,
        mixer: str | type[Mixer] = "qmix",
        mixer_kwargs: dict[str, Any] | None = None,
        state_dim: int | None = None,
        network: str = "additive",
        memory: str | None = None,
        share_parameters: bool = True,
        hidden: int = 64,
        embed: int = 32,
        mirrored: bool = False,
        optimizer_class: type[torch.optim.Optimizer] = torch.optim.Adam,
        optimizer_kwargs: dict[str, Any] | None = None,
    ) -> None:
        super().__init__(
            observation_space,
            action_space,
            optimizer_class=optimizer_class,
            optimizer_kwargs=optimizer_kwargs
            or ({"fused": True} if optimizer_class is torch.optim.Adam else {}),
        )
        self.shapes = TaskShapes.of(observation_space, action_space)
        self.sizes = {"hidden": hidden, "embed": embed}
        self.mixer_name, self.mixer_kwargs = mixer, mixer_kwargs or {}
        self.network, self.memory, self.share_parameters = network, memory, share_parameters
        self.state_dim = state_dim or self.shapes.state_dim
        self.agent, self.agent_target = self._make_agent(), self._make_agent()
        self.agent_mean = self._make_agent()  # over the last updates: what is evaluated and shared
        self.mixer, self.mixer_target = self._make_mixer(), self._make_mixer()
        self.mirrored = mirrored
        if mirrored:
            self._leave_out_the_camp()
        self.settle()
        self.mixer_target.load_state_dict(self.mixer.state_dict())
        self.trained = [*self.agent.parameters(), *self.mixer.parameters()]
        self.targets = [*self.agent_target.parameters(), *self.mixer_target.parameters()]  # in the same order
        for parameter in (*self.targets, *self.agent_mean.parameters()):
            parameter.requires_grad_(False)
        self.lower = HEURISTIC_LOWER
        self.optimizer = optimizer_class(self.trained, lr=lr_schedule(1), **self.optimizer_kwargs)  # type: ignore[call-arg]

    @property
    def lower(self) -> Lower:
        """Who leads the pieces of a frozen copy, and of whoever asks."""
        self.lower_is_known = True
        return self._lower

    @lower.setter
    def lower(self, lower: Lower) -> None:
        self._lower, self.lower_is_known = lower, False

    def _make_agent(self) -> TaskNetwork:
        if self.network not in NETWORKS:
            raise UnknownNameError("network", self.network, NETWORKS)
        if self.memory is not None and self.memory not in MEMORIES:
            raise UnknownNameError("memory", self.memory, MEMORIES)
        kind = NETWORKS[self.network] if self.memory is None else MEMORIES[self.memory]

        def make() -> TaskNetwork:
            return kind(self.shapes.obs_dim, self.shapes.task_dim, **self.sizes)

        return (
            make() if self.share_parameters else SeparateNetworks(make() for _ in range(self.shapes.n_pieces))
        )

    def settle(self) -> None:
        """Let target and mean of the agent network be as it is now."""
        for network in (self.agent_target, self.agent_mean):
            network.load_state_dict(self.agent.state_dict())

    def _leave_out_the_camp(self) -> None:
        own, of_state = columns_of_the_camp(self.shapes, self.state_dim)
        for layer in self.agent.piece_layers:
            leave_out(layer, own)
        for layer in self.mixer.state_layers():
            leave_out(layer, of_state)

    def _make_mixer(self) -> Mixer:
        kind = mixer_of(self.mixer_name)
        return kind(self.shapes.n_pieces, self.state_dim, self.shapes.task_dim, **self.mixer_kwargs)

    def greedy(self, observation: Observation, agent: TaskNetwork | None = None) -> np.ndarray:
        """Best valid task of every piece in a batch of games [B, N], by the agent network as it is, or by another."""
        return self.act(observation, None, agent)[0]

    @torch.no_grad()
    def act(
        self, observation: Observation, memory: Tensor | None, agent: TaskNetwork | None = None
    ) -> tuple[np.ndarray, Tensor | None]:
        """Best valid tasks of a batch of games, and what the pieces remember after them.

        Args:
            observation: of the games.
            memory: of all their pieces [B * N, hidden]; None where games begin, or pieces do not remember.
            agent: network that plays; None: the agent network as it is.
        """
        agent = agent or self.agent
        sets = pack_observation(observation, self.device)
        own = agent.own(sets, memory)
        best = sets.best(agent.values(agent.encode(sets, own), sets))
        return best.cpu().numpy().reshape(-1, self.shapes.n_pieces), own if agent.remembers else None

    def predict(
        self,
        observation: np.ndarray | dict[str, np.ndarray],
        state: tuple[np.ndarray, ...] | None = None,
        episode_start: np.ndarray | None = None,
        deterministic: bool = True,
    ) -> tuple[np.ndarray, tuple[np.ndarray, ...] | None]:
        """Greedy tasks for one observation or a batch; the observation's key `state` is ignored.

        Args:
            observation: of one game, or of a batch.
            state: what the pieces remember, as the last call gave it; None where games begin.
            episode_start: games of the batch that begin with this observation: they remember nothing [B].
            deterministic: without meaning here: the policy explores nothing.
        """
        if not isinstance(observation, dict):
            raise ConfigError(
                "predict() takes the task env's dict of arrays (Gymnasium's reset() returns obs, info)"
            )
        alone = observation["obs"].ndim == 2
        batch = {key: np.asarray(value)[None] for key, value in observation.items()} if alone else observation
        tasks, memory = self.act(batch, self._recalled(state, episode_start), self.agent_mean)
        kept = state if memory is None else (memory.cpu().numpy(),)
        return tasks[0] if alone else tasks, kept

    def _recalled(
        self, state: tuple[np.ndarray, ...] | None, episode_start: np.ndarray | None
    ) -> Tensor | None:
        """Memory of all pieces, empty where a game begins."""
        if state is None or self.memory is None:
            return None
        memory = torch.as_tensor(state[0], device=self.device)
        return memory if episode_start is None else self.forget(memory, episode_start)

    def forget(self, memory: Tensor, ended: np.ndarray) -> Tensor:
        """The memory of all pieces [B * N, hidden] without that of games that ended [B]."""
        goes_on = torch.as_tensor(~np.asarray(ended, bool), device=memory.device)
        return memory * goes_on.repeat_interleave(self.shapes.n_pieces).unsqueeze(1)

    def forward(self, obs: PyTorchObs, deterministic: bool = True) -> Tensor:
        """Best tasks, from tensors [B, N]."""
        return self._predict(obs, deterministic)

    def _predict(self, observation: PyTorchObs, deterministic: bool = True) -> Tensor:
        q = self.agent_mean(*(observation[key] for key in ("obs", "tasks", "action_mask")))  # type: ignore[index]
        return q.argmax(dim=-1)

    def freeze(self, **about: str) -> FrozenPolicy:
        """Copy the mean of the agent network into a policy without torch, for play, sharing and files.

        Args:
            about: what the policy is for: rules hash, scenario, camp, command, and so on.
        """
        if not isinstance(self.agent_mean, AgentNetwork) or self.memory is not None:
            raise ConfigError(
                "only the additive network, shared by all pieces, can be frozen: train with network='additive',"
                " share_parameters=True and without memory"
            )
        weights = {name: tensor.cpu().numpy().copy() for name, tensor in self.agent_mean.state_dict().items()}
        sizes = {"n_pieces": self.shapes.n_pieces, "n_tasks": self.shapes.n_tasks}
        return FrozenPolicy(weights, **sizes, about=about, lower=self._lower)

    def agent_of(self, policy: FrozenPolicy) -> AgentNetwork:
        """Agent network with the weights of a frozen policy, of the policy's own widths.

        Raises:
            ConfigError: it takes other features.
        """
        weights = {name: torch.from_numpy(array.copy()) for name, array in policy.weights.items()}
        widths = {"hidden": len(weights["piece.weight"]), "embed": len(weights["embed.weight"])}
        agent = AgentNetwork(self.shapes.obs_dim, self.shapes.task_dim, **widths).to(self.device)
        for name, tensor in agent.state_dict().items():
            if weights[name].shape != tensor.shape:
                raise ConfigError(_misfit(name, weights[name], tensor))
        agent.load_state_dict(weights)
        return agent

    def take_over(self, policy: FrozenPolicy) -> None:
        """Take over the agent network of a frozen policy; the mixer stays.

        A narrower network is widened: its values stay, and units that are new count for nothing until they learn. What it
        makes of the camp that it plays stays as it is where this one is `mirrored`.

        Raises:
            ConfigError: it takes other features, or is wider than this one.
        """
        frozen = self.agent_of(policy).state_dict()
        self.agent.load_state_dict(_widened(frozen, self.agent.state_dict()))
        self.settle()

    def _get_constructor_parameters(self) -> dict[str, Any]:
        return {
            "observation_space": self.observation_space,
            "action_space": self.action_space,
            "lr_schedule": self._dummy_schedule,
            "mixer": self.mixer_name,
            "mixer_kwargs": self.mixer_kwargs,
            "state_dim": self.state_dim,
            "network": self.network,
            "memory": self.memory,
            "share_parameters": self.share_parameters,
            **self.sizes,
            "mirrored": self.mirrored,
            "optimizer_class": self.optimizer_class,
            "optimizer_kwargs": self.optimizer_kwargs,
        }


def _widened(narrow: Mapping[str, Tensor], wide: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Weights of a wider network that computes the same: old units hear nothing from those that are new.

    Raises:
        ConfigError: a layer of `narrow` is the wider one, or is missing in `wide`.
    """
    widened = {name: tensor.clone() for name, tensor in wide.items()}
    for name, tensor in narrow.items():
        if name not in wide or any(a > b for a, b in zip(tensor.shape, wide[name].shape, strict=True)):
            raise ConfigError(_misfit(name, tensor, wide.get(name)))
        widened[name][: len(tensor)] = 0.0
        widened[name][tuple(slice(size) for size in tensor.shape)] = tensor
    return widened


def _misfit(name: str, found: Tensor, expected: Tensor | None) -> str:
    size = "no such layer" if expected is None else tuple(expected.shape)
    return f"{name}: the policy has {tuple(found.shape)}, this model {size}"
