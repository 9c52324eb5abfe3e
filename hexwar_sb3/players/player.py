"""Who can play a camp: a compiled bot, a policy folder, or any object that acts or predicts."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import dataclass, field
from numbers import Real
from pathlib import Path
from typing import Any, Protocol, TypeAlias, cast, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hexwar_sb3.bots.registry import BOTS, as_member, is_bot
from hexwar_sb3.errors import ConfigError, PolicyFileError, UnknownNameError, shortened
from hexwar_sb3.players.flat import FlatPlayer, is_flat, predicted
from hexwar_sb3.players.frozen import FrozenPolicy
from hexwar_sb3.players.frozen_lower import HEURISTIC_LOWER, Lower
from hexwar_sb3.players.policy_file import SUFFIX, load_policy_file
from hexwar_sb3.rules.ruleset import default_rules

Observation: TypeAlias = Mapping[str, NDArray[Any]]
Actions: TypeAlias = NDArray[np.int64]

POLICY_FILE = "config.json"  # marks a policy folder
POLICIES = {path.name: path for path in sorted(Path(__file__).with_name("builtin").iterdir())}
"""Trained policies that are part of the program, by name: HRL0 is the best warm-up of table 1, for both camps."""
_OPPONENT_STREAM = 1  # keeps the draw of opponents apart from every other draw of an episode
_SIDES = ("red", "blue", "both")  # names of folders that a league's players have their policies in


@runtime_checkable
class Player(Protocol):
    """Picks a task for every piece of a camp, for many games at once.

    Two attributes may say who leads the pieces on their way, if not the heuristic: `lower`, a lower level;
    or `answers` [games, pieces] beside the last tasks, 0 stay and perform or 1 + a direction in the camp's
    frame, which each piece keeps until it is illegal or the next decision (`FlatPlayer`).
    """

    def reset(self) -> None:
        """Forget everything: new games begin."""

    def act(self, obs: Observation) -> Actions:
        """Pick task indices [games, pieces] from a batch of observations [games, ...]."""


@dataclass(frozen=True)
class BotPlayer:
    """A scripted player; it runs compiled inside the drive loop, with any number of games."""

    name: str
    bot: int  # its id in the drive loop
    member: int = 0  # of a family; 0: each game's seed draws one


@dataclass(frozen=True)
class ModelPlayer:
    """Any object with Stable-Baselines3's `predict`, playing greedily."""

    model: Any
    led_by: Lower | None = None  # who leads its pieces, if not its own lower level

    @property
    def lower(self) -> Lower:
        """The lower level that was given, or the model's own, if it has one."""
        if self.led_by is not None:
            return self.led_by
        return cast("Lower", getattr(getattr(self.model, "policy", None), "lower", HEURISTIC_LOWER))

    def reset(self) -> None:
        """Nothing to forget: recurrent models are not supported."""

    def act(self, obs: Observation) -> Actions:
        """Ask the model; one that takes `action_masks` (MaskablePPO) gets them."""
        masks = {}
        if "action_masks" in inspect.signature(self.model.predict).parameters:
            mask = obs["action_mask"]
            masks["action_masks"] = mask.reshape(len(mask), -1)
        return cast("Actions", predicted(self.model, dict(obs), **masks))


@dataclass(frozen=True)
class ActingPlayer:
    """Any object with `act(obs)` and nothing to reset."""

    actor: Any

    def reset(self) -> None:
        """Nothing to forget."""

    def act(self, obs: Observation) -> Actions:
        """Ask the object."""
        return cast("Actions", self.actor.act(obs))


Seat: TypeAlias = BotPlayer | Player


def make_player(player: object) -> Seat:
    """Make a player of a bot's or a built-in policy's name, a policy (folder, file, run folder), or an object that plays.

    A model that observes one vector is one of the flat env.

    Raises:
        UnknownNameError: neither a bot nor a policy nor a folder has this name.
        PolicyFileError: the folder is broken, or was trained under other rules.
        ConfigError: the object cannot play.

    Example:
        >>> make_player("MA1").name
        'MA1'
    """
    if isinstance(player, str | Path):
        return _named_player(player)
    if inspect.isclass(player):
        raise ConfigError(
            f"a player is an object: got the class {player.__name__}, perhaps for {player.__name__}()"
        )
    if isinstance(player, BotPlayer | Player):
        return player
    if callable(getattr(player, "act", None)):
        return ActingPlayer(player)
    if callable(getattr(player, "predict", None)):
        return FlatPlayer(player) if is_flat(player) else ModelPlayer(player)
    raise ConfigError(f"a player is a name, a folder, or has act() or predict(); got {player!r}")


def bot_player(bot: str, member: int = 0) -> BotPlayer:
    """The scripted player of a name; of a family one member, or (0) another in each game."""
    return BotPlayer(f"{bot}:{member}" if member else bot, BOTS[bot].id, member)


def _named_player(name: str | Path) -> Seat:
    bot, member = as_member(str(name))
    if is_bot(name):
        return bot_player(bot, member)
    folder = POLICIES.get(str(name), Path(name))
    for place in (folder / "policy", folder):
        if (place / POLICY_FILE).is_file():
            return FrozenPolicy.load(place, rules=default_rules().hash)
    if folder.suffix == SUFFIX and folder.is_file():
        return load_policy_file(folder, rules=default_rules().hash)
    if folder.exists():
        expected = f"a policy folder, a run folder with policy/ in it, or a policy as one file (*{SUFFIX})"
        raise PolicyFileError(folder, POLICY_FILE, found="nothing", expected=expected)
    raise UnknownNameError("player", str(name), (*BOTS, *POLICIES))


def seat_name(seat: Seat) -> str:
    """What messages call a player: a bot's name, or the type of what plays."""
    if isinstance(seat, BotPlayer):
        return seat.name
    inner = seat.model if isinstance(seat, ModelPlayer | FlatPlayer) else getattr(seat, "actor", seat)
    return type(inner).__name__


def same_player(one: Seat, other: Seat) -> bool:
    """Whether two seats hold the same player: a policy that was loaded twice is one."""
    if isinstance(one, FrozenPolicy) and isinstance(other, FrozenPolicy):
        return one is other or one.sha256 == other.sha256
    return one is other or bool(one == other)


def has_played(player: Seat, who: Seat) -> bool:
    """Whether it was this player, or a member of this family, that played."""
    if isinstance(player, BotPlayer) and isinstance(who, BotPlayer):
        return player.bot == who.bot and player.member in (0, who.member)
    return same_player(player, who)


def member_of(player: Seat, who: Seat) -> int:
    """Number of the member that played for a family; 0: the player is none."""
    of_family = isinstance(player, BotPlayer) and player.member == 0
    return who.member if of_family and isinstance(who, BotPlayer) else 0


def given_name(player: object) -> str | None:
    """The name under which a player was given, or its folder's, as "CAI/both" where that is a camp's; None for an object."""
    if not isinstance(player, str | Path):
        return None
    path = Path(player)
    return "/".join(path.parts[-2:]) if path.name in _SIDES else path.name


@dataclass(frozen=True)
class Mixture:
    """Opponents with weights; each episode draws one of them by its number alone."""

    players: tuple[Seat, ...]
    weights: tuple[float, ...]
    names: tuple[str | None, ...] = field(default=(), compare=False)  # under which they were given, if any

    def __post_init__(self) -> None:
        weights = np.asarray(self.weights, dtype=np.float64)
        if not self.players or not (weights >= 0).all() or not 0 < sum(self.weights) < np.inf:
            raise ConfigError(
                f"opponents need finite weights >= 0 with a positive sum, got {shortened(str(self.weights))}"
            )

    def draw(self, seed: int, episode: int, urgency: float | NDArray[np.float64] = 1.0) -> int:
        """Index of the opponent of an episode; `urgency` [n] is a further factor of the weights."""
        if len(self.players) == 1:
            return 0
        ends = (np.asarray(self.weights, np.float64) * urgency).cumsum()
        point = np.random.default_rng([seed, episode, _OPPONENT_STREAM]).random()
        return int(np.searchsorted(ends / ends[-1], point, side="right"))


def make_mixture(opponent: object) -> Mixture:
    """One opponent, a list of them (equal weights), or a list of (opponent, weight).

    Raises:
        ConfigError: there is none, a weight is no number or out of its range; and as `make_player`.

    Example:
        >>> make_mixture([("MA1", 3), ("MA2", 1)]).weights
        (3.0, 1.0)
    """
    entries = opponent if isinstance(opponent, list | tuple) else [opponent]
    pairs = [with_weight(one) for one in entries]
    return Mixture(
        tuple(make_player(one) for one, _ in pairs),
        tuple(weight for _, weight in pairs),
        tuple(given_name(one) for one, _ in pairs),
    )


def with_weight(entry: object) -> tuple[object, float]:
    """An opponent and its weight: 1 where none is given.

    Raises:
        ConfigError: it is neither a player nor (player, weight).
    """
    if not isinstance(entry, list | tuple):
        return entry, 1.0
    if len(entry) != 2 or isinstance(entry[1], bool) or not isinstance(entry[1], Real):
        raise ConfigError(f"an opponent is a player or (player, weight), got {shortened(repr(entry))}")
    return entry[0], float(entry[1])
