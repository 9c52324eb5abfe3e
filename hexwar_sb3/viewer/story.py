"""A whole replay as stories: change lists at tick precision, made by playing it again (formats/story.md).

Three documents, not three filters: one for each camp of what that camp knew, and the referee's, which has the truth
that neither knew and is read together with the two.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import GameEvent
from hexwar_sb3.engine.record import Line
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.roster import SIDES, camp_name
from hexwar_sb3.engine.world import World
from hexwar_sb3.errors import UnknownNameError
from hexwar_sb3.kernels import Rows
from hexwar_sb3.rules.compiled import NO_POOL
from hexwar_sb3.rules.enums import PieceType, TargetClass, Weapon
from hexwar_sb3.viewer.camp_story import DULL, CampTeller
from hexwar_sb3.viewer.decisions import told_rewards
from hexwar_sb3.viewer.luck import judge_shots
from hexwar_sb3.viewer.map_block import map_key
from hexwar_sb3.viewer.tracks import Changes, Json

FORMAT = "hexwar-story"
FORMAT_VERSION = 1
REFEREE = "referee"
CAMPS = tuple(map(camp_name, SIDES))
VIEWS = (REFEREE, *CAMPS)
NAME_CHARACTERS = 40  # of a player's name, on a page


def stories(replay: Replay, views: Sequence[str] = VIEWS) -> dict[str, Json]:
    """The stories of a game, by view; the game is played again once.

    Args:
        replay: a whole one.
        views: "referee", "red", "blue"; the referee's is read with both others, so they come along.

    Raises:
        UnknownNameError: another view.
        ReplayFileError: it cannot be played again, or is the record of one camp.

    Example:
        >>> game = Game("plain", seed=0)
        >>> events = game.advance(75)
        >>> sorted(stories(Replay.of(game)))
        ['blue', 'red', 'referee']
    """
    for view in views:
        if view not in VIEWS:
            raise UnknownNameError("view", view, VIEWS)
    return Teller(replay).stories(views)


class Teller:
    """Plays a game again and looks on: for the referee, and with the eyes of each camp."""

    game: Game  # as it ended

    def __init__(self, replay: Replay) -> None:
        self.replay = replay
        self.margins = {camp: Changes() for camp in CAMPS}
        self.events: list[Json] = []
        before = None
        for game, events in replay.ticks():
            if before is None:
                self.game = game
                self.camps = {camp: CampTeller(camp, game.roster) for camp in CAMPS}
            self._look(game, events, before)
            before = game.pieces.copy()

    def stories(self, views: Sequence[str]) -> dict[str, Json]:
        """The stories of some views; the referee's comes with both others."""
        common = common_part(self.replay.head.get("players", {}), self.game.world)
        needed = VIEWS if REFEREE in views else views
        return {view: common | self._document(view) for view in VIEWS if view in needed}

    def _look(self, game: Game, events: list[GameEvent], before: Rows | None) -> None:
        new = [teller.look(game, events) for teller in self.camps.values()]
        if any(new):
            for camp, margins in self.margins.items():
                margins.note(game.tick, game.margin(camp))
        if before is not None and events:
            luck = judge_shots(events, before, game.world, game.roster)
            self.events += [
                event.as_dict() | (luck[number].told() if number in luck else {})
                for number, event in enumerate(events)
                if event.kind not in DULL
            ]

    def _document(self, view: str) -> Json:
        """The part of a story that differs from view to view."""
        lines = self.replay.lines[1:]
        if view != REFEREE:
            return self.camps[view].document(lines)
        return {
            "view": REFEREE,
            "with": list(CAMPS),
            "margin": self.margins,
            "events": self.events,
            "end": _end(self.game),
            "seed": str(self.replay.seed),  # beyond the whole numbers of a browser
            **told_rewards(lines),
        }


def _end(game: Game) -> Json:
    margins = {camp: game.margin(camp) for camp in CAMPS}
    return {"tick": game.tick, "over": game.over, "margin": margins, "winner": game.outcome}


def common_part(players: Mapping[str, Line], world: World) -> Json:
    """What is the same in every view: all of it stands in the head, or in the rules.

    players: by camp their `name` and `kind`.
    """
    scenario = world.scenario
    return {
        "format": FORMAT,
        "version": FORMAT_VERSION,
        "scenario": scenario.name[:NAME_CHARACTERS],
        "map": map_key(scenario.hexmap),
        "game_ticks": scenario.game_ticks,
        "net_score": scenario.net_score,
        "players": {camp: _player(players.get(camp, {})) for camp in CAMPS},
        "roster": [[name, piece.kind.name.lower()] for name, piece in _named(world)],
        "points": [[point.name[:NAME_CHARACTERS], point.cell, point.value] for point in scenario.points],
        "rules": rules_block(world),
    }


def _named(world: World) -> list[tuple[str, Any]]:
    return [(str(piece), piece) for piece in world.scenario.pieces]


def _player(player: Line) -> Json:
    return {"name": player.get("name", "unknown")[:NAME_CHARACTERS], "kind": player.get("kind", "")}


def rules_block(world: World) -> Json:
    """The numbers of the rules that a page draws with."""
    rules = world.rules[0]
    names = (
        "air_height_m",
        "hidden_sight_divisor",
        "concealed_sight_divisor",
        "observer_cells",
        "flight_ticks",
    )
    return {
        "version": world.ruleset.version,
        **{name: int(rules[name]) for name in names},
        "kinds": {kind.name.lower(): _kind(kind, world) for kind in PieceType},
    }


def _kind(kind: PieceType, world: World) -> Json:
    rules = world.rules[0]
    return {
        "value": int(rules.value[kind]),
        "blood": int(rules.blood[kind]),
        "hop_ticks": int(rules.base_hop[kind]),
        "sight": {other.name.lower(): int(rules.sight[kind, other]) for other in PieceType},
        "weapons": [_weapon(weapon, world) for weapon in Weapon if rules.pool[kind, weapon] != NO_POOL],
    }


def _weapon(weapon: Weapon, world: World) -> list[object]:
    """[name, reach in cells against each class of targets]; a mortar reaches cells, whoever is there."""
    rules = world.rules[0]
    if weapon == Weapon.MORTAR:
        reach = [int(rules.mortar_max_cells)] * 2 + [0]
    else:
        levels = rules.level[weapon].max(axis=1)  # [class, distance], at the most blood
        reach = [int(np.flatnonzero(levels[kind]).max(initial=0)) for kind in TargetClass]
    return [weapon.name, *reach]
