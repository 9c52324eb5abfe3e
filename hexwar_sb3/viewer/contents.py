"""What a page of many games shows before one is opened: an entry a game, the same for all whom a view may know it.

An entry of a camp's view is made of what that camp knows, like its story: no seed, no result, no piece that it never saw.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from typing import Any

from hexwar_sb3.engine.game import Game
from hexwar_sb3.viewer.story import CAMPS, NAME_CHARACTERS, REFEREE
from hexwar_sb3.viewer.tracks import Json

FORMAT = "hexwar-contents"
FORMAT_VERSION = 1
SETUP = (
    "scenario",
    "map",
    "game_ticks",
    "net_score",
    "roster",
    "points",
)  # of a story: the same in many games
_KEY_DIGITS = 16


def key_of(document: Any) -> str:
    """Name of a shared part within a page: equal parts have equal names."""
    text = json.dumps(document, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()[:_KEY_DIGITS]


def shared_parts(story: Json) -> dict[str, Json]:
    """What a page has once for all games that agree in it, by block: `setup-KEY` and `rules-KEY`."""
    setup = {name: story[name] for name in SETUP}
    return {f"setup-{key_of(setup)}": setup, f"rules-{key_of(story['rules'])}": story["rules"]}


def entry_of(told: dict[str, Json], game: Game, name: str, view: str) -> Json:
    """The entry of a game in the contents.

    Args:
        told: its stories by view.
        game: as it ended.
        name: what the page calls it.
        view: whose page it is: "all", "referee", or a camp.
    """
    camps = (view,) if view in CAMPS else CAMPS
    story = told[view] if view in CAMPS else told[REFEREE]
    setup, rules = (block.partition("-")[2] for block in shared_parts(story))
    margins = story["known_margin"] if view in CAMPS else story["margin"]
    return {
        "name": name[:NAME_CHARACTERS],
        "players": story["players"],
        "scenario": story["scenario"],
        "map": story["map"],
        "setup": setup,
        "rules": rules,
        "views": list(told),
        "last": game.tick,
        "margin": {camp: margins[camp][-1] for camp in camps},
        "owners": [point.owner for point in game.view(camps[0]).points],
        "tokens": sorted(_tokens(game, camps)),
        **({} if view in CAMPS else {"seed": story["seed"], "winner": game.outcome}),
    }


def _tokens(game: Game, camps: Sequence[str]) -> Iterator[list[int]]:
    """`[piece, cell]` of the living: the own ones of each camp, and of one camp alone the enemies that it sees, too."""
    hexmap, roster = game.world.scenario.hexmap, game.roster
    for camp in camps:
        view = game.view(camp)
        for piece in view.own:
            if piece.alive and piece.aboard is None:
                yield [roster.index(f"{camp}:{piece.name}"), hexmap.parse_cell(piece.cell)]
        for enemy in view.seen if len(camps) == 1 else ():
            yield [roster.index(enemy.name), hexmap.parse_cell(enemy.cell)]
