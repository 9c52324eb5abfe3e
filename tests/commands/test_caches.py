"""What lies in the cache is sorted by who can use it, and only what nobody here uses is deleted."""

from __future__ import annotations

from pathlib import Path

import pytest

from hexwar_sb3.cache import Cache
from hexwar_sb3.commands import caches
from hexwar_sb3.commands.caches import (
    EARLIER,
    IN_USE,
    MAPS,
    OTHER_PYTHON,
    OTHER_SOURCES,
    clean,
    describe,
    lots,
)
from hexwar_sb3.envs import prepare
from hexwar_sb3.kernels import source_hash, toolchain

OTHER = "kernels-00000000000000ff"
KEY = "0123456789abcdef"


@pytest.fixture
def filled(tmp_path: Path) -> dict[str, Path]:
    """Files of a cache folder by their kind; the last one is a stranger's."""
    ours = source_hash(Path(prepare.__file__))
    files = {
        IN_USE: tmp_path / toolchain() / f"prepared-{ours}.list",
        OTHER_SOURCES: tmp_path / toolchain() / f"step.advance-{KEY}-{KEY}.kernel",
        OTHER_PYTHON: tmp_path / OTHER / f"step.advance-{KEY}-{KEY}.kernel",
        EARLIER: tmp_path / OTHER / "engine_0123" / "step.advance-12.py311.nbi",
        MAPS: tmp_path / "terrain" / f"{KEY}-los.table",
        "no file of ours": tmp_path / "terrain" / "thesis.txt",
    }
    for path in files.values():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(bytes(1_000_000))
    return files


def test_files_are_sorted_by_who_can_use_them(filled: dict[str, Path], tmp_path: Path) -> None:
    found = {kind: lot.paths for kind, lot in lots(tmp_path).items()}
    assert found == {kind: [path] for kind, path in filled.items() if kind in found}
    assert len(found) == 5


def test_kernels_of_this_version_are_in_use() -> None:
    kernels = Path(prepare.__file__).parents[1] / "engine" / "step.py"
    assert source_hash(kernels) in caches.current_sources()


def test_what_nobody_here_uses_is_deleted_and_nothing_else(filled: dict[str, Path], tmp_path: Path) -> None:
    freed = clean(tmp_path)
    left = {kind for kind, path in filled.items() if path.exists()}

    assert freed == 3_000_000
    assert left == {IN_USE, MAPS, "no file of ours"}
    assert not (tmp_path / OTHER).exists()
    assert clean(tmp_path) == 0


def test_each_kind_is_told_with_its_size(filled: dict[str, Path], tmp_path: Path) -> None:
    said = dict(describe(Cache(tmp_path), tmp_path))

    assert len(filled) == 6
    assert said["kernels in use"].startswith("1 MB, 1 files, used last today: ")
    assert said["to delete them"] == "hexwar doctor --clean frees 3 MB"
    assert str(tmp_path) in said["to delete all"]


def test_an_empty_cache_has_nothing_to_delete(tmp_path: Path) -> None:
    assert [name for name, _ in describe(Cache(tmp_path), tmp_path)] == ["to delete all"]


def test_kernels_say_for_which_versions_they_are(tmp_path: Path) -> None:
    cache = Cache(tmp_path)
    assert caches.made_for(cache, OTHER) == "of versions that are not known"
    assert cache.keep(OTHER, f"prepared-{KEY}.list", b"hexwar_sb3 0.2.0, Python 3.12.1\na.kernel\nb.kernel")
    assert caches.made_for(cache, OTHER) == "hexwar_sb3 0.2.0, Python 3.12.1"
    assert cache.keep(OTHER, f"step.advance-{KEY}-{KEY}.kernel", b"code")
    assert "hexwar_sb3 0.2.0, Python 3.12.1" in dict(describe(cache, tmp_path))["of other Pythons"]


def test_what_is_compiled_ahead_says_for_which_versions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cache = Cache(tmp_path)
    monkeypatch.setattr(prepare, "cache", lambda: cache)
    monkeypatch.setattr(prepare, "_compile", lambda: True)
    prepare.prepare(lambda _: None)

    assert caches.made_for(cache, toolchain()).startswith("hexwar_sb3 ")
    assert prepare._is_prepared()
