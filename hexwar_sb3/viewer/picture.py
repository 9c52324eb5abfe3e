"""A small picture of how a game ended: for browsers that cannot run the page, and for pages that drop it."""

from __future__ import annotations

from io import BytesIO
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.roster import SIDES, camp_name
from hexwar_sb3.engine.view import SideView
from hexwar_sb3.maps.hexmap import HexMap

MAX_BYTES = 40_000
COLOURS = 64
_CELL = 10.0  # width, in dots
_GROUND = ("#dfe5cf", "#d6dcc0", "#cdd0b0", "#c2c1a0", "#b5ae90", "#a89c82")  # from low to high
_FOREST, _MARSH, _LAKE, _ROAD = "#9dba8f", "#b4d0c6", "#9fc3de", "#f6efdc"
CAMP_COLOUR = {"red": "#c8321f", "blue": "#1f5fbf", "green": "#8a8f86"}
INK, RIM = "#22262b", "#ffffff"


class Token(NamedTuple):
    """A piece on the picture."""

    camp: str
    cell: str
    letter: str


def picture_of(game: Game, camp: str | None = None) -> bytes:
    """PNG of the map with the pieces of a game as it stands, all of them or those that a camp knows."""
    return _small_png(draw_game(ground(game.world.scenario.hexmap), game, camp))


def draw_game(map_image: Image.Image, game: Game, camp: str | None = None) -> Image.Image:
    """A copy of the map's picture with points and pieces on it."""
    views = [game.view(name) for name in map(camp_name, SIDES) if camp in (None, name)]
    hexmap, image = game.world.scenario.hexmap, map_image.copy()
    pen = ImageDraw.Draw(image)
    for point in views[0].points:
        text = f"{point.name} {point.value}"
        _draw_point(pen, place_of(hexmap.parse_cell(point.cell), hexmap), point.owner, text)
    for view in views:
        for token in _tokens(view, with_enemies=camp is not None):
            _draw_token(pen, place_of(hexmap.parse_cell(token.cell), hexmap), token)
    return image


def _tokens(view: SideView, *, with_enemies: bool) -> list[Token]:
    own = [piece for piece in view.own if piece.alive and piece.aboard is None]
    tokens = [Token(view.camp, piece.cell, piece.kind[0].upper()) for piece in own]
    seen = view.seen if with_enemies else ()
    return tokens + [Token(one.name.split(":")[0], one.cell, one.kind[0].upper()) for one in seen]


def place_of(cell: int, hexmap: HexMap) -> tuple[float, float]:
    """Centre of a cell, in dots."""
    y, x = divmod(cell, hexmap.width)
    return (x + 0.5 + (y & 1) / 2) * _CELL, (y + 2 / 3) * _CELL * np.sqrt(3) / 2


def ground(hexmap: HexMap) -> Image.Image:
    """The map alone."""
    size = int(hexmap.width * _CELL), int((hexmap.height + 1 / 3) * _CELL * np.sqrt(3) / 2) + 1
    image = Image.new("RGB", size, RIM)
    pen = ImageDraw.Draw(image)
    step = max(1, int(hexmap.elev_m.max())) / (len(_GROUND) - 1)
    for cell in map(int, np.flatnonzero(hexmap.playable)):
        x, y = place_of(cell, hexmap)
        colour = _GROUND[round(int(hexmap.elev_m.flat[cell]) / step)]
        for layer, other in ((hexmap.slushy, _MARSH), (hexmap.concealed, _FOREST), (hexmap.paved, _ROAD)):
            colour = other if layer.flat[cell] else colour
        colour = colour if hexmap.passable.flat[cell] else _LAKE
        pen.regular_polygon((x, y, _CELL / np.sqrt(3) + 0.6), 6, rotation=0, fill=colour)
    return image


def _draw_point(pen: ImageDraw.ImageDraw, place: tuple[float, float], owner: str, text: str) -> None:
    x, y = place
    pen.regular_polygon((x, y, 9), 4, rotation=45, fill=CAMP_COLOUR[owner], outline=RIM)
    pen.text((x, y - 16), text, INK, ImageFont.load_default(13), anchor="mm", stroke_width=2, stroke_fill=RIM)


def _draw_token(pen: ImageDraw.ImageDraw, place: tuple[float, float], token: Token) -> None:
    x, y = place
    box = (x - 8, y - 8, x + 8, y + 8)
    if token.camp == "red":
        pen.rounded_rectangle(box, 3, CAMP_COLOUR["red"], RIM, 2)
    else:
        pen.ellipse(box, CAMP_COLOUR["blue"], RIM, 2)
    pen.text((x, y), token.letter, RIM, ImageFont.load_default(12), anchor="mm")


def with_few_colours(image: Image.Image, palette: Image.Image | None = None) -> Image.Image:
    """Of 64 colours, those of the camps among them, few as their dots are."""
    if palette is None:
        key = [*CAMP_COLOUR.values(), INK, RIM]
        height = image.height // len(key) + 1
        wide = Image.new("RGB", (image.width * 5 // 4, image.height))
        wide.paste(image)
        for number, colour in enumerate(key):
            wide.paste(colour, (image.width, number * height, wide.width, (number + 1) * height))
        palette = wide.quantize(COLOURS, dither=Image.Dither.NONE)
    return image.quantize(palette=palette, dither=Image.Dither.NONE)


def _small_png(image: Image.Image) -> bytes:
    """Of few colours, and smaller until it fits."""
    while True:
        packed = BytesIO()
        with_few_colours(image).save(packed, format="png", optimize=True)
        if packed.tell() <= MAX_BYTES:
            return packed.getvalue()
        image = image.resize((image.width * 3 // 4, image.height * 3 // 4), Image.Resampling.LANCZOS)
