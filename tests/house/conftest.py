"""What the tests of the house share: the root, and a copy of it as a ZIP download leaves it."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LINKS = ("callbacks", "policies", "tuning")


@pytest.fixture(scope="session")
def root() -> Path:
    return ROOT


@pytest.fixture
def unlinked_copy(root: Path, tmp_path: Path) -> Path:
    """A copy of the sources in which every link arrived as a text file that names its target."""
    copy = tmp_path / "copy"
    skip = shutil.ignore_patterns("__pycache__", "*.egg-info")
    for folder in LINKS:
        shutil.copytree(root / folder, copy / folder, ignore=skip)
    shutil.copytree(root / "hexwar_sb3", copy / "hexwar_sb3", symlinks=True, ignore=skip)
    for name in ("setup.cfg", "pyproject.toml", "README.md", "LICENSE", "MANIFEST.in"):
        shutil.copy(root / name, copy / name)
    for folder in LINKS:
        (copy / "hexwar_sb3" / folder).unlink()
        (copy / "hexwar_sb3" / folder).write_text(f"../{folder}", encoding="utf-8")
    return copy
