"""A picture of what a camp knows now, for `env.render()`."""

from __future__ import annotations

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from hexwar_sb3.engine.roster import camp_name
from hexwar_sb3.engine.score import known_margin
from hexwar_sb3.maps.picture import draw_map, draw_points, draw_tokens
from hexwar_sb3.play.arena import Arena
from hexwar_sb3.rules.enums import Camp, PieceType
from hexwar_sb3.rules.indices import CampIndex
from hexwar_sb3.tasks.known import is_known

_INCHES, _DPI = (8.0, 7.5), 80  # of a frame
Token = tuple[Camp, str]


def draw_position(arena: Arena, b: int, camp: int) -> NDArray[np.uint8]:
    """What a camp knows of game b: own pieces, and enemies where they were seen last (with a "?" if out of sight).

    Returns:
        [height, width, RGB].
    """
    game, hexmap = arena.state.games[b], arena.world.scenario.hexmap
    figure = Figure(figsize=_INCHES, dpi=_DPI, layout="constrained")
    axes = figure.add_subplot()
    draw_map(axes, hexmap)
    draw_points(axes, arena.world.scenario, [Camp(int(owner)) for owner in game.point_owner])
    draw_tokens(axes, hexmap, _tokens(arena, b, camp))
    margin = known_margin(
        game, arena.state.pieces[b], arena.state.memory[b], CampIndex(camp), arena.world.rules[0]
    )
    axes.set_title(f"tick {game.tick}, seen by {camp_name(Camp(camp))}, known margin {margin:+d}")
    canvas = FigureCanvasAgg(figure)
    canvas.draw()  # type: ignore[no-untyped-call]
    return np.asarray(canvas.buffer_rgba(), np.uint8)[..., :3].copy()  # type: ignore[no-untyped-call]


def _tokens(arena: Arena, b: int, camp: int) -> dict[int, list[Token]]:
    pieces, memory = arena.state.pieces[b], arena.state.memory[b, camp]
    cells: dict[int, list[Token]] = {}
    for piece, known in zip(pieces, memory, strict=True):
        letter = PieceType(int(piece.kind)).name[0]
        if piece.camp == camp:
            if piece.blood > 0:
                cells.setdefault(int(piece.cell), []).append((Camp(camp), letter))
        elif is_known(known):
            seen = letter if known.seen else f"{letter}?"
            cells.setdefault(int(known.cell), []).append((Camp(1 - camp), seen))
    return cells
