"""Mixers: from each piece's Q to the camp's (Fig. 5, III-C), all behind one interface."""

from __future__ import annotations

from abc import abstractmethod

import torch
from jaxtyping import Float
from torch import Tensor, nn


class Mixer(nn.Module):
    """Turns the pieces' chosen Q into the values that are trained: one for the camp, or one a piece."""

    def __init__(self, n_pieces: int, state_dim: int) -> None:
        super().__init__()
        self.n_pieces, self.state_dim = n_pieces, state_dim

    def forward(
        self,
        agent_q: Float[Tensor, "batch piece"],
        state: Float[Tensor, "batch state"],
        alive: Float[Tensor, "batch piece"],
    ) -> Float[Tensor, "batch value"]:
        """Mix; the dead count nothing.

        Args:
            agent_q: Q_i of the chosen task of each piece, in scaled points [B, N].
            state: the whole state, which only the mixer sees [B, Ds].
            alive: 1 for a living piece, else 0 [B, N].
        """
        return self.mix(agent_q * alive, state)

    @abstractmethod
    def mix(
        self, agent_q: Float[Tensor, "batch piece"], state: Float[Tensor, "batch state"]
    ) -> Float[Tensor, "batch value"]:
        """Mix the Q of the living."""

    def state_layers(self) -> list[nn.Linear]:
        """Layers that read the state."""
        return []

    def weights(self, alive: Float[Tensor, "batch piece"]) -> Float[Tensor, "batch value"]:
        """Weight of each trained value in the loss."""
        return torch.ones_like(alive[:, :1])


class MonotonicMixer(Mixer):
    """Mix Q_i into Q_Σ so that dQ_Σ/dQ_i >= 0 (Fig. 5; Rashid et al. 2018): "qmix"."""

    def __init__(self, n_pieces: int, state_dim: int, embed: int = 32, hidden: int = 64) -> None:
        super().__init__(n_pieces, state_dim)
        self.embed = embed
        self.hyper_w1 = _hypernetwork(state_dim, hidden, n_pieces * embed)
        self.hyper_b1 = nn.Linear(state_dim, embed)
        self.hyper_w2 = _hypernetwork(state_dim, hidden, embed)
        self.hyper_b2 = _hypernetwork(state_dim, embed, 1)  # V(s)

    def mix(
        self, agent_q: Float[Tensor, "batch piece"], state: Float[Tensor, "batch state"]
    ) -> Float[Tensor, "batch 1"]:
        """Q_Σ of each game."""
        w1 = self.hyper_w1(state).abs().view(-1, self.n_pieces, self.embed)  # >= 0
        w2 = self.hyper_w2(state).abs()  # >= 0
        hidden = nn.functional.elu(torch.einsum("bn,bne->be", agent_q, w1) + self.hyper_b1(state))
        return (hidden * w2).sum(dim=1, keepdim=True) + self.hyper_b2(state)

    def state_layers(self) -> list[nn.Linear]:
        """First layers of the hypernetworks."""
        nets = (self.hyper_w1, self.hyper_w2, self.hyper_b2)
        return [self.hyper_b1, *(net[0] for net in nets if isinstance(net[0], nn.Linear))]


class SumMixer(Mixer):
    """Q_Σ = Σ Q_i (value decomposition, Sunehag et al. 2018): "vdn"."""

    def mix(
        self, agent_q: Float[Tensor, "batch piece"], state: Float[Tensor, "batch state"]
    ) -> Float[Tensor, "batch 1"]:
        """Q_Σ of each game."""
        return agent_q.sum(dim=1, keepdim=True)


class IndependentMixer(Mixer):
    """No mixing: every piece learns the camp's reward for itself: "iql"."""

    def mix(
        self, agent_q: Float[Tensor, "batch piece"], state: Float[Tensor, "batch state"]
    ) -> Float[Tensor, "batch piece"]:
        """Q_i of each piece."""
        return agent_q

    def weights(self, alive: Float[Tensor, "batch piece"]) -> Float[Tensor, "batch piece"]:
        """The living share a weight of 1 a game."""
        return alive / alive.sum(dim=1, keepdim=True).clamp(min=1.0)


MIXERS: dict[str, type[Mixer]] = {"qmix": MonotonicMixer, "vdn": SumMixer, "iql": IndependentMixer}


def _hypernetwork(state_dim: int, hidden: int, outputs: int) -> nn.Sequential:
    """Two layers; a small last one, so that the mixing weights start even."""
    last = nn.Linear(hidden, outputs)
    nn.init.normal_(last.weight, std=0.01)
    return nn.Sequential(nn.Linear(state_dim, hidden), nn.ReLU(), last)
