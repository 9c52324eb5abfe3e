"""How commands begin and end on a console: one line for a mistake, silence where nobody reads, characters that it has."""

from __future__ import annotations

import codecs
import io
import os
import re
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, suppress
from shutil import get_terminal_size
from typing import Any, TextIO

from hexwar_sb3.errors import ConfigError, HexWarError, UnknownNameError
from hexwar_sb3.processes import end_with_parent, keep_memory

USER_ERROR, INTERRUPTED, BROKEN_PIPE = 2, 130, 141  # exit codes
LEAST_COLUMNS = 40  # of help; on narrower terminals its layout does not end
FRAME = {"─": "-", "│": "|", "•": "*"} | dict.fromkeys("╭╮╰╯├┤┬┴┼", "+")  # of help, in ASCII
Failure = (
    HexWarError,
    OSError,
    MemoryError,
    UnicodeError,
)  # UnicodeError: a name that this system cannot write


def carry_out(program: str, action: Callable[[], int], stopped: str = "stopped") -> int:
    """Run a command; return its exit code.

    A mistake of the user's or trouble of the system's ends in one line; a reader who has seen enough (`| head`) in none.

    Args:
        program: what the line begins with.
        action: the command; returns its exit code, or raises.
        stopped: said after Ctrl-C.
    """
    end_with_parent()
    keep_memory()
    _make_ready()
    try:
        with _quiet_threads():
            code = _code_of(action)
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
    except BrokenPipeError:
        code = BROKEN_PIPE
    except Failure as error:
        told = " ".join(str(error).split("\n")) or "not enough memory"
        code = _complain(f"{program}: {told}", USER_ERROR)
    except KeyboardInterrupt:
        code = _complain(f"{program}: {stopped}", INTERRUPTED)
    for stream in (sys.stdout, sys.stderr):
        _give_up_where_nobody_reads(stream)
    return code


def _code_of(action: Callable[[], int]) -> int:
    try:
        return action()
    except SystemExit as end:  # of help
        return end.code if isinstance(end.code, int) else int(end.code is not None)


@contextmanager
def _quiet_threads() -> Iterator[None]:
    """Let threads that can no longer write end without a traceback: TensorBoard tells the one that waits for it."""
    before = threading.excepthook

    def hook(failed: threading.ExceptHookArgs) -> None:
        if not issubclass(failed.exc_type, OSError):
            before(failed)

    threading.excepthook = hook
    try:
        yield
    finally:
        threading.excepthook = before


def _complain(text: str, code: int) -> int:
    with suppress(OSError):
        print(text, file=sys.stderr, flush=True)
    return code


def _give_up_where_nobody_reads(stream: TextIO) -> None:
    """Write to nowhere what is left, so that the end of the process says nothing of it."""
    try:
        stream.flush()
    except OSError:
        with suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _make_ready() -> None:
    """Make streams that take every text, also where one was closed or knows few characters."""
    while (handle := os.open(os.devnull, os.O_RDWR)) <= 2:  # takes the number of one that was closed
        os.set_inheritable(handle, True)
    os.close(handle)
    codecs.register_error("hexwar", _in_ascii)
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115, PTH123  # to the end
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="hexwar")
    if get_terminal_size().columns < LEAST_COLUMNS:
        os.environ["COLUMNS"] = str(LEAST_COLUMNS)


def _in_ascii(error: UnicodeError) -> tuple[str | bytes, int]:
    """Characters that a stream lacks: frames as ASCII draws them, others by their numbers."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = error.object[error.start : error.end]
    return "".join(FRAME.get(one) or ascii(one)[1:-1] for one in text), error.end


@contextmanager
def one_line_errors(arguments: Sequence[str], command: Any = None) -> Iterator[None]:
    """Let what is wrong with arguments be an error of one line, not tyro's box.

    Args:
        arguments: that are parsed in the block.
        command: dataclass whose fields are the flags.

    Raises:
        UnknownNameError: there is no such flag.
        ConfigError: anything else.
    """
    said = io.StringIO()
    try:
        with redirect_stderr(said):
            yield
    except SystemExit as end:
        if not end.code:
            raise
        _find_unknown(arguments, command)
        raise ConfigError(_in_words(_first_part(said.getvalue()))) from end


def _find_unknown(arguments: Sequence[str], command: Any) -> None:
    """Raise UnknownNameError for the first flag that is none."""
    fields = [name.replace("_", "-") for name in getattr(command, "__dataclass_fields__", ())]
    flags = {"--help", *(f"--{name}" for name in fields)}
    for argument in arguments:
        flag = argument.partition("=")[0].replace("_", "-")
        if flag.startswith("--") and flag not in flags and f"--{flag[5:]}" not in flags:
            raise UnknownNameError("flag", argument.partition("=")[0], flags)


def _in_words(said: str) -> str:
    """What tyro says of a value that is none, in the words of our errors; other texts as they are."""
    for pattern, kinds in _NOT_READ:
        if matched := re.match(rf"Error parsing (-[/\w-]+): {pattern}", said):
            found, names = matched["found"], (kinds or matched["kinds"]).split("|")
            expected = " or ".join(_KINDS.get(name, name) for name in sorted(names, key="{None}".__eq__))
            return f"{matched[1]} must be {expected}, got {found}"
    return said


_NOT_READ = (
    (r"no type matching (?P<kinds>\S+) could be instantiated from \[(?P<found>[^\]]*)\]", ""),
    (r"invalid literal for int\(\) with base 10: (?P<found>.+)", "INT"),
    (r"could not convert string to float: (?P<found>.+)", "FLOAT"),
)
_KINDS = {"INT": "a whole number", "FLOAT": "a number", "{None}": "None", "PATH": "a path", "STR": "a text"}


def _first_part(box: str) -> str:
    """What a box of tyro's says up to its first rule, as one line; in ASCII its title stands over a rule, too."""
    lines = [line.strip("│ ") for line in box.splitlines() if not line.startswith(("╭", "╰"))]
    parts = re.split(r" (?:─+|-{9,}) ", " ".join(lines))
    return parts[0 if box.startswith("╭") else 1 % len(parts)].strip()
