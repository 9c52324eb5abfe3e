"""Many games on one page: each a block of its own that is unpacked when it is opened, maps, setups and rules once by hash."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from hexwar_sb3.engine.replay import Replay
from hexwar_sb3.errors import ConfigError, FileFormatError, UnknownNameError
from hexwar_sb3.evaluation.jobs import run_jobs
from hexwar_sb3.files import replacing
from hexwar_sb3.viewer.contents import FORMAT, FORMAT_VERSION, SETUP, entry_of, shared_parts
from hexwar_sb3.viewer.differences import with_differences
from hexwar_sb3.viewer.map_block import map_block
from hexwar_sb3.viewer.page import ALL, CHOICES, MAX_PAGE_BYTES, filled, packed, tagged
from hexwar_sb3.viewer.picture import picture_of
from hexwar_sb3.viewer.story import CAMPS, NAME_CHARACTERS, VIEWS, Teller
from hexwar_sb3.viewer.tracks import Json

_SHARED = frozenset({*SETUP, "rules", "format", "version", "players"})
TITLE_CHARACTERS = 120


@dataclass(frozen=True, kw_only=True)
class Clip:
    """A recorded game for a page of many, and what the page calls it."""

    path: Path  # of a replay file
    name: str
    view: str = ALL


@dataclass(frozen=True, kw_only=True)
class Told:
    """A game as it stands on a page of many."""

    entry: Json  # in the contents
    block: str  # its stories, packed
    shared: Mapping[str, Json]  # parts that other games may have, too, by block
    picture: bytes  # PNG of how it ended


def tell(clip: Clip) -> Told:
    """Play a recorded game again, and tell it: a function of `clip` alone, in any process.

    Raises:
        ReplayFileError: the file is broken, or cannot be played again.
    """
    teller = Teller(Replay.load(clip.path))
    told = teller.stories(VIEWS if clip.view == ALL else (clip.view,))
    hexmap = teller.game.world.scenario.hexmap
    story = told[next(iter(told))]
    return Told(
        entry=entry_of(told, teller.game, clip.name, clip.view),
        block=packed(interleaved({name: with_differences(story) for name, story in told.items()})),
        shared={f"map-{story['map']}": map_block(hexmap), **shared_parts(story)},
        picture=picture_of(teller.game, clip.view if clip.view in CAMPS else None),
    )


def interleaved(told: Mapping[str, Json]) -> Json:
    """Stories of a game as `{field: {view: value}}`: what is alike lies side by side, which packs better by a fifth."""
    names = dict.fromkeys(name for story in told.values() for name in story if name not in _SHARED)
    return {
        name: {view: story[name] for view, story in told.items() if name in story}
        for name in names
        if name != "view"
    }


@dataclass(frozen=True, kw_only=True)
class Album:
    """A page of many games: the games in their order, and what else its cover shows.

    Args:
        title: of the page.
        clips: the games, at least one unless the cover has tables.
        cover: further parts of the contents (docs/formats/story.md): `kind`, `curve`, `tables`, `lineage`.

    Example:
        >>> from pathlib import Path
        >>> Replay.of(Game("plain", seed=0)).save("first.hwr")
        >>> Replay.of(Game("plain", seed=1)).save("second.hwr")
        >>> clips = [Clip(path=Path(name), name=name) for name in ("first.hwr", "second.hwr")]
        >>> Album(title="Two games", clips=clips).save(Path("games.html"))
    """

    title: str
    clips: Sequence[Clip]
    cover: Mapping[str, object] = field(default_factory=dict)

    def save(self, path: Path, *, jobs: int = 1) -> None:
        """Write the page, whole or not at all.

        Args:
            path: of the page.
            jobs: games told side by side.

        Raises:
            ReplayFileError: a file is broken, or cannot be played again.
            FileFormatError: all of them make a page that is too large; it says how many fit.
        """
        page = self.page(path, jobs=jobs).encode()
        with replacing(path) as temporary:
            temporary.write_bytes(page)

    def page(self, path: Path, *, jobs: int = 1) -> str:
        """The page as text; `path` is named in errors."""
        if not self.clips and "tables" not in self.cover:
            raise ConfigError(f"{path}: no recorded game; expected one at least")
        for clip in self.clips:
            if clip.view not in CHOICES:
                raise UnknownNameError("view", clip.view, CHOICES)
        told = run_jobs(tell, self.clips, jobs, "game")
        shared = {name: packed(part) for one in told for name, part in one.shared.items()}
        blocks = {"contents": packed(self._contents(told)), **dict(sorted(shared.items()))}
        games = {f"game-{n}": one.block for n, one in enumerate(told, start=1)}
        title, picture = self.title[:TITLE_CHARACTERS], told[-1].picture if told else b""
        check_size(
            path,
            [
                len(filled(title, blocks, picture).encode()),
                *(len(tagged(name, block)) for name, block in games.items()),
            ],
        )
        return filled(title, {**blocks, **games}, picture)

    def _contents(self, told: Sequence[Told]) -> Json:
        return {
            "format": FORMAT,
            "version": FORMAT_VERSION,
            "title": self.title[:TITLE_CHARACTERS],
            "kind": "games",
            **self.cover,
            "games": [one.entry for one in told],
        }


def check_size(path: Path, sizes: Sequence[int]) -> None:
    """Check that a page is no larger than a browser opens well.

    Args:
        path: of the page.
        sizes: bytes of the page without games, then of each game.

    Raises:
        FileFormatError: it is larger; says how many of the games fit.
    """
    total, fit = sum(sizes), 0
    while fit + 1 < len(sizes) and sum(sizes[: fit + 2]) <= MAX_PAGE_BYTES:
        fit += 1
    if total > MAX_PAGE_BYTES:
        found = f"{total} bytes of {len(sizes) - 1} games"
        expected = f"at most {MAX_PAGE_BYTES}: the first {fit} games fit"
        raise FileFormatError(path, "page", found=found, expected=expected)


def clips_of(paths: Sequence[Path], view: str = ALL) -> list[Clip]:
    """Files as games of a page: called by their names, or as much of their paths as tells them apart."""
    parts = [path.with_suffix("").parts for path in paths]
    depth = next((d for d in range(1, 9) if len({part[-d:] for part in parts}) == len(parts)), 1)
    names = ["/".join(part[-depth:])[-NAME_CHARACTERS:] for part in parts]
    return [Clip(path=path, name=name, view=view) for path, name in zip(paths, names, strict=True)]
