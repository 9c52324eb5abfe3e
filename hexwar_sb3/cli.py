"""The `hexwar` command: one dataclass a sub-command; its fields are the flags.

A command's module is imported when the command is asked for: to import them all takes a second.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import tyro

from hexwar_sb3.commands.console import carry_out, one_line_errors
from hexwar_sb3.errors import UnknownNameError
from hexwar_sb3.version import __version__

COMMANDS = {
    "train": "train:Train",
    "evaluate": "evaluate:Evaluate",
    "match": "evaluate:Match",
    "tournament": "tournament:Tournament",
    "selfplay": "selfplay:SelfPlay",
    "distill": "distill:Distill",
    "exploit": "exploit:Exploit",
    "learn": "learn:Learn",
    "export": "policies:Export",
    "import": "policies:Import",
    "tune": "tune:Tune",
    "watch": "watch:Watch",
    "play": "play:Play",
    "stats": "stats:Stats",
    "maps": "maps:Maps",
    "hotspots": "hotspots:Hotspots",
    "experiments": "experiments:Experiments",
    "bench": "bench:Bench",
    "doctor": "doctor:Doctor",
}  # module in hexwar_sb3.commands, and dataclass
_CONFIG = (tyro.conf.FlagCreatePairsOff, tyro.conf.OmitArgPrefixes)


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
    name, *rest = arguments or ["--help"]
    if name.startswith("-"):
        return _overview([name, *rest])
    if name not in COMMANDS:
        raise UnknownNameError("command", name, COMMANDS)
    command = command_class(name)
    with one_line_errors(rest, command):
        return tyro.cli(command, prog=f"hexwar {name}", args=rest, config=_CONFIG)


def command_class(name: str) -> Callable[..., Any]:
    """Import the dataclass of a sub-command."""
    found: Callable[..., Any] = resolve_name(f"hexwar_sb3.commands.{COMMANDS[name]}")
    return found


def _overview(arguments: Sequence[str]) -> Any:
    """Answer flags that stand before any sub-command: help, or an error."""
    with one_line_errors(arguments):
        return tyro.extras.subcommand_cli_from_dict(
            {name: type(name, (), {"__doc__": _summary(place)}) for name, place in COMMANDS.items()},
            prog="hexwar",
            description="A war game on hexagons under fog, and commanders that learn it.",
            args=arguments,
            config=_CONFIG,
        )


def _summary(place: str) -> str:
    """First line of what a sub-command says of itself, read from its source without importing it."""
    module, _, name = place.partition(":")
    source = Path(__file__).with_name("commands") / f"{module}.py"
    classes = (node for node in ast.parse(source.read_bytes()).body if isinstance(node, ast.ClassDef))
    says = next(filter(None, (ast.get_docstring(node) for node in classes if node.name == name)))
    return says.splitlines()[0]


if __name__ == "__main__":
    main()
