"""Mixers: from each piece's Q to the camp's (Fig. 5, III-C), all behind one interface."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from math import expm1, log
from typing import ClassVar

import torch
from jaxtyping import Float
from torch import Tensor, nn

from hexwar_sb3.errors import UnknownNameError


@dataclass(frozen=True)
class Choices:
    """What some mixers read beside the values of the chosen tasks; 0 for the dead."""

    best_q: Float[Tensor, "batch piece"]  # highest Q_i of each piece's task set
    rows: Float[Tensor, "batch piece feature"]  # features of its chosen task

    def of_the(self, alive: Float[Tensor, "batch piece"]) -> Choices:
        """Leave out the dead."""
        return Choices(self.best_q * alive, self.rows * alive.unsqueeze(2))


class Mixer(nn.Module):
    """Turns the pieces' chosen Q into the values that are trained: one for the camp, one a piece, or others.

    A mixer of your own is a subclass with `mix`: `QMIX(..., mixer=MyMixer)`.

    Args:
        n_pieces: N.
        state_dim: size of the state, Ds.
        task_dim: features of a task, Dt.
    """

    reads_choices: ClassVar[bool] = False

    def __init__(self, n_pieces: int, state_dim: int, task_dim: int) -> None:
        super().__init__()
        self.n_pieces, self.state_dim, self.task_dim = n_pieces, state_dim, task_dim

    def forward(
        self,
        agent_q: Float[Tensor, "batch piece"],
        state: Float[Tensor, "batch state"],
        alive: Float[Tensor, "batch piece"],
        choices: Choices | None = None,
    ) -> Float[Tensor, "batch value"]:
        """Mix; the dead count nothing.

        Args:
            agent_q: Q_i of the chosen task of each piece, in scaled points [B, N].
            state: the whole state, which only the mixer sees [B, Ds].
            alive: 1 for a living piece, else 0 [B, N].
            choices: for a mixer that `reads_choices`; others may do without.
        """
        return self.mix(agent_q * alive, state, None if choices is None else choices.of_the(alive))

    @abstractmethod
    def mix(
        self,
        agent_q: Float[Tensor, "batch piece"],
        state: Float[Tensor, "batch state"],
        choices: Choices | None,
    ) -> Float[Tensor, "batch value"]:
        """Mix the Q of the living."""

    def state_layers(self) -> list[nn.Linear]:
        """Layers that read the state."""
        return []

    def next_values(self, mixed: Float[Tensor, "batch value"]) -> Float[Tensor, "batch value"]:
        """What the trained values learn from, of the mixed ones after a step."""
        return mixed

    def weights(
        self,
        alive: Float[Tensor, "batch piece"],
        mixed: Float[Tensor, "batch value"],
        target: Float[Tensor, "batch value"],
    ) -> Float[Tensor, "batch value"]:
        """Weight of each trained value in the loss."""
        return torch.ones_like(mixed)

    @property
    def joint_dim(self) -> int:
        """Numbers in the state and the features of all chosen tasks."""
        return self.state_dim + self.n_pieces * self.task_dim


class MonotonicMixer(Mixer):
    """Mix Q_i into Q_Σ so that dQ_Σ/dQ_i >= 0 (Fig. 5; Rashid et al. 2018): "qmix"."""

    def __init__(
        self, n_pieces: int, state_dim: int, task_dim: int, embed: int = 32, hidden: int = 64
    ) -> None:
        super().__init__(n_pieces, state_dim, task_dim)
        self.embed = embed
        self.hyper_w1 = _hypernetwork(state_dim, hidden, n_pieces * embed)
        self.hyper_b1 = nn.Linear(state_dim, embed)
        self.hyper_w2 = _hypernetwork(state_dim, hidden, embed)
        self.hyper_b2 = _hypernetwork(state_dim, embed, 1)  # V(s)

    def mix(
        self,
        agent_q: Float[Tensor, "batch piece"],
        state: Float[Tensor, "batch state"],
        choices: Choices | None = None,
    ) -> Float[Tensor, "batch 1"]:
        """Q_Σ of each game."""
        w1 = self.hyper_w1(state).abs().view(-1, self.n_pieces, self.embed)  # >= 0
        w2 = self.hyper_w2(state).abs()  # >= 0
        hidden = nn.functional.elu(torch.einsum("bn,bne->be", agent_q, w1) + self.hyper_b1(state))
        return (hidden * w2).sum(dim=1, keepdim=True) + self.hyper_b2(state)

    def state_layers(self) -> list[nn.Linear]:
        """First layers of the hypernetworks."""
        return [self.hyper_b1, *map(_first, (self.hyper_w1, self.hyper_w2, self.hyper_b2))]


class SumMixer(Mixer):
    """Q_Σ = Σ Q_i (value decomposition, Sunehag et al. 2018): "vdn"."""

    def mix(
        self,
        agent_q: Float[Tensor, "batch piece"],
        state: Float[Tensor, "batch state"],
        choices: Choices | None = None,
    ) -> Float[Tensor, "batch 1"]:
        """Q_Σ of each game."""
        return agent_q.sum(dim=1, keepdim=True)


class IndependentMixer(Mixer):
    """No mixing: every piece learns the camp's reward for itself: "iql"."""

    def mix(
        self,
        agent_q: Float[Tensor, "batch piece"],
        state: Float[Tensor, "batch state"],
        choices: Choices | None = None,
    ) -> Float[Tensor, "batch piece"]:
        """Q_i of each piece."""
        return agent_q

    def weights(
        self,
        alive: Float[Tensor, "batch piece"],
        mixed: Float[Tensor, "batch piece"],
        target: Float[Tensor, "batch piece"],
    ) -> Float[Tensor, "batch piece"]:
        """The living share a weight of 1 a game."""
        return alive / alive.sum(dim=1, keepdim=True).clamp(min=1.0)


class DuplexMixer(Mixer):
    """A weight above 0 for the advantage A_i = Q_i - max Q_i of each piece (Wang et al. 2021): "qplex".

    Q_Σ = Σ (w_i max Q_i + b_i) + Σ λ_i w_i A_i, with w_i > 0 and b_i of the state, λ_i > 0 of the joint choice. Where all
    pieces take their best tasks every A_i is 0, and elsewhere none is above it: so each piece's best task is part of
    the best joint choice, as in "qmix", and any joint value can be said so.
    """

    reads_choices = True

    def __init__(self, n_pieces: int, state_dim: int, task_dim: int, hidden: int = 64) -> None:
        super().__init__(n_pieces, state_dim, task_dim)
        self.scale = _hypernetwork(state_dim, hidden, n_pieces)
        self.shift = _hypernetwork(state_dim, hidden, n_pieces)
        self.weight = _hypernetwork(self.joint_dim, hidden, n_pieces)

    def mix(
        self,
        agent_q: Float[Tensor, "batch piece"],
        state: Float[Tensor, "batch state"],
        choices: Choices | None = None,
    ) -> Float[Tensor, "batch 1"]:
        """Q_Σ of each game."""
        best_q, joint = _read(choices, state)
        scale, weight = above_zero(self.scale(state)), above_zero(self.weight(joint))
        values = scale * best_q + self.shift(state) + weight * scale * (agent_q - best_q)
        return values.sum(dim=1, keepdim=True)

    def state_layers(self) -> list[nn.Linear]:
        """First layers of all networks; the state comes first in each."""
        return [_first(net) for net in (self.scale, self.shift, self.weight)]


class OptimisticMixer(MonotonicMixer):
    """The monotonic mixer beside a value of the joint choice that nothing binds (Rashid et al. 2020): "ow-qmix".

    The free value is what targets are made of. In the loss of the mixed one, choices that turned out worse than it says
    count `alpha` only: so one good joint choice among bad ones is not averaged away.
    """

    reads_choices = True

    def __init__(
        self,
        n_pieces: int,
        state_dim: int,
        task_dim: int,
        embed: int = 32,
        hidden: int = 64,
        alpha: float = 0.1,
    ) -> None:
        super().__init__(n_pieces, state_dim, task_dim, embed, hidden)
        self.alpha = alpha
        self.free = nn.Sequential(
            nn.Linear(self.joint_dim, hidden),
            nn.ReLU(),
            nn.Linear(hidden, hidden),
            nn.ReLU(),
            nn.Linear(hidden, 1),
        )

    def mix(
        self,
        agent_q: Float[Tensor, "batch piece"],
        state: Float[Tensor, "batch state"],
        choices: Choices | None = None,
    ) -> Float[Tensor, "batch 2"]:
        """Q_Σ and the free value of each game."""
        _, joint = _read(choices, state)
        return torch.cat([super().mix(agent_q, state), self.free(joint)], dim=1)

    def state_layers(self) -> list[nn.Linear]:
        """First layers of all networks; the state comes first in each."""
        return [*super().state_layers(), _first(self.free)]

    def next_values(self, mixed: Float[Tensor, "batch 2"]) -> Float[Tensor, "batch 2"]:
        """The free value, for both."""
        return mixed[:, 1:].expand(-1, 2)

    def weights(
        self,
        alive: Float[Tensor, "batch piece"],
        mixed: Float[Tensor, "batch 2"],
        target: Float[Tensor, "batch 2"],
    ) -> Float[Tensor, "batch 2"]:
        """1 where the mixed value is below its target, else `alpha`; 1 for the free value."""
        worse = mixed.detach()[:, :1] >= target[:, :1]
        return torch.cat([torch.where(worse, self.alpha, 1.0), torch.ones_like(target[:, 1:])], dim=1)


MIXERS: dict[str, type[Mixer]] = {
    "qmix": MonotonicMixer,
    "vdn": SumMixer,
    "iql": IndependentMixer,
    "qplex": DuplexMixer,
    "ow-qmix": OptimisticMixer,
}


def mixer_of(mixer: str | type[Mixer]) -> type[Mixer]:
    """Class of a mixer by its name; a class as it is.

    Raises:
        UnknownNameError: there is none of this name.
    """
    if isinstance(mixer, str):
        if mixer not in MIXERS:
            raise UnknownNameError("mixer", mixer, MIXERS)
        return MIXERS[mixer]
    return mixer


def above_zero(values: Tensor) -> Tensor:
    """A number above 0 for each: 1 for 0, and nearly itself where it is large."""
    return nn.functional.softplus(values + log(expm1(1.0)))


def _read(
    choices: Choices | None, state: Float[Tensor, "batch state"]
) -> tuple[Float[Tensor, "batch piece"], Float[Tensor, "batch joint"]]:
    """Best values, and the state beside the features of all chosen tasks."""
    if choices is None:
        raise TypeError("this mixer reads choices")
    return choices.best_q, torch.cat([state, choices.rows.flatten(1)], dim=1)


def _first(net: nn.Sequential) -> nn.Linear:
    return next(layer for layer in net if isinstance(layer, nn.Linear))


def _hypernetwork(state_dim: int, hidden: int, outputs: int) -> nn.Sequential:
    """Two layers; a small last one, so that the mixing weights start even."""
    last = nn.Linear(hidden, outputs)
    nn.init.normal_(last.weight, std=0.01)
    return nn.Sequential(nn.Linear(state_dim, hidden), nn.ReLU(), last)
