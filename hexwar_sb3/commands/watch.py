"""`hexwar watch`: a recorded game as text, picture or page, many games as one page, and their verification."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from hexwar_sb3.commands.exports import Wish, write_export
from hexwar_sb3.commands.output import print_json
from hexwar_sb3.commands.settings import Json
from hexwar_sb3.errors import ConfigError

if TYPE_CHECKING:
    from hexwar_sb3.engine.replay import Replay


FILES = "a replay (*.hwr), several, or the folder of a run, a tournament or a league"
Output = Annotated[
    Path | None,
    tyro.conf.arg(
        aliases=("-o",),
        help="a page to watch the game in (html), a film of a part (gif), a picture of all of it or of one moment"
        " (png, svg, pdf), a camp's own record (hwr), or its events as a table (csv)",
    ),
]
View = Annotated[
    Literal["all", "referee", "red", "blue"],
    tyro.conf.arg(help="whose eyes the file has; a camp's has nothing that it did not know"),
]
At = Annotated[int | None, tyro.conf.arg(help="tick of the moment that is drawn")]
Start = Annotated[int, tyro.conf.arg(name="from", help="first tick of a film")]
Until = Annotated[int | None, tyro.conf.arg(name="to", help="last tick of a film; else the end of the game")]


@dataclass(frozen=True, kw_only=True)
class Watch:
    """Show recorded games; play them again and compare.

    One game as text, picture, film or page. Two or more, or what `hexwar train`, `tournament` or `selfplay` left in a
    folder, as one page: a training's album, a league's heat map, two games side by side.
    """

    files: Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="FILE...", help=FILES)]
    verify: bool = False  # play the game again from its orders and compare every state
    output: Output = None
    view: View = "all"
    at: At = None
    start: Start = 0
    until: Until = None
    jobs: int = 1  # games of a page told side by side
    json: Json = False

    def run(self) -> int:
        """Print what happened, and write what was asked for."""
        from hexwar_sb3.engine.replay import Replay

        wish = Wish(path=self.output, view=self.view, at=self.at, start=self.start, until=self.until)
        if not self.files:
            raise ConfigError("name a replay (*.hwr), or a folder of them")
        if len(self.files) > 1 or self.files[0].is_dir():
            return self._many(wish)
        (file,) = self.files
        replay = Replay.load(file)
        if self.verify:
            replay.verify()
        written = write_export(replay, wish)
        if written:
            print(f"{written}: {self.output}", file=sys.stderr)
        if self.json:
            print_json({"file": str(file), "verified": self.verify, **figures(replay)})
        else:
            lines = [] if written else event_lines(replay)
            print("\n".join([*lines, result_line(replay)]))
            if self.verify:
                print("verified: played again, every state is the same")
        return 0

    def _many(self, wish: Wish) -> int:
        """A line a game, and the page of all."""
        from hexwar_sb3.commands.albums import album_of
        from hexwar_sb3.engine.replay import Replay

        if self.output is not None and self.output.suffix != ".html":
            raise ConfigError(f"{self.output}: several games make a page; name an .html file")
        for flag, text in wish.said().items():
            if flag != "--view" or self.output is None:
                raise ConfigError(f"{text}: found several games; expected it with one of them")
        album, rows = album_of(self.files, self.view), []
        for clip in album.clips:
            replay = Replay.load(clip.path)
            if self.verify:
                replay.verify()
            rows.append({"file": str(clip.path), "verified": self.verify, **figures(replay)})
            if not self.json:
                print(f"{clip.path}: {result_line(replay)}")
        if self.output is not None:
            album.save(self.output, jobs=self.jobs)
            print(f"page: {self.output}", file=sys.stderr)
        if self.json:
            print_json({"title": album.title, "games": rows})
        return 0


def figures(replay: Replay) -> dict[str, Any]:
    """Who played, how it ended, and how often each thing happened."""
    kinds = [event["kind"] for event in replay.events]
    end = {key: value for key, value in replay.end.items() if key != "type"}
    return {
        "players": replay.head.get("players", {}),
        **end,
        "events": {kind: kinds.count(kind) for kind in sorted(set(kinds))},
    }


def event_lines(replay: Replay) -> list[str]:
    """One line an event: tick, who, what, and the rest by name."""
    return [event_line(event) for event in replay.events]


def event_line(event: dict[str, Any]) -> str:
    """Text of one event."""
    rest = {k: v for k, v in event.items() if k not in {"type", "tick", "kind", "piece"} and v is not None}
    words = " ".join(f"{name}={value}" for name, value in rest.items())
    return f"{event['tick']:>5}  {event['piece']:<16} {event['kind']:<14} {words}".rstrip()


def result_line(replay: Replay) -> str:
    """How the game stood at its end."""
    end = replay.end
    margins = ", ".join(f"{camp} {margin:+d}" for camp, margin in end.get("margin", {}).items())
    winner = end.get("winner") or "nobody yet"
    return f"tick {end['tick']}: {winner}; margins {margins}"
