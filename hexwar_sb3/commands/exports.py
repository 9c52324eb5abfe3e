"""What `hexwar watch FILE -o NAME` writes: the ending of the name says the kind, and each kind has its own wishes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from hexwar_sb3.errors import ConfigError

if TYPE_CHECKING:
    from hexwar_sb3.engine.replay import Replay

ALL, REFEREE = "all", "referee"  # views that are no camp's


@dataclass(frozen=True, kw_only=True)
class Wish:
    """What is to be written, as it was typed."""

    path: Path | None = None
    view: str = ALL
    at: int | None = None
    start: int = 0
    until: int | None = None

    @property
    def eyes(self) -> str:
        """Whose eyes a file has that has one pair only."""
        return REFEREE if self.view == ALL else self.view

    def said(self) -> dict[str, str]:
        """The settings that were given, as one would type them, by flag."""
        view = None if self.view == ALL else self.view
        values = {"--view": view, "--at": self.at, "--from": self.start or None, "--to": self.until}
        return {flag: f"{flag} {value}" for flag, value in values.items() if value is not None}


class Kind(NamedTuple):
    """A kind of file."""

    word: str
    endings: tuple[str, ...]
    takes: frozenset[str]  # flags
    write: Callable[[Replay, Path, Wish], None]


def write_export(replay: Replay, wish: Wish) -> str:
    """Write what was asked for, whole or not at all, and say what it is; an empty text where no file is asked for.

    Raises:
        ConfigError: the name's ending is of no kind, or the settings do not go with it.
        ReplayFileError: the replay is the record of one camp, and the kind needs a whole one.
    """
    if wish.path is None:
        if wish.said():
            raise ConfigError(f"{' '.join(wish.said().values())}: found no file to write; expected -o NAME")
        return ""
    kind = _kind_of(wish.path)
    _check_settings(wish, kind)
    kind.write(replay, wish.path, wish)
    return kind.word


def _kind_of(path: Path) -> Kind:
    for kind in KINDS:
        if path.suffix in kind.endings:
            return kind
    endings = ", ".join(ending for kind in KINDS for ending in kind.endings)
    raise ConfigError(f"{path}: found a name of no kind; expected one that ends in {endings}")


def _check_settings(wish: Wish, kind: Kind) -> None:
    for flag, text in wish.said().items():
        if flag not in kind.takes:
            endings = ", ".join(one for other in KINDS if flag in other.takes for one in other.endings)
            raise ConfigError(f"{text}: found -o {wish.path}; expected a name that ends in {endings}")


def _write_page(replay: Replay, path: Path, wish: Wish) -> None:
    from hexwar_sb3.viewer import save_page

    save_page(replay, path, wish.view)


def _write_film(replay: Replay, path: Path, wish: Wish) -> None:
    from hexwar_sb3.viewer import save_gif

    save_gif(replay, path, wish.start, wish.until, wish.eyes)


def _write_record(replay: Replay, path: Path, wish: Wish) -> None:
    if wish.eyes == REFEREE:
        raise ConfigError(
            f"{path}: found --view {wish.view}; expected --view red or blue, whose own record it is"
        )
    if path.exists() and path.samefile(replay.source):
        raise ConfigError(f"{path}: found the file that is read; expected another name")
    replay.for_camp(wish.view).save(path)


def _write_events(replay: Replay, path: Path, wish: Wish) -> None:
    from hexwar_sb3.viewer import save_events

    save_events(replay, path, replay.camp if replay.camp and wish.view == ALL else wish.eyes)


def _write_picture(replay: Replay, path: Path, wish: Wish) -> None:
    from hexwar_sb3.engine.picture import save_game_picture
    from hexwar_sb3.viewer import save_moment

    if wish.at is not None:
        save_moment(replay, path, wish.at, wish.eyes)
    elif wish.view == ALL:
        save_game_picture(replay, path)
    else:
        found = f"--view {wish.view}: found no --at"
        raise ConfigError(f"{found}; expected --at TICK: only the picture of one moment has views")


KINDS = (
    Kind("page", (".html",), frozenset({"--view"}), _write_page),
    Kind("film", (".gif",), frozenset({"--view", "--from", "--to"}), _write_film),
    Kind("record", (".hwr",), frozenset({"--view"}), _write_record),
    Kind("events", (".csv",), frozenset({"--view"}), _write_events),
    Kind("picture", (".png", ".svg", ".pdf"), frozenset({"--view", "--at"}), _write_picture),
)
