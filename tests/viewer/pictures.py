"""The six pictures of docs/watch.md, of games that are played for them.

`python -m tests.viewer.pictures runs/commander_1` (`make pictures`) makes them anew; look at each of them. The game is one of
CAI against HRL0, the round robin one of Table I's players, the album that of the run, one of `hexwar train`.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

from PIL import Image

from hexwar_sb3.cli import main as hexwar
from hexwar_sb3.commands.albums import album_of
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.play import record_game
from hexwar_sb3.viewer.page import save_page
from tests.viewer.states import states

ROOT = Path(__file__).parents[2]
TABLE1 = ROOT / "results" / "table1" / "policies"
WORK = ROOT / "build" / "pictures"
PICTURES = ROOT / "docs" / "watch"
SEED, EPISODE, GAMES = 0, 5, 100  # a game with ghosts
KEPT = ("CAI", "HRL2")  # policies of Table I that meet HRL0 and the scripted players
OTHERS = ("HRL0", "MA1", "MA2")
COLOURS, MOST_BYTES = 256, 250_000
# of camps, their texts, suppression, bursts, ink and papers: viewer/src/palette.ts, light
KEPT_COLOURS = (
    "c22513",
    "1b58b8",
    "6f756c",
    "b3200f",
    "174d9f",
    "e89a08",
    "ffc428",
    "1d232b",
    "ffffff",
    "f2f4f6",
    "e8ecf1",
    "5b6470",
    "e5b84f",  # a burst that fades
)


def make_pages(run: Path) -> list[dict[str, object]]:
    """Play the games, write the pages, and say in which states they are shown."""
    WORK.mkdir(parents=True, exist_ok=True)
    pages = {name: WORK / f"{name}.html" for name in ("game", "album")}
    replay = record_game(
        str(TABLE1 / "CAI" / "both"), "HRL0", seed=SEED, episode=EPISODE, names=("CAI", "HRL0")
    )
    save_page(replay, pages["game"])
    album_of([run]).save(pages["album"])
    cup = WORK / "cup"
    players = [f"{name}={TABLE1 / name / 'both'}" for name in KEPT]
    try:
        hexwar(("tournament", *players, *OTHERS, "--games", str(GAMES), "--output", str(cup)))
    except SystemExit as end:
        if end.code:
            raise
    return states(replay, {**pages, "league": cup / "league.html"})


def reduce_colours(path: Path) -> None:
    """Make a picture small: a palette of its own, in which the few dots of pieces and texts keep their colours."""
    image = Image.open(path).convert("RGB")
    usual = image.quantize(COLOURS - len(KEPT_COLOURS), Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    colours = [*(usual.getpalette() or [])[: 3 * (COLOURS - len(KEPT_COLOURS))]]
    palette = Image.new("P", (1, 1))
    palette.putpalette([*colours, *(part for colour in KEPT_COLOURS for part in bytes.fromhex(colour))])
    image.quantize(palette=palette, dither=Image.Dither.NONE).save(path, optimize=True)
    if path.stat().st_size > MOST_BYTES:
        raise ConfigError(f"{path}: {path.stat().st_size} bytes; at most {MOST_BYTES}")


def main(run: str) -> int:
    """Make the pictures; the exit status is that of the browser."""
    if not (Path(run) / "snapshots").is_dir():
        raise ConfigError(
            f"{run}: no training; `make train` makes one, or name it: make pictures RUN=runs/NAME"
        )
    told = WORK / "states.json"
    found = make_pages(Path(run))
    told.write_text(json.dumps(found))
    PICTURES.mkdir(exist_ok=True)
    status = subprocess.run(
        ["node", "e2e/states.mjs", str(told), str(PICTURES)],
        cwd=ROOT / "viewer",
        env=dict(os.environ),
        check=False,
    ).returncode
    for state in found:
        reduce_colours(PICTURES / f"{state['name']}.png")
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
