"""Boards as text: small games for tests and bug reports, and any game printed.

One line a thing, words separated by blanks:

    map      plain-5x5                       an open, flat map of 5 by 5 cells
    cell     0303 0304 elev 40 concealed     also slushy, paved, blocked
    point    main 0303 80 red                a control point; its owner may be left out
    red      chariot 0101 moving 0102 0103   pieces are numbered by type: chariot0, chariot1
    blue     soldier aboard chariot0
    ticks    1800
    seed     7

After its cell a piece may have: moving CELLS..., stopping, stopped (a forced stop), hidden,
suppressed, blood N, cool N, mortar_cool N, ammo WEAPON N.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from hexwar_sb3.engine.edit import Change
from hexwar_sb3.engine.orders import did_you_mean
from hexwar_sb3.engine.roster import SIDES, camp_name
from hexwar_sb3.engine.score import margin
from hexwar_sb3.engine.state import State
from hexwar_sb3.engine.view import OwnPiece, PointView, side_view
from hexwar_sb3.engine.world import World
from hexwar_sb3.errors import ConfigError
from hexwar_sb3.maps.geometry import playable_mask
from hexwar_sb3.maps.hexmap import LAYERS, HexMap
from hexwar_sb3.maps.scenario import ControlPoint, PieceStart, Scenario
from hexwar_sb3.rules import default_rules
from hexwar_sb3.rules.enums import Camp, PieceType

BOARD_GRADE_M = 10
_MAP_NAME = re.compile(r"plain-([0-9]{1,3})x([0-9]{1,3})")
_KINDS = {kind.name.lower(): kind for kind in PieceType}


@dataclass
class Board:
    """A board as read: a scenario, the changes that make it the position, and the seed."""

    hexmap: HexMap | None = None
    pieces: list[PieceStart] = field(default_factory=list)
    points: list[ControlPoint] = field(default_factory=list)
    changes: list[Change] = field(default_factory=list)
    game_ticks: int = default_rules().number("game_ticks")
    net_score: bool = False
    seed: int = 0

    @property
    def scenario(self) -> Scenario:
        """The start of the game; the changes come on top of it."""
        return Scenario(
            name="board",
            hexmap=self.map,
            pieces=tuple(sorted(self.pieces, key=lambda piece: piece.camp)),
            points=tuple(self.points),
            game_ticks=self.game_ticks,
            net_score=self.net_score,
        )

    @property
    def map(self) -> HexMap:
        """The map, which must come before everything that lies on it."""
        if self.hexmap is None:
            raise ConfigError("expected a line 'map plain-5x5' first")
        return self.hexmap


def parse_board(text: str) -> Board:
    """Read a board.

    Raises:
        ConfigError: names the line, what was found and what was expected.
    """
    board = Board()
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        try:
            _parse_line(board, words[0], words[1:])
        except (ConfigError, IndexError, StopIteration, ValueError, OverflowError) as error:
            is_short = isinstance(error, IndexError | StopIteration)
            problem = "a word is missing at its end" if is_short else error
            raise ConfigError(f"board, line {number}: {line.strip()!r}: {problem}") from error
    return board


def _parse_line(board: Board, keyword: str, words: list[str]) -> None:
    if keyword not in _LINES:
        raise ConfigError(f"unknown word {keyword!r}{did_you_mean(keyword, _LINES)}")
    _LINES[keyword](board, words)


def _map_line(board: Board, words: list[str]) -> None:
    size = _MAP_NAME.fullmatch(words[0])
    if not size:
        raise ConfigError(f"unknown map {words[0]!r}; expected plain-<columns>x<rows>")
    board.hexmap = plain_map(int(size[1]), int(size[2]))


def plain_map(width: int, height: int) -> HexMap:
    """An open, flat, dry map."""
    nowhere = np.zeros((height, width), np.bool_)
    return HexMap(
        name=f"plain-{width}x{height}",
        grade_m=BOARD_GRADE_M,
        elev_m=np.zeros((height, width), np.int16),
        passable=playable_mask(width, height),
        paved=nowhere,
        concealed=nowhere.copy(),
        slushy=nowhere.copy(),
        controllable=nowhere.copy(),
    )


def _cell_line(board: Board, words: list[str]) -> None:
    cells = [
        board.map.parse_cell(word)
        for word in words
        if word.isdecimal() and len(word) == board.map.name_length
    ]
    layers = {layer: getattr(board.map, layer).copy() for layer in LAYERS}
    elev_m = board.map.elev_m.copy()
    marks = iter(words[len(cells) :])
    for mark in marks:
        if mark == "elev":
            elev_m.flat[cells] = int(next(marks))
        elif mark == "blocked":
            layers["passable"].flat[cells] = False
        elif mark in layers:
            layers[mark].flat[cells] = True
        else:
            raise ConfigError(f"unknown mark {mark!r}; expected elev, blocked or one of {LAYERS}")
    board.hexmap = replace(board.map, elev_m=elev_m, **layers)


def _point_line(board: Board, words: list[str]) -> None:
    name, cell_name, value, *owner = words
    _cell_line(board, [cell_name, "controllable"])
    cell = board.map.parse_cell(cell_name)
    board.points.append(ControlPoint(name=name, cell=cell, value=int(value)))
    if owner:
        board.changes.append((name, "owner", owner[0]))


def _piece_line(camp: Camp) -> Callable[[Board, list[str]], None]:
    def read(board: Board, words: list[str]) -> None:
        kind = words[0]
        if kind not in _KINDS:
            raise ConfigError(f"unknown type of piece {kind!r}{did_you_mean(kind, _KINDS)}")
        count = Counter((piece.camp, piece.kind) for piece in board.pieces)[camp, _KINDS[kind]]
        start = _start(board, camp, f"{kind}{count}", words)
        board.pieces.append(start)
        board.changes += _changes(str(start), words[3:] if start.aboard else words[2:])

    return read


def _start(board: Board, camp: Camp, name: str, words: list[str]) -> PieceStart:
    kind = _KINDS[words[0]]
    if words[1] != "aboard":
        cell = board.map.parse_cell(words[1])
        home = _chariot_of(board, camp, name) if kind == PieceType.SOLDIER else None
        return PieceStart(camp=camp, name=name, kind=kind, cell=cell, home=home)
    carriers = [p for p in board.pieces if (p.camp, p.name) == (camp, words[2])]
    if not carriers:
        raise ConfigError(f"{camp_name(camp)} {words[2]} must stand in a line above its passenger")
    return PieceStart(camp=camp, name=name, kind=kind, cell=carriers[0].cell, home=words[2], aboard=True)


def _chariot_of(board: Board, camp: Camp, name: str) -> str | None:
    """A soldier's home: the chariot of its own number, if there is one."""
    home = name.replace("soldier", "chariot")
    return home if any((p.camp, p.name) == (camp, home) for p in board.pieces) else None


def _changes(name: str, words: list[str]) -> list[Change]:
    """What is said of a piece after its cell."""
    changes: list[Change] = []
    rest = list(words)
    while rest:
        word = rest.pop(0)
        if word == "moving":
            path = [rest.pop(0) for _ in range(len(rest)) if rest and rest[0].isdecimal()]
            changes.append((name, "path", path))
        elif word in {"hidden", "suppressed"}:
            changes.append((name, word, True))
        elif word in {"stopping", "stopped"}:
            changes.append((name, "stopping", "forced" if word == "stopped" else "natural"))
        elif word in {"blood", "cool", "mortar_cool"}:
            changes.append((name, word, int(rest.pop(0))))
        elif word == "ammo":
            changes.append((name, "ammo", {rest.pop(0): int(rest.pop(0))}))
        else:
            raise ConfigError(f"unknown word {word!r} after the piece's cell")
    return changes


def _number_line(name: str) -> Callable[[Board, list[str]], None]:
    def read(board: Board, words: list[str]) -> None:
        setattr(board, name, int(words[0]))

    return read


def _score_line(board: Board, words: list[str]) -> None:
    board.net_score = words[0] == "net"


_LINES: dict[str, Callable[[Board, list[str]], None]] = {
    "map": _map_line,
    "cell": _cell_line,
    "point": _point_line,
    **{camp_name(camp): _piece_line(camp) for camp in (Camp.RED, Camp.BLUE)},
    "ticks": _number_line("game_ticks"),
    "seed": _number_line("seed"),
    "score": _score_line,
}


def print_game(state: State, b: int, world: World) -> str:
    """Game b as text: the clock, the margins, the points, and every living piece; all hidden facts too."""
    game, pieces, rules = state.games[b], state.pieces[b], world.rules[0]
    margins = [f"{camp_name(camp)} {int(margin(game, pieces, camp, rules)):+d}" for camp in SIDES]
    lines = [f"{world.scenario.name}: tick {game.tick} of {game.end_tick}, margin {', '.join(margins)}"]
    lines += [f"point    {_point_words(point)}" for point in side_view(Camp.RED, state, b, world).points]
    for camp in SIDES:
        own = side_view(camp, state, b, world).own
        lines += [f"{camp_name(camp):8} {_piece_words(piece)}" for piece in own if piece.alive]
    return "\n".join(lines)


def _point_words(point: PointView) -> str:
    return f"{point.name} {point.cell} {point.value} {point.owner}"


def _piece_words(piece: OwnPiece) -> str:
    place = f"aboard {piece.aboard}" if piece.aboard else piece.cell
    words = [piece.name, place, f"blood {piece.blood}"]
    if piece.path:
        words += ["moving", *piece.path]
    elif piece.doing != "settled":
        words.append(piece.doing)
    words += ["hidden"] * piece.hidden + ["suppressed"] * piece.suppressed
    if piece.cool_left:
        words.append(f"cool {piece.cool_left}")
    return " ".join(words)
