"""A small picture of how a game ended: for browsers that cannot run the page, and for pages that drop it."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from hexwar_sb3.engine.game import Game
from hexwar_sb3.maps.hexmap import HexMap
from hexwar_sb3.viewer.scene import Scene, Token, fanned, scene_of
from hexwar_sb3.viewer.story import NAME_CHARACTERS

MAX_BYTES = 40_000
COLOURS = 64
CELL = 10.0  # width, in dots
_RADIUS = 9  # of a piece
_GROUND = ("#dfe5cf", "#d6dcc0", "#cdd0b0", "#c2c1a0", "#b5ae90", "#a89c82")  # from low to high
_FOREST, _MARSH, _LAKE, _ROAD = "#9dba8f", "#b4d0c6", "#9fc3de", "#f6efdc"
CAMP_COLOUR = {"red": "#c8321f", "blue": "#1f5fbf", "green": "#8a8f86"}
INK, RIM = "#22262b", "#ffffff"


def picture_of(game: Game, camp: str | None = None) -> bytes:
    """PNG of the map with the pieces of a game as it stands, all of them or those that a camp knows."""
    map_image = ground(game.world.scenario.hexmap)
    return _small_png(draw_scene(map_image, scene_of(game, camp), game.world.scenario.hexmap))


def draw_scene(map_image: Image.Image, scene: Scene, hexmap: HexMap, cell: float = CELL) -> Image.Image:
    """A copy of the map's picture, of cells so many dots wide, with fire, points and pieces on it."""
    image = map_image.copy()
    pen = ImageDraw.Draw(image)
    for point in scene.points:
        text = f"{point.name[:NAME_CHARACTERS]} {point.value}"
        _draw_point(pen, place_of(hexmap.parse_cell(point.cell), hexmap, cell), point.owner, text)
    for shot in scene.shots:
        line = (place_of(shot.start, hexmap, cell), place_of(shot.end, hexmap, cell))
        pen.line(line, fill=CAMP_COLOUR[shot.camp], width=4 if shot.with_loss else 1)
    for death in scene.deaths:
        _draw_cross(pen, place_of(death.cell, hexmap, cell), CAMP_COLOUR[death.camp])
    for token, aside in fanned(scene.tokens):
        x, y = place_of(token.cell, hexmap, cell)
        _draw_token(pen, (x + 2 * _RADIUS * aside, y), token)
    return image


def place_of(cell: int, hexmap: HexMap, wide: float = CELL) -> tuple[float, float]:
    """Centre of a cell, in dots; cells are so many dots wide."""
    y, x = divmod(cell, hexmap.width)
    return (x + 0.5 + (y & 1) / 2) * wide, (y + 2 / 3) * wide * np.sqrt(3) / 2


def ground(hexmap: HexMap, cell: float = CELL) -> Image.Image:
    """The map alone, of cells so many dots wide."""
    size = int(hexmap.width * cell), int((hexmap.height + 1 / 3) * cell * np.sqrt(3) / 2) + 1
    image = Image.new("RGB", size, RIM)
    pen = ImageDraw.Draw(image)
    step = max(1, int(hexmap.elev_m.max())) / (len(_GROUND) - 1)
    angles, size_of_cell = np.radians(np.arange(-90, 270, 60)), 1.08 * cell / np.sqrt(3) + 0.6
    corners = size_of_cell * np.array([np.cos(angles), np.sin(angles)]).T
    for number in map(int, np.flatnonzero(hexmap.playable)):
        outline = np.add(corners, place_of(number, hexmap, cell))
        colour = _GROUND[round(int(hexmap.elev_m.flat[number]) / step)]
        for layer, other in ((hexmap.slushy, _MARSH), (hexmap.concealed, _FOREST), (hexmap.paved, _ROAD)):
            colour = other if layer.flat[number] else colour
        colour = colour if hexmap.passable.flat[number] else _LAKE
        pen.polygon(outline.ravel().tolist(), fill=colour)
    return image


def _draw_point(pen: ImageDraw.ImageDraw, place: tuple[float, float], owner: str, text: str) -> None:
    x, y = place
    pen.regular_polygon((x, y, 9), 4, rotation=45, fill=CAMP_COLOUR[owner], outline=RIM)
    pen.text((x, y - 18), text, INK, ImageFont.load_default(13), anchor="mm", stroke_width=2, stroke_fill=RIM)


def _draw_cross(pen: ImageDraw.ImageDraw, place: tuple[float, float], colour: str) -> None:
    x, y = place
    for fill, width in ((RIM, 6), (colour, 3)):
        pen.line((x - 6, y - 6, x + 6, y + 6), fill, width)
        pen.line((x - 6, y + 6, x + 6, y - 6), fill, width)


def _draw_token(pen: ImageDraw.ImageDraw, place: tuple[float, float], token: Token) -> None:
    """A camp has its shape; a ghost is hollow."""
    x, y = place
    box, colour = (x - _RADIUS, y - _RADIUS, x + _RADIUS, y + _RADIUS), CAMP_COLOUR[token.camp]
    fill, line = (RIM, colour) if token.is_ghost else (colour, RIM)
    if token.camp == "red":
        pen.rounded_rectangle(box, 3, fill, line, 2)
    else:
        pen.ellipse(box, fill, line, 2)
    pen.text(place, token.text, line, ImageFont.load_default(11), anchor="mm")


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
