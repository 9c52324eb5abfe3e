"""Every threshold of the scripted players, in one frozen place (bots.md; all of them our choice).

The numbers were tuned by play until the acceptance of bots.md, section 4, was met. They are frozen
with `BOTS_VERSION`; `bots_hash()` goes into every result.
"""

from __future__ import annotations

import hashlib
from dataclasses import astuple, dataclass, field, fields
from pathlib import Path

import numpy as np
from numpy.typing import DTypeLike

from hexwar_sb3.kernels import Rows


@dataclass(frozen=True, kw_only=True)
class Style:
    """How one of the two full players (MA1, MA2) weighs what it sees."""

    threat_weight: float  # points of expected harm at a post against points of expected gain
    post_weight: float  # a post's lasting worth (view of its point, cover) in points
    eta_ticks: float  # ticks of travel that cost one point of a post's worth
    move_gain: float  # points by which a new post must beat the present one
    near_band: int  # nearest and farthest band of posts that vehicles look at
    far_band: int
    enter_ratio: float  # own power over known enemy power from which a piece enters a point
    enter_after: int  # tick from which it enters anyway
    fire_value: float  # expected points from which a piece fires
    ambush_value: float  # the same while it is hidden and nobody near knows of it
    stop_value: float  # expected points for which a piece under way stops
    guide_value: float  # expected points from which a missile is guided
    mortar_value: float  # expected points from which a mortar round is fired
    hunt: int  # 1: posts around known enemies are looked at too
    covered: int  # 1: covered routes
    hide_after: int  # ticks without a known enemy in sight after which a piece hides


ATTACK = Style(
    threat_weight=0.5,
    post_weight=1.0,
    eta_ticks=60.0,
    move_gain=2.0,
    near_band=0,
    far_band=2,
    enter_ratio=0.7,
    enter_after=700,
    fire_value=0.5,
    ambush_value=0.5,
    stop_value=2.5,
    guide_value=1.0,
    mortar_value=1.0,
    hunt=1,
    covered=0,
    hide_after=75,
)

DEFENCE = Style(
    threat_weight=1.0,
    post_weight=1.0,
    eta_ticks=60.0,
    move_gain=3.0,
    near_band=1,
    far_band=3,
    enter_ratio=1.3,
    enter_after=900,
    fire_value=0.5,
    ambush_value=1.5,
    stop_value=2.5,
    guide_value=1.0,
    mortar_value=1.0,
    hunt=0,
    covered=1,
    hide_after=0,
)


@dataclass(frozen=True, kw_only=True)
class BotConfig:
    """Thresholds that all scripted players share, and the styles of the two full ones."""

    think_ticks: int = 75  # regular thoughts
    rethink_ticks: int = 15  # least time between two thoughts
    fire_ticks: int = 5  # a bot in contact looks for shots this often
    trust_ticks: float = 300.0  # age at which a sighting is worth nothing
    guide_share: float = 0.8  # of the guided value: a chariot's own shot that is as good goes first
    endgame_tick: int = 1350
    styles: tuple[Style, Style] = field(default=(ATTACK, DEFENCE))


CONFIG = BotConfig()


def _dtype_of(config: object) -> np.dtype[np.void]:
    """One field a threshold: whole numbers as i4, others as f4, styles as records of their own."""
    names: list[tuple[str, DTypeLike] | tuple[str, DTypeLike, tuple[int, ...]]] = []
    for entry in fields(config):  # type: ignore[arg-type]
        value = getattr(config, entry.name)
        if isinstance(value, tuple):
            names.append((entry.name, _dtype_of(value[0]), (len(value),)))
        else:
            names.append((entry.name, "i4" if isinstance(value, int) else "f4"))
    return np.dtype(names, align=True)


BOT_CONFIG = _dtype_of(CONFIG)


def compiled_config(config: BotConfig = CONFIG) -> Rows:
    """The thresholds as one record, the form that kernels read [1]."""
    return np.array([astuple(config)], BOT_CONFIG).view(np.recarray)


def bots_hash() -> str:
    """Hash of everything that decides what a bot does: thresholds and sources."""
    digest = hashlib.sha256(repr(CONFIG).encode())
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
