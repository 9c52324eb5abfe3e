"""How games are played, whoever plays: one value, from the flags of a command to the folder of a policy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, TypeVar

from hexwar_sb3.checks import check_choice, check_flag, check_whole
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.errors import ConfigError, HexWarError, PolicyFileError, UnknownSettingError, shortened
from hexwar_sb3.maps.scenario import MAX_GAME_TICKS, Scenario, ScenarioLike
from hexwar_sb3.players.player import make_player
from hexwar_sb3.tasks.spots import SPOTS

Settings = TypeVar("Settings")
DECISION_TICKS = 75  # Delta-t of the paper (IV); a setting, not a rule
DECISIONS = ("fixed", "event")
CAMPS_OF = {"red": ("red",), "blue": ("blue",), "both": ("red", "blue")}  # that a side stands for
MAX_DIGITS = 6  # of a number in a policy's folder


def check_scenario(scenario: object) -> None:
    """Check the kind of a scenario; whether it exists is seen when it is loaded.

    Raises:
        ConfigError: it is neither a name, a file nor an object.
    """
    if not isinstance(scenario, str | Path | Scenario):
        raise ConfigError(f"scenario is a name, a file or a Scenario, got {shortened(repr(scenario))}")


@dataclass(frozen=True, kw_only=True)
class Terms:
    """Where games are played, and when and among which tasks policies decide; bots have their own ways.

    Example:
        >>> terms = Terms(scenario="hills", decision_ticks=150)
        >>> terms.env_steps(games=10)
        120
    """

    scenario: ScenarioLike = "plain"  # name, file or object
    decision_ticks: int = DECISION_TICKS  # Delta-t, ticks between two decisions of a policy
    decisions: str = "fixed"  # "event": also after an own loss or an ended task
    # k of G^L(k): cells that tasks lead to beside the control points; of the usual ones as many as there is room for
    spots: int = SPOTS
    fog: bool = True  # False: lights on, for debugging

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            ConfigError: a setting is out of its range.
            UnknownNameError: a choice that does not exist.
        """
        check_scenario(self.scenario)
        check_whole("decision_ticks", self.decision_ticks, least=1, most=MAX_GAME_TICKS)
        check_choice("decisions", self.decisions, DECISIONS)
        check_whole("spots", self.spots, least=0)
        check_flag("fog", self.fog)

    @property
    def settings(self) -> dict[str, Any]:
        """The same as keywords of an env."""
        return {name: getattr(self, name) for name in Terms.__dataclass_fields__}

    def env_steps(self, games: int) -> int:
        """Decisions of a camp in so many games."""
        return games * load_world(self.scenario).scenario.game_ticks // self.decision_ticks

    def games(self, env_steps: int) -> int:
        """Games that so many decisions of a camp make."""
        return env_steps * self.decision_ticks // load_world(self.scenario).scenario.game_ticks

    def about(self) -> dict[str, str]:
        """What a policy's folder says of how it was trained, so that `trained_terms` finds it."""
        said = ("scenario", "decision_ticks", "spots", "decisions")
        return {name: str(getattr(self, name)) for name in said}


USUAL = Terms()


def trained_terms(player: object, usual: Terms = USUAL) -> Terms:
    """How a policy was trained to play, as far as its folder says; the rest as usual.

    Raises:
        PolicyFileError: a value of it is none; and as `make_player`.
    """
    about: Mapping[str, str] = getattr(make_player(player), "about", {})
    told: dict[str, Any] = {name: about[name] for name in ("scenario", "decisions") if name in about}
    if "early" in about:  # how folders of version 0.1 say it
        told["decisions"] = "event" if about["early"] == "yes" else "fixed"
    for name in ("decision_ticks", "spots"):
        if name in about:
            told[name] = _whole(str(player), name, about[name])
    try:
        return replace(usual, **told)
    except HexWarError as error:
        raise PolicyFileError(
            str(player), "about", found=str(error), expected="how it was trained"
        ) from error


def trained_camps(player: object) -> tuple[str, ...]:
    """Camps that a policy was trained to play, as far as its folder says; else both.

    Raises:
        PolicyFileError: it says something else; and as `make_player`.
    """
    side = getattr(make_player(player), "about", {}).get("side", "both")
    if side not in CAMPS_OF:
        raise PolicyFileError(
            str(player), "about.side", found=shortened(repr(side)), expected="red, blue or both"
        )
    return CAMPS_OF[side]


def _whole(folder: str, name: str, text: str) -> int:
    if not text.isdecimal() or len(text) > MAX_DIGITS or int(text) < 1:
        expected = f"a whole number, at least 1, of at most {MAX_DIGITS} digits"
        raise PolicyFileError(folder, f"about.{name}", found=repr(text[:40]), expected=expected)
    return int(text)


def checked_settings(kind: type[Settings], settings: dict[str, Any]) -> Settings:
    """Settings of a kind from keywords.

    Raises:
        UnknownSettingError: it has no such setting.
    """
    known = [field.name for field in fields(kind)]  # type: ignore[arg-type]  # every kind is a dataclass
    for name in settings:
        if name not in known:
            raise UnknownSettingError("setting", name, known)
    return kind(**settings)
