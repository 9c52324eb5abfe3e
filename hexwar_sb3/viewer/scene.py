"""What is drawn of a moment: points, pieces and fire, as the referee sees them or as one camp knows them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import NamedTuple

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import GameEvent
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.engine.roster import Roster
from hexwar_sb3.engine.view import LostEnemy, OwnPiece, PointView, SeenEnemy, SideView
from hexwar_sb3.errors import UnknownNameError
from hexwar_sb3.kernels import Rows
from hexwar_sb3.viewer.luck import SHOTS
from hexwar_sb3.viewer.story import CAMPS, NAME_CHARACTERS, REFEREE, VIEWS

SHOT_TICKS = 8  # that a shot stays in the picture
DEATH_TICKS = 45  # that the place of a death is marked


class Token(NamedTuple):
    """A piece in the picture."""

    camp: str
    cell: int
    text: str  # letter of its type, and vehicles or squads left
    is_ghost: bool = False  # an enemy where it was seen last


class Shot(NamedTuple):
    """One shot from cell to cell."""

    tick: int
    camp: str
    start: int
    end: int
    with_loss: bool


class Death(NamedTuple):
    """Where a piece was destroyed."""

    tick: int
    camp: str
    cell: int


class Scene(NamedTuple):
    """One moment of a game, for one pair of eyes."""

    tick: int
    points: tuple[PointView, ...]
    tokens: tuple[Token, ...]
    margins: Mapping[str, int]  # true ones by camp; in a camp's scene what it knew of its own
    shots: tuple[Shot, ...] = ()
    deaths: tuple[Death, ...] = ()


def scene_of(game: Game, camp: str | None = None) -> Scene:
    """A game as it stands, without fire: all of it, or what a camp knows."""
    if camp is None:
        views = [game.view(name) for name in CAMPS]
        tokens = [token for view in views for token in _own_tokens(view)]
        margins = {name: game.margin(name) for name in CAMPS}
    else:
        views = [game.view(camp)]
        tokens = [*_own_tokens(views[0]), *_enemy_tokens(views[0])]
        margins = {camp: views[0].known_margin}
    return Scene(game.tick, views[0].points, tuple(tokens), margins)


def scenes(
    replay: Replay, ticks: Collection[int], view: str = REFEREE, shot_ticks: int = SHOT_TICKS
) -> Iterator[Scene]:
    """Play a game again and look at it at some ticks.

    Args:
        replay: a whole one.
        ticks: of the game, in any order; the scenes come in the order of the game.
        view: "referee", or a camp: then only what it knew is there, and no fire.
        shot_ticks: that a shot stays.

    Raises:
        UnknownNameError: another view.
    """
    if view not in VIEWS:
        raise UnknownNameError("view", view, VIEWS)
    camp, last, fire = None if view == REFEREE else view, max(ticks), _Fire()
    for game, events in replay.ticks():
        if camp is None:
            fire.note(events, game)
        if game.tick in ticks:
            yield fire.put_on(scene_of(game, camp), shot_ticks)
        if game.tick >= last:
            return


class _Fire:
    """Shots and deaths so far."""

    def __init__(self) -> None:
        self.shots: list[Shot] = []
        self.deaths: list[Death] = []
        self._before: Rows | None = None  # pieces in the state before

    def note(self, events: Iterable[GameEvent], game: Game) -> None:
        """The events that led to the present state."""
        if self._before is not None:
            for event in events:
                self._note_one(event, game.roster, self._before)
        self._before = game.pieces.copy()

    def _note_one(self, event: GameEvent, roster: Roster, before: Rows) -> None:
        if event.cell is None:
            return
        camp, cell = event.piece.split(":")[0], roster.cell(event.cell)
        if event.kind in SHOTS:
            shooter = before[roster.index(event.shooter or event.piece)]
            self.shots.append(Shot(event.tick, camp, int(shooter.cell), cell, (event.result or 0) > 0))
        elif event.kind == "dead":
            self.deaths.append(Death(event.tick, camp, cell))

    def put_on(self, scene: Scene, shot_ticks: int) -> Scene:
        """The scene with the shots of the last ticks, and with the latest deaths."""
        shots = [shot for shot in self.shots if shot.tick > scene.tick - shot_ticks]
        deaths = [death for death in self.deaths if death.tick > scene.tick - DEATH_TICKS]
        return scene._replace(shots=tuple(shots), deaths=tuple(deaths))


def fanned(tokens: Iterable[Token]) -> Iterator[tuple[Token, float]]:
    """Each piece with its place in the row of those that share its cell, 0 in the middle."""
    by_cell: dict[int, list[Token]] = {}
    for token in tokens:
        by_cell.setdefault(token.cell, []).append(token)
    for row in by_cell.values():
        for number, token in enumerate(row):
            yield token, number - (len(row) - 1) / 2


def names_of(replay: Replay) -> dict[str, str]:
    """Who played, by camp; a long name is cut."""
    players = replay.head.get("players", {})
    return {camp: players.get(camp, {}).get("name", "unknown")[:NAME_CHARACTERS] for camp in CAMPS}


def origin_of(replay: Replay, view: str = REFEREE) -> str:
    """What a file says of its game: "MA1 against MA2, plain, rules 1.0, seed 3"; of a camp's view no seed."""
    return f"{title_of(replay)}, seed {replay.seed}" if view == REFEREE else title_of(replay)


def title_of(replay: Replay) -> str:
    """The same for people, who read no seed."""
    names, head = " against ".join(names_of(replay).values()), replay.head
    return f"{names}, {head['scenario']['name'][:NAME_CHARACTERS]}, rules {head['rules']['version']}"


def _own_tokens(view: SideView) -> list[Token]:
    there = [piece for piece in view.own if piece.alive and piece.aboard is None]
    return [_token(view, view.camp, piece) for piece in there]


def _enemy_tokens(view: SideView) -> list[Token]:
    """Enemies in sight, and those that are out of it, where they were seen last."""
    (camp,) = set(CAMPS) - {view.camp}
    lost = [_token(view, camp, enemy) for enemy in view.lost if enemy.blood > 0]
    return [_token(view, camp, enemy) for enemy in view.seen] + [one._replace(is_ghost=True) for one in lost]


def _token(view: SideView, camp: str, piece: OwnPiece | SeenEnemy | LostEnemy) -> Token:
    return Token(camp, view.hexmap.parse_cell(piece.cell), f"{piece.kind[0].upper()}{piece.blood}")
