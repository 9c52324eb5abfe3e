"""How commands print: tables for people, one JSON object for programs."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from math import isfinite
from typing import TYPE_CHECKING, Any

from tqdm import tqdm

if TYPE_CHECKING:
    from hexwar_sb3.maps.scenario import ScenarioLike

COUNTS = ("games", "won/drawn/lost", "win rate, %", "mean margin", "points held")


@contextmanager
def games_bar(games: int) -> Iterator[Callable[[int], object]]:
    """Show a bar of games played on a terminal; give what moves it on by a number of games."""
    with tqdm(total=games, unit="game", dynamic_ncols=True, leave=False, disable=None) as bar:
        yield bar.update


def compile_first(*players: str, scenario: ScenarioLike = "plain") -> None:
    """Compile the game unless that was done before, and say so: it takes a while and shows nothing else.

    Args:
        players: names or folders that are to play; a wrong one is met before the wait.
        scenario: likewise.
    """
    from hexwar_sb3.engine.world import load_world
    from hexwar_sb3.envs.prepare import prepare
    from hexwar_sb3.players.player import make_player

    load_world(scenario)
    for player in players:
        make_player(player)
    prepare(partial(print, file=sys.stderr, flush=True))


def typed() -> str:
    """The command that runs, as one would type it."""
    return "".join(one if one.isprintable() else "?" for one in shlex.join(["hexwar", *sys.argv[1:]]))


def print_json(values: Mapping[str, object]) -> None:
    """Print one JSON object."""
    print(as_json(values))


def as_json(values: object) -> str:
    """Write JSON as everybody reads it: numbers that are not finite, which it has not, are null."""
    return json.dumps(_finite(values), indent=2, default=str, allow_nan=False)


def _finite(value: object) -> object:
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: _finite(one) for key, one in value.items()}
    return [_finite(one) for one in value] if isinstance(value, list | tuple) else value


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Lay out rows of text under their heads, columns padded to their widest cell."""
    widths = [max(len(row[i]) for row in [heads, *rows]) for i in range(len(heads))]
    lines = [heads, ["-" * width for width in widths], *rows]
    return "\n".join(
        "  ".join(f"{cell:<{w}}" for cell, w in zip(line, widths, strict=True)).rstrip() for line in lines
    )


def panel_table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Lay out the rows of panels (`Panel.summary`): one a player, opponent and camp."""
    cells = [[row["player"], row["opponent"], row["camp"], *result_cells(row)] for row in rows]
    return table(("player", "opponent", "camp", *COUNTS), cells)


def result_cells(row: Mapping[str, Any]) -> list[str]:
    """Cells of a result (`CampResult.summary`), in the order of COUNTS."""
    low, high = row["win_rate_interval"]
    least, most = row["mean_margin_interval"]
    return [
        str(row["games"]),
        f"{row['wins']}/{row['draws']}/{row['losses']}",
        f"{100 * row['win_rate']:.1f} [{100 * low:.1f}, {100 * high:.1f}]",
        f"{row['mean_margin']:+.1f} [{least:+.1f}, {most:+.1f}]",
        ", ".join(f"{n}: {share:.0%}" for n, share in enumerate(row["points_held"])),
    ]
