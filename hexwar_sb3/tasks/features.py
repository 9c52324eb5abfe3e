"""One table of features: name, width, scale, source. Widths and the docs' index come from it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Sizes:
    """Widths for one camp of one scenario."""

    obs: int  # Do
    row: int  # Dt
    state: int  # Ds


def sizes(n_own: int, n_enemies: int, n_points: int) -> Sizes:
    """Widths of obs [N, Do], rows [N, K, Dt] and state [Ds]."""
    raise NotImplementedError
