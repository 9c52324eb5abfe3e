"""What other systems lack."""

from __future__ import annotations

import subprocess
import sys

IMPORT_ALL = """
import builtins, importlib, pkgutil, sys
HIDDEN = {"resource", "fcntl", "pwd", "grp", "termios", "tty", "pty", "posix", "syslog", "readline"}
first = builtins.__import__

def without(name, globals=None, locals=None, fromlist=(), level=0):
    if name in HIDDEN and (globals or {}).get("__name__", "").startswith("hexwar_sb3"):
        raise ImportError(name)
    return first(name, globals, locals, fromlist, level)

builtins.__import__ = without
import hexwar_sb3
names = [one.name for one in pkgutil.walk_packages(hexwar_sb3.__path__, "hexwar_sb3.")]
for name in names:
    importlib.import_module(name)
from hexwar_sb3.league.cost import _peak_of, peak_mb
from hexwar_sb3.league import cost
cost._peak_of = lambda _: None
print(len(names), peak_mb())
"""


def test_every_module_can_be_imported_where_there_is_no_posix() -> None:
    done = subprocess.run([sys.executable, "-c", IMPORT_ALL], capture_output=True, text=True, check=False)

    assert done.returncode == 0, done.stderr
    count, peak = done.stdout.split()
    assert int(count) > 150
    assert float(peak) == 0.0
