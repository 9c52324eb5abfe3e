"""`hexwar play`: command one side yourself, in the browser, against any bot or policy."""

from __future__ import annotations

import os
import secrets
import sys
import tempfile
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, cast

import tyro

from hexwar_sb3.checks import check_whole
from hexwar_sb3.commands.console import INTERRUPTED
from hexwar_sb3.commands.output import compile_first, typed
from hexwar_sb3.commands.settings import ScenarioName, check_name
from hexwar_sb3.errors import ConfigError

if TYPE_CHECKING:
    from hexwar_sb3.server.ladder import Ladder
    from hexwar_sb3.server.partial import Partial
    from hexwar_sb3.server.session import Session

NEEDED = ("starlette", "uvicorn", "websockets")
USUAL_OPPONENT = "MA2"
MOST_PORT = 65_535
MOST_GAMES = 10_000  # in a folder, by numbers
OF_ANY_GAME = frozenset(
    {"port", "no_browser", "resume", "ladder"}
)  # flags that a game that goes on takes, too
Opponent = Annotated[
    str,
    tyro.conf.Positional,
    tyro.conf.arg(metavar="OPPONENT", help="a bot, HRL0, or the folder of a policy or a run"),
]
SeedOrNone = Annotated[
    int | None,
    tyro.conf.arg(metavar="INT", help="of all dice, 0..999999; else one that nobody knows before the end"),
]
Hints = Annotated[
    str | None,
    tyro.conf.arg(
        metavar="POLICY",
        help="HRL0 or the folder of a policy, which says what it would do when asked; counted",
    ),
]
Port = Annotated[int, tyro.conf.arg(help="of this machine; 0: any that is free")]
Resume = Annotated[
    Path | None, tyro.conf.arg(metavar="FILE", help="go on with a game that was broken off (*.partial.hwr)")
]
LadderFolder = Annotated[
    Path | None,
    tyro.conf.arg(
        metavar="FOLDER",
        help="of a training or a league: its policies from the first to the last, the next one after each win",
    ),
]
Player = Annotated[
    str | None,
    tyro.conf.arg(metavar="NAME", help="what you are called in the replay and on the page; else person"),
]
Name = Annotated[
    str | None, tyro.conf.arg(metavar="NAME", help="of the game and its files; else game_1, game_2, ...")
]


@dataclass(frozen=True, kw_only=True)
class Play:
    """Command one side yourself, in the browser, under fog, against a bot or a policy.

    The game waits for you: orders are planned while the clock stands. It is kept on disk order by order, so Ctrl-C, a
    closed tab or a crash loses nothing. At the end the whole game is a replay, and a page with all that you did not see.
    The page is served to this machine alone.
    """

    opponent: Opponent = USUAL_OPPONENT
    scenario: ScenarioName = "plain"
    side: Literal["red", "blue"] = "red"  # that you command
    seed: SeedOrNone = None
    hints: Hints = None
    player: Player = None
    port: Port = 0
    no_browser: bool = False  # only print the address
    resume: Resume = None
    ladder: LadderFolder = None
    name: Name = None
    folder: Path = Path("play")  # where games lie

    def run(self) -> int:
        """Serve the game until Ctrl-C."""
        missing = [name for name in NEEDED if find_spec(name) is None]
        if missing:
            raise ConfigError(f'playing needs {", ".join(missing)}: pip install "hexwar-sb3[play]"')
        from hexwar_sb3.server.app import Server
        from hexwar_sb3.server.warm import warm_up

        check_whole("--port", self.port, least=0, most=MOST_PORT)
        session = self._begun() if self.resume is None else self._resumed(self.resume)
        try:
            server = Server(session, self.port)
        except OSError as error:
            if self.resume is None:
                cast("Partial", session.record).remove()  # a game that nobody began
            said = (
                f"--port {self.port}: {os.strerror(error.errno or 0)}; without it any that is free is taken"
            )
            raise ConfigError(said) from error
        warm_up(session.setup)
        print(f"{_welcome(session)}\n{server.guard.address}", flush=True)
        try:
            with _browser(server.guard.address, opens=not self.no_browser):
                server.run()
        except KeyboardInterrupt:
            pass
        return _goodbye(session)

    def _begun(self) -> Session:
        from hexwar_sb3.server.person import PERSON, check_person
        from hexwar_sb3.server.session import Setup, new_session

        if self.name is not None:
            check_name("--name", self.name)
        player = PERSON if self.player is None else self.player
        check_person("--player", player)
        seed = (
            secrets.randbits(63)
            if self.seed is None
            else check_whole("--seed", self.seed, least=0, most=999_999)
        )
        ladder = self._ladder(self.side, self.folder)
        opponent = self.opponent if ladder is None else ladder.rungs[ladder.at].player
        compile_first(opponent, scenario=self.scenario)
        setup = Setup(
            opponent=opponent,
            scenario=self.scenario,
            side=self.side,
            seed=seed,
            player=player,
            hints=self.hints,
            name=self.name or _free_name(self.folder),
            folder=self.folder,
            ladder=ladder,
            command=typed(),
        )
        return new_session(setup)

    def _resumed(self, file: Path) -> Session:
        from hexwar_sb3.server.session import resumed_session

        for field in fields(self):
            if field.name not in OF_ANY_GAME and getattr(self, field.name) != field.default:
                raise ConfigError(
                    f"--resume goes on with the game as it is; found --{field.name}, expected none"
                )
        compile_first()
        return resumed_session(file, None if self.ladder is None else self._ladder_of(file))

    def _ladder(self, side: str, folder: Path) -> Ladder | None:
        from hexwar_sb3.commands.ladders import open_ladder

        if self.ladder is None:
            return None
        if self.opponent != USUAL_OPPONENT:
            raise ConfigError(f"--ladder says who is next; found {self.opponent}, expected no opponent")
        return open_ladder(self.ladder, "blue" if side == "red" else "red", folder)

    def _ladder_of(self, file: Path) -> Ladder | None:
        """The ladder on which a game that goes on counts."""
        from hexwar_sb3.server.partial import Partial

        record, head, _ = Partial.go_on(file)
        record.close()
        return self._ladder(head.camp, file.parent)


def _free_name(folder: Path) -> str:
    """The first of game_1, game_2, ... that is no file yet."""
    from hexwar_sb3.engine.replay_file import SUFFIX

    taken = {path.name.partition(".")[0] for path in folder.glob(f"*{SUFFIX}")}
    for number in range(1, MOST_GAMES):
        if f"game_{number}" not in taken:
            return f"game_{number}"
    raise ConfigError(f"{folder} has {MOST_GAMES} games; name this one with --name")


def _welcome(session: Session) -> str:
    game = session.game
    against = f"{session.camp} against {session.opponent.name}, {game.world.scenario.name}"
    return f"you command {against}, tick {game.tick}; Ctrl-C stops, and keeps the game. Open:"


def _goodbye(session: Session) -> int:
    if session.replay is not None:
        print(f"\nthe game: {session.file}; hexwar watch {session.file} -o game.html", file=sys.stderr)
        return 0
    if session.record is not None:
        stopped = f"stopped at tick {session.game.tick}"
        print(f"\n{stopped}; go on with: hexwar play --resume {session.record.path}", file=sys.stderr)
    return INTERRUPTED


@contextmanager
def _browser(address: str, *, opens: bool) -> Iterator[None]:
    """Open a page, by way of a file that only this user can read: what a program is called with, everybody can."""
    if not opens:
        yield
        return
    with tempfile.TemporaryDirectory(prefix="hexwar-") as folder:
        file = Path(folder) / "open.html"
        file.write_text(
            f'<!doctype html><meta http-equiv="refresh" content="0;url={address}">', encoding="utf-8"
        )
        webbrowser.open(file.as_uri())
        yield
