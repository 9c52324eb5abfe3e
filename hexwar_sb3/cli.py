"""The `hexwar` command: one dataclass a sub-command; its fields are the flags."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import Any

import tyro

from hexwar_sb3 import __version__
from hexwar_sb3.commands.bench import Bench
from hexwar_sb3.commands.distill import Distill
from hexwar_sb3.commands.doctor import Doctor
from hexwar_sb3.commands.evaluate import Evaluate, Match
from hexwar_sb3.commands.experiments import Experiments
from hexwar_sb3.commands.hotspots import Hotspots
from hexwar_sb3.commands.maps import Maps
from hexwar_sb3.commands.selfplay import SelfPlay
from hexwar_sb3.commands.tournament import Tournament
from hexwar_sb3.commands.train import Train
from hexwar_sb3.commands.tune import Tune
from hexwar_sb3.commands.watch import Watch
from hexwar_sb3.errors import HexWarError

COMMANDS: dict[str, Callable[..., Any]] = {
    "train": Train,
    "evaluate": Evaluate,
    "match": Match,
    "tournament": Tournament,
    "selfplay": SelfPlay,
    "distill": Distill,
    "tune": Tune,
    "watch": Watch,
    "maps": Maps,
    "hotspots": Hotspots,
    "experiments": Experiments,
    "bench": Bench,
    "doctor": Doctor,
}
USER_ERROR, INTERRUPTED = 2, 130  # exit codes


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one sub-command; a mistake of the user's ends in one line, not in a traceback."""
    try:
        code = parse(sys.argv[1:] if arguments is None else arguments).run()
    except (HexWarError, OSError) as error:
        print(f"hexwar: {error}", file=sys.stderr)
        code = USER_ERROR
    except KeyboardInterrupt:
        print("hexwar: stopped", file=sys.stderr)
        code = INTERRUPTED
    sys.exit(code)


def parse(arguments: Sequence[str]) -> Any:
    """Turn arguments into the dataclass of their sub-command."""
    if list(arguments) == ["--version"]:
        print(f"hexwar {__version__}")
        sys.exit(0)
    return tyro.extras.subcommand_cli_from_dict(
        COMMANDS,
        prog="hexwar",
        description="A war game on hexagons under fog, and commanders that learn it.",
        args=arguments,
        config=(tyro.conf.FlagCreatePairsOff, tyro.conf.OmitArgPrefixes),
    )


if __name__ == "__main__":
    main()
