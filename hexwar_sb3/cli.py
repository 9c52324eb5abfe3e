"""The `hexwar` command: one dataclass a sub-command; its fields are the flags."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import Any

import tyro

from hexwar_sb3.commands.bench import Bench
from hexwar_sb3.commands.console import carry_out, one_line_errors
from hexwar_sb3.commands.distill import Distill
from hexwar_sb3.commands.doctor import Doctor
from hexwar_sb3.commands.evaluate import Evaluate, Match
from hexwar_sb3.commands.experiments import Experiments
from hexwar_sb3.commands.exploit import Exploit
from hexwar_sb3.commands.hotspots import Hotspots
from hexwar_sb3.commands.learn import Learn
from hexwar_sb3.commands.maps import Maps
from hexwar_sb3.commands.play import Play
from hexwar_sb3.commands.policies import Export, Import
from hexwar_sb3.commands.selfplay import SelfPlay
from hexwar_sb3.commands.stats import Stats
from hexwar_sb3.commands.tournament import Tournament
from hexwar_sb3.commands.train import Train
from hexwar_sb3.commands.tune import Tune
from hexwar_sb3.commands.watch import Watch
from hexwar_sb3.errors import UnknownNameError
from hexwar_sb3.version import __version__

COMMANDS: dict[str, Callable[..., Any]] = {
    "train": Train,
    "evaluate": Evaluate,
    "match": Match,
    "tournament": Tournament,
    "selfplay": SelfPlay,
    "distill": Distill,
    "exploit": Exploit,
    "learn": Learn,
    "export": Export,
    "import": Import,
    "tune": Tune,
    "watch": Watch,
    "play": Play,
    "stats": Stats,
    "maps": Maps,
    "hotspots": Hotspots,
    "experiments": Experiments,
    "bench": Bench,
    "doctor": Doctor,
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one sub-command; a mistake of the user's ends in one line, not in a traceback."""
    given = sys.argv[1:] if arguments is None else list(arguments)
    sys.exit(carry_out("hexwar", lambda: int(parse(given).run())))


def parse(arguments: Sequence[str]) -> Any:
    """Turn arguments into the dataclass of their sub-command.

    Raises:
        UnknownNameError: there is no such sub-command or flag.
        ConfigError: a value is missing, or is none.
    """
    if list(arguments) == ["--version"]:
        print(f"hexwar {__version__}")
        sys.exit(0)
    name = arguments[0] if arguments else "--help"
    if not name.startswith("-") and name not in COMMANDS:
        raise UnknownNameError("command", name, COMMANDS)
    with one_line_errors(arguments, COMMANDS.get(name)):
        return tyro.extras.subcommand_cli_from_dict(
            COMMANDS,
            prog="hexwar",
            description="A war game on hexagons under fog, and commanders that learn it.",
            args=list(arguments) or [name],
            config=(tyro.conf.FlagCreatePairsOff, tyro.conf.OmitArgPrefixes),
        )


if __name__ == "__main__":
    main()
