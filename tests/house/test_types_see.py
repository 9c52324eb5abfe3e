"""The type checker sees swapped indices and misspelt fields in kernels: eight plants, one answer each."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest


class Plant(NamedTuple):
    """A line that is spoilt, and what the checker is to say of it."""

    file: str
    line: str
    spoilt: str
    answer: str


PLANTS = {
    "camp and piece swapped": Plant(
        "engine/sight.py", "elif memory[camp, j].seen:", "elif memory[j, camp].seen:", "Invalid index type"
    ),
    "camp for piece": Plant(
        "engine/sight.py",
        "            if pieces[i].camp == camp:",
        "            if pieces[camp].camp == camp:",
        'Invalid index type "Camp"',
    ),
    "misspelt field": Plant(
        "engine/harm.py",
        "losses = int(piece.losses_now)",
        "losses = int(piece.loses_now)",
        'maybe "losses_now"',
    ),
    "cell for slot": Plant(
        "bots/drawn.py",
        "s = int(drawn.squad[slot])",
        "s = int(drawn.squad[pieces[0].cell])",
        'Invalid index type "CellIndex"',
    ),
    "piece for cell": Plant(
        "bots/ladder.py",
        "apart = cells_apart(cells, pieces[i].cell, memory[camp, j].cell)",
        "apart = cells_apart(cells, i, memory[camp, j].cell)",
        'incompatible type "PieceIndex"; expected "CellIndex"',
    ),
    "cell for point": Plant(
        "bots/duties.py",
        "give_mission(style, i, TaskKind.HOLD, game.point_cell[k], game, missions)",
        "give_mission(style, i, TaskKind.HOLD, game.point_cell[missions[i].cell], game, missions)",
        'Invalid index type "CellIndex"',
    ),
    "arguments swapped": Plant(
        "engine/actions.py",
        "if count_in(pieces, enemy, piece.cell) > 0:",
        "if count_in(pieces, piece.cell, enemy) > 0:",
        'incompatible type "CellIndex"; expected "Camp"',
    ),
    "piece in a field for cells": Plant(
        "tasks/choose.py",
        "mission.goal = NO_CELL",
        "mission.goal = NO_PIECE",
        'variable has type "CellIndex"',
    ),
}


@pytest.mark.slow
def test_every_plant_turns_the_checker_red(root: Path, tmp_path: Path) -> None:
    for folder in ("hexwar_sb3", "callbacks", "policies", "tuning"):
        shutil.copytree(root / folder, tmp_path / folder, symlinks=True)
    shutil.copyfile(root / "setup.cfg", tmp_path / "setup.cfg")
    for plant in PLANTS.values():
        path = tmp_path / "hexwar_sb3" / plant.file
        text = path.read_text(encoding="utf-8")
        assert plant.line in text, plant
        path.write_text(text.replace(plant.line, plant.spoilt), encoding="utf-8")

    command = [sys.executable, "-m", "mypy", "--config-file", "setup.cfg", "hexwar_sb3"]
    said = subprocess.run(command, check=False, cwd=tmp_path, capture_output=True, text=True).stdout

    for name, plant in PLANTS.items():
        lines = (tmp_path / "hexwar_sb3" / plant.file).read_text(encoding="utf-8").splitlines()
        places = [n for n, line in enumerate(lines, 1) if plant.spoilt.strip() in line]
        answers = [
            answer
            for n in places
            for answer in re.findall(rf"{re.escape(plant.file)}:{n}: error: (.*)", said)
        ]
        assert any(plant.answer in answer for answer in answers), (name, answers)
