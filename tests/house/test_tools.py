"""The tools look at the whole tree: a checker that skips a folder reports success."""

from __future__ import annotations

from pathlib import Path

import grimp
from mypy.find_sources import create_source_list
from mypy.fscache import FileSystemCache
from mypy.options import Options


def python_files(root: Path) -> set[Path]:
    """Every file; of a folder that opens with a stub, the stub."""
    folders = ("hexwar_sb3", "callbacks", "policies", "tuning", "tests")
    files = {path.resolve() for folder in folders for path in (root / folder).rglob("*.py")}
    return {stub if (stub := path.with_suffix(".pyi")).exists() else path for path in files}


def test_the_type_checker_reads_every_file(root: Path) -> None:
    options = Options()
    options.explicit_package_bases = True
    options.mypy_path = [str(root)]

    sources = create_source_list([str(root / "hexwar_sb3"), str(root / "tests")], options, FileSystemCache())

    assert {Path(source.path).resolve() for source in sources if source.path} == python_files(root)


def test_the_layer_checker_reads_every_module(root: Path) -> None:
    modules = grimp.build_graph("hexwar_sb3", cache_dir=None).modules

    ours = {path for path in python_files(root) if "tests" not in path.relative_to(root).parts}

    assert len(modules) == len(ours)
