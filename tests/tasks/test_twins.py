"""Every kernel of tasks, routes and execution gives the same bits compiled and as plain Python."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = """
import hashlib, sys
sys.path.insert(0, sys.argv[1])
from conftest import OPEN_FIELD, Board, sticky_choice
from hexwar_sb3.engine.text import parse_board
from hexwar_sb3.engine.world import load_world
from hexwar_sb3.rules.enums import Action

near = OPEN_FIELD.replace("blue  tank 3811", "blue  tank 1211").replace("blue  chariot 3612", "blue  chariot 0916")
board = Board(load_world(parse_board(near).scenario), seed=3)
board.look()
digest = hashlib.sha256()
for decision in range(5):
    for camp in (0, 1):
        for value in board.observation(camp).values():
            digest.update(value.tobytes())
    board.play(75, sticky_choice(9))
    digest.update(board.pieces.tobytes() + board.missions.tobytes() + board.memory.tobytes())
print(digest.hexdigest(), board.actions[Action.SHOOT])
"""


def play(disable_jit: str) -> str:
    env = os.environ | {"NUMBA_DISABLE_JIT": disable_jit}
    command = [sys.executable, "-c", SCRIPT, str(Path(__file__).parent)]
    return subprocess.run(command, env=env, check=True, capture_output=True, text=True).stdout


@pytest.mark.timeout(300)
def test_compiled_and_plain_python_agree_to_the_bit() -> None:
    """Five decisions of a game of random tasks with contact from the start: sets, rows, orders, results."""
    compiled, plain = play("0"), play("1")

    assert compiled == plain
    assert int(compiled.split()[1]) > 0
