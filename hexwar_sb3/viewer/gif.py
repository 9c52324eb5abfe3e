"""A GIF of a part of a game, for chats and pages that show nothing else."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from hexwar_sb3.engine.game import Game
from hexwar_sb3.engine.game_events import GameEvent
from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.errors import ConfigError, UnknownNameError
from hexwar_sb3.files import replacing
from hexwar_sb3.kernels import Rows
from hexwar_sb3.viewer.luck import SHOTS
from hexwar_sb3.viewer.picture import CAMP_COLOUR, INK, draw_game, ground, place_of, with_few_colours
from hexwar_sb3.viewer.story import CAMPS, NAME_CHARACTERS, REFEREE, VIEWS

MOST_FRAMES = 120
_WIDTH, _CAPTION, _FRAME_MS = 480, 22, 80
Shot = tuple[str, int, int, bool]  # camp, from cell, to cell, with loss


def save_gif(
    replay: Replay, path: str | Path, start: int = 0, until: int | None = None, view: str = REFEREE
) -> None:
    """Write a part of a game as a GIF of at most MOST_FRAMES frames, whole or not at all.

    Args:
        replay: a whole one.
        path: of the file.
        start: first tick.
        until: last tick; None is the end of the game.
        view: "referee", or a camp: then only what it knew is drawn, and no fire.

    Raises:
        UnknownNameError: another view.
        ConfigError: ticks that the game does not have.
    """
    if view not in VIEWS:
        raise UnknownNameError("view", view, VIEWS)
    last = int(replay.end["tick"])
    until = last if until is None else until
    if not 0 <= start < until <= last:
        raise ConfigError(f"ticks {start} to {until}; expected two ticks of 0..{last}, the second one later")
    frames = list(_frames(replay, start, until, view))
    first = with_few_colours(frames[0])
    rest = [with_few_colours(frame, first) for frame in frames[1:]]
    with replacing(Path(path)) as temporary:
        first.save(
            temporary, "GIF", save_all=True, append_images=rest, duration=_FRAME_MS, loop=0, optimize=True
        )


def _frames(replay: Replay, start: int, until: int, view: str) -> Iterator[Image.Image]:
    step = -(-(until - start) // (MOST_FRAMES - 1))
    shots, before, map_image = list[Shot](), None, None
    for game, events in replay.ticks():
        if game.tick > until:
            return
        if before is not None and view == REFEREE:
            shots += [_shot(event, before, game) for event in events if event.kind in SHOTS]
        before = game.pieces.copy()
        if game.tick < start or ((game.tick - start) % step and game.tick != until):
            continue
        map_image = map_image or ground(game.world.scenario.hexmap)
        yield _frame(map_image, game, shots, replay, view)
        shots.clear()


def _shot(event: GameEvent, before: Rows, game: Game) -> Shot:
    shooter = before[game.roster.index(event.shooter or event.piece)]
    camp, hurt = event.piece.split(":")[0], (event.result or 0) > 0
    return camp, int(shooter.cell), int(game.roster.cell(str(event.cell))), hurt


def _frame(map_image: Image.Image, game: Game, shots: list[Shot], replay: Replay, view: str) -> Image.Image:
    drawn = draw_game(map_image, game, None if view == REFEREE else view)
    pen, hexmap = ImageDraw.Draw(drawn), game.world.scenario.hexmap
    for camp, start, end, hurt in shots:
        line = (place_of(start, hexmap), place_of(end, hexmap))
        pen.line(line, fill=CAMP_COLOUR[camp], width=4 if hurt else 2)
    height = round(drawn.height * _WIDTH / drawn.width)
    image = Image.new("RGB", (_WIDTH, height + _CAPTION), "white")
    image.paste(drawn.resize((_WIDTH, height), Image.Resampling.LANCZOS))
    text = ImageFont.load_default(12)
    ImageDraw.Draw(image).text(
        (6, height + _CAPTION / 2), _caption(game, replay, view), INK, text, anchor="lm"
    )
    return image


def _caption(game: Game, replay: Replay, view: str) -> str:
    players = replay.head.get("players", {})
    short = NAME_CHARACTERS // 2
    names = [players.get(camp, {}).get("name", "unknown")[:short] for camp in CAMPS]
    if view != REFEREE:
        return f"tick {game.tick}: {names[0]} against {names[1]}, as {view} knows it"
    margins = [f"{name} {game.margin(camp):+d}" for name, camp in zip(names, CAMPS, strict=True)]
    return f"tick {game.tick}: {', '.join(margins)}; seed {replay.seed}"
