"""One update of agent network and mixer: loss, gradient step, targets (III-C, "Cooperative Training")."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass

import torch
from jaxtyping import Float, Int
from stable_baselines3.common.utils import polyak_update
from torch import Tensor, nn

from hexwar_sb3.algorithms.beside import Here
from hexwar_sb3.algorithms.replay import Batch, Situation
from hexwar_sb3.algorithms.td_targets import lambda_returns
from hexwar_sb3.errors import TrainingError, UnknownNameError
from hexwar_sb3.policies.agent import TaskNetwork
from hexwar_sb3.policies.mixers import Choices, Mixer
from hexwar_sb3.policies.task_policy import TaskPolicy

LOSSES = {"huber": nn.functional.smooth_l1_loss, "squared": nn.functional.mse_loss}

TENTH = 10


@dataclass(frozen=True, kw_only=True)
class TDLearner:
    """Temporal-difference learning of the mixed value.

    Args:
        policy: networks, targets, optimiser.
        loss: "huber" or "squared".
        double_q: the online network picks the next tasks, the target network values them.
        td_lambda: λ of λ-returns over windows; None takes the batch's n-step returns.
        window: steps of a window.
        max_grad_norm: gradients are clipped to it.
        tau: share of the online networks that goes into the targets.
        target_interval: updates between two changes of the targets.
        ema_tau: share of the online agent network that goes into its mean; more at first, so that it is a mean over
            the last tenth of the updates.
    """

    policy: TaskPolicy
    loss: str
    double_q: bool
    td_lambda: float | None
    window: int
    max_grad_norm: float
    tau: float
    target_interval: int
    ema_tau: float

    def __post_init__(self) -> None:
        """Check the settings.

        Raises:
            UnknownNameError: there is no such loss.
        """
        if self.loss not in LOSSES:
            raise UnknownNameError("loss", self.loss, LOSSES)

    def q_total(self, batch: Batch) -> Float[Tensor, "batch value"]:
        """Mixed value of the tasks that were played (a value a piece without a mixer), in scaled points."""
        agent = self.policy.agent
        return _mixed(agent, self.policy.mixer, self._own_now(agent, batch), batch.now, batch.tasks)

    def mixed_value(self, seen: Situation, tasks: Int[Tensor, " piece"]) -> Float[Tensor, "batch value"]:
        """Mixed value of one task of each piece where games begin, by the online networks, in scaled points."""
        agent = self.policy.agent
        return _mixed(agent, self.policy.mixer, agent.own(seen.sets), seen, tasks)

    @torch.no_grad()
    def first_value(self, seen: Situation) -> Float[Tensor, "batch value"]:
        """Target networks' value of the greedy valid tasks where games begin, in scaled points."""
        policy = self.policy
        chooser, target = self._chooser, policy.agent_target
        tasks = seen.sets.best(chooser.q_values(seen.sets))
        mixed = _mixed(target, policy.mixer_target, target.own(seen.sets), seen, tasks)
        return policy.mixer_target.next_values(mixed)

    def next_value(self, batch: Batch) -> Float[Tensor, "batch value"]:
        """Target networks' value of the greedy valid tasks after the steps, in scaled points."""
        return self.value_of(batch, Here().submit(self.best_tasks, batch))

    @torch.no_grad()
    def best_tasks(self, batch: Batch) -> Int[Tensor, " piece"]:
        """Greedy valid task of every piece after the steps."""
        chooser, sets = self._chooser, batch.then.sets
        return sets.best(chooser.values(chooser.encode(sets, self._own_then(chooser, batch)), sets))

    @torch.no_grad()
    def value_of(self, batch: Batch, tasks: Future[Tensor]) -> Float[Tensor, "batch value"]:
        """Target networks' value of tasks that are still being computed, perhaps."""
        policy, target = self.policy, self.policy.agent_target
        own = self._own_then(target, batch)
        mixed = _mixed(target, policy.mixer_target, own, batch.then, tasks.result)
        return policy.mixer_target.next_values(mixed)

    @property
    def _chooser(self) -> TaskNetwork:
        return self.policy.agent if self.double_q else self.policy.agent_target

    def _own_now(self, agent: TaskNetwork, batch: Batch) -> Tensor:
        return agent.own_in_turn(batch.now.sets, self.window, batch.now.alive.shape[1])

    def _own_then(self, agent: TaskNetwork, batch: Batch) -> Tensor:
        return agent.own(batch.then.sets, self._own_now(agent, batch) if agent.remembers else None)

    def lambda_target(self, batch: Batch, reward: Tensor, next_value: Tensor) -> Float[Tensor, "batch value"]:
        """λ-returns of the windows, in the batch's flat order."""
        table = (-1, self.window)
        target = lambda_returns(
            reward.view(*table, reward.shape[1]),
            batch.discount.view(table),
            batch.terminated.view(table),
            next_value.view(*table, next_value.shape[1]),
            batch.inside.view(table),
            self.td_lambda or 0.0,
        )
        return target.view_as(next_value)

    def mean_loss(self, batch: Batch, q_total: Tensor, target: Tensor) -> Float[Tensor, ""]:
        """Loss of the living, inside their episodes."""
        weight = self.policy.mixer.weights(batch.now.alive, q_total, target) * batch.inside.unsqueeze(1)
        return (weight * LOSSES[self.loss](q_total, target, reduction="none")).sum() / weight.sum()

    def step(self, number: int) -> None:
        """Change the online networks by the gradient, the mean, and the targets when it is their turn.

        Raises:
            TrainingError: the gradient is not finite; the networks stay as they are.
        """
        policy = self.policy
        norm = nn.utils.clip_grad_norm_(policy.trained, self.max_grad_norm)
        if not torch.isfinite(norm):
            raise TrainingError(
                f"update {number}: the gradient's norm is {norm.item()}; the weights are those before it."
                " Lower the learning rate, or look for rewards or observations that are not finite"
            )
        policy.optimizer.step()
        if number % self.target_interval == 0:
            polyak_update(policy.trained, policy.targets, self.tau)
        share = max(self.ema_tau, TENTH / (number + TENTH))
        polyak_update(policy.agent.parameters(), policy.agent_mean.parameters(), share)


def _mixed(
    agent: TaskNetwork,
    mixer: Mixer,
    own: Tensor,
    seen: Situation,
    tasks: Int[Tensor, " piece"] | Callable[[], Int[Tensor, " piece"]],
) -> Float[Tensor, "batch value"]:
    """Mixed value of one task of each piece; the tasks may come late."""
    sets, alive = seen.sets, seen.alive
    encoded = agent.encode(sets, own)
    chosen = tasks() if callable(tasks) else tasks
    choices = None
    if mixer.reads_choices:
        rows = sets.tasks[sets.rows_of(chosen)].view(*alive.shape, -1)
        choices = Choices(sets.highest(agent.values(encoded, sets)).view_as(alive), rows)
    return mixer(agent.chosen(encoded, sets, chosen).view_as(alive), seen.state, alive, choices)
