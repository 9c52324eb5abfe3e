"""The cache folder: found whatever the settings say, never trusted blindly, never in the way, and pruned."""

from __future__ import annotations

import errno
import logging
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from hexwar_sb3 import cache as cache_module
from hexwar_sb3.cache import HEAD_BYTES, Cache, cache, cache_root

PART, NAME = "terrain", "0123456789abcdef-eta.table"
needs_posix = pytest.mark.skipif(os.name != "posix", reason="rights of files are others there")


@pytest.fixture(autouse=True)
def own_temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of temporary files of the test's own."""
    folder = tmp_path / "tmp"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    cache_module._temporary.cache_clear()
    return folder


# --- where it lies -----------------------------------------------------------------------------------

HERE = Path(cache_module._start)
FOUND: list[tuple[dict[str, str | None], Path | None]] = [
    ({"HEXWAR_CACHE": "/a/b", "HOME": "/home/me"}, Path("/a/b")),
    ({"HEXWAR_CACHE": "a/b", "HOME": "/home/me"}, HERE / "a/b"),
    ({"HEXWAR_CACHE": ".", "HOME": "/home/me"}, HERE),
    ({"HEXWAR_CACHE": "~/c", "HOME": "/home/me"}, Path("/home/me/c")),
    ({"HEXWAR_CACHE": "~nobody-of-this-name/c", "HOME": "/home/me"}, None),
    ({"HEXWAR_CACHE": "", "HOME": "/home/me"}, Path("/home/me/.cache/hexwar_sb3")),
    ({"HEXWAR_CACHE": "", "XDG_CACHE_HOME": "/x", "HOME": "/home/me"}, Path("/x/hexwar_sb3")),
    ({"XDG_CACHE_HOME": "/x"}, Path("/x/hexwar_sb3")),
    ({"XDG_CACHE_HOME": "", "HOME": "/home/me"}, Path("/home/me/.cache/hexwar_sb3")),
    ({"XDG_CACHE_HOME": "x/y", "HOME": "/home/me"}, Path("/home/me/.cache/hexwar_sb3")),
    ({"XDG_CACHE_HOME": "~/x", "HOME": "/home/me"}, Path("/home/me/.cache/hexwar_sb3")),
    ({"HOME": ""}, None),
    ({"HOME": "relative"}, None),
    ({"XDG_CACHE_HOME": "", "HOME": ""}, None),
]


@needs_posix
@pytest.mark.parametrize(("settings", "expected"), FOUND, ids=str)
def test_the_folder_is_found_whatever_the_settings_say(
    settings: dict[str, str], expected: Path | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("HEXWAR_CACHE", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in settings.items():
        monkeypatch.setenv(name, value)
    assert cache_root() == expected


@needs_posix
def test_a_user_without_any_home_has_no_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("HEXWAR_CACHE", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("pwd.getpwuid", lambda _uid: (_ for _ in ()).throw(KeyError("no such user")))
    assert cache_root() is None
    assert cache().trouble == "there is no home folder"


def test_a_relative_folder_stays_where_it_was_when_the_program_moves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HEXWAR_CACHE", "here")
    before = cache_root()
    monkeypatch.chdir(tmp_path)
    assert cache_root() == before


def test_the_program_starts_in_a_folder_that_was_removed(tmp_path: Path) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    looks = "import os, string\nos.rmdir(os.getcwd())\ntry:\n string.no_such\nexcept AttributeError: pass"
    if subprocess.run([sys.executable, "-c", looks], cwd=gone, capture_output=True, check=False).returncode:
        pytest.skip(
            "this Python (3.13.0) cannot look for a name in a module there, so numpy cannot be imported"
        )
    gone.mkdir()
    code = "import os, sys; os.rmdir(os.getcwd()); from hexwar_sb3.cache import cache; print(cache().place is not None)"
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "HEXWAR_CACHE": str(tmp_path / "cache")}
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=gone, env=env, capture_output=True, text=True, check=True
    )
    assert run.stdout == "True\n"


# --- folders that cannot be used ----------------------------------------------------------------------


def a_file(folder: Path) -> Path:
    folder.write_text("no folder")
    return folder


def below_a_file(folder: Path) -> Path:
    return a_file(folder) / "below"


def a_link_to_itself(folder: Path) -> Path:
    folder.symlink_to(folder)
    return folder


def a_link_to_nowhere_that_can_be_made(folder: Path) -> Path:
    folder.symlink_to("/proc/nowhere/at all")
    return folder


def of_the_system(folder: Path) -> Path:  # noqa: ARG001
    return Path("/proc/hexwar_sb3")


def a_name_too_long(folder: Path) -> Path:
    return folder / ("x" * 5000)


def a_pipe(folder: Path) -> Path:
    os.mkfifo(folder)
    return folder


def of_another_user(folder: Path) -> Path:
    if os.geteuid() != 0:
        pytest.skip("only the administrator can give a folder away")
    folder.mkdir()
    os.chown(folder, 12345, 12345)
    return folder


def open_to_everybody(folder: Path) -> Path:
    folder.mkdir()
    folder.chmod(0o777)
    return folder


def open_to_everybody_with_rules(folder: Path) -> Path:
    folder.mkdir()
    folder.chmod(0o1777)
    return folder


def not_writable(folder: Path) -> Path:
    folder.mkdir(mode=0o500)
    if os.access(folder, os.W_OK):
        pytest.skip("the administrator may write everywhere")
    return folder


UNUSABLE = [
    *(a_file, below_a_file, a_link_to_itself, a_link_to_nowhere_that_can_be_made, of_the_system),
    *(
        a_name_too_long,
        a_pipe,
        of_another_user,
        open_to_everybody,
        open_to_everybody_with_rules,
        not_writable,
    ),
]


@needs_posix
@pytest.mark.parametrize("make", UNUSABLE)
def test_what_cannot_be_kept_in_the_folder_is_kept_in_a_private_one_and_that_is_said_once(
    make: Callable[[Path], Path], tmp_path: Path, own_temporary: Path, caplog: pytest.LogCaptureFixture
) -> None:
    named = make(tmp_path / "cache")
    one = Cache(named)
    assert one.read(PART, NAME) is None
    assert not caplog.records
    assert one.keep(PART, NAME, b"table")
    assert one.keep(PART, "other.table", b"table")
    assert one.read(PART, NAME) == b"table"
    assert Cache(named).read(PART, NAME) == b"table"
    assert [path.name for path in own_temporary.iterdir()] == [f"hexwar_sb3-{os.geteuid()}"]
    assert next(own_temporary.iterdir()).stat().st_mode & 0o777 == 0o700
    (record,) = caplog.records
    assert str(named) in record.getMessage()
    assert "set HEXWAR_CACHE" in record.getMessage()
    assert "\n" not in record.getMessage()


@needs_posix
@pytest.mark.parametrize("taken", [a_file, a_link_to_itself, a_pipe, of_another_user, open_to_everybody])
def test_without_any_folder_nothing_is_kept_and_nothing_breaks(
    taken: Callable[[Path], Path], tmp_path: Path, own_temporary: Path, caplog: pytest.LogCaptureFixture
) -> None:
    taken(own_temporary / f"hexwar_sb3-{os.geteuid()}")
    one = Cache(a_file(tmp_path / "cache"))
    assert one.place is None
    assert not one.keep(PART, NAME, b"table")
    assert one.read(PART, NAME) is None
    one.prune()
    assert "compiles" in caplog.text


@needs_posix
def test_what_others_could_have_put_there_is_not_read(tmp_path: Path) -> None:
    assert Cache(tmp_path / "cache").keep(PART, NAME, b"table")
    for folder in (tmp_path / "cache", tmp_path / "cache" / PART):
        folder.chmod(0o777)
        assert Cache(tmp_path / "cache").read(PART, NAME) is None
        folder.chmod(0o755)
        assert Cache(tmp_path / "cache").read(PART, NAME) == b"table"


@needs_posix
def test_a_new_folder_is_its_owners_alone(tmp_path: Path) -> None:
    assert Cache(tmp_path / "a" / "cache").place
    assert (tmp_path / "a" / "cache").stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO])
def test_a_disk_that_takes_no_more_costs_time_only_and_that_is_said_once(
    code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    one = Cache(tmp_path)

    def full(*_: object) -> bytes:
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(cache_module, "_head", full)
    assert not one.keep(PART, NAME, b"table")
    assert not one.keep(PART, "other.table", b"table")
    assert one.lost == {NAME, "other.table"}
    assert len(caplog.records) == 1
    assert list((tmp_path / PART).iterdir()) == []


def test_a_folder_that_went_away_is_made_anew(tmp_path: Path) -> None:
    one = Cache(tmp_path / "cache")
    assert one.place
    (tmp_path / "cache").rmdir()
    assert one.keep(PART, NAME, b"table")
    assert one.read(PART, NAME) == b"table"


def test_workers_say_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(cache_module, "parent_process", lambda: "somebody")
    assert Cache(a_file(tmp_path / "cache")).place
    assert not caplog.records


def test_by_default_the_line_goes_to_the_terminal_without_a_frame(tmp_path: Path) -> None:
    code = "from hexwar_sb3.cache import cache; cache().place; cache().place"
    env = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(sys.path),
        "HEXWAR_CACHE": str(a_file(tmp_path / "cache")),
    }
    run = subprocess.run([sys.executable, "-c", code], env=env, capture_output=True, text=True, check=True)
    assert run.stderr.startswith("cannot use the cache folder")
    assert len(run.stderr.splitlines()) == 1
    assert not logging.getLogger("hexwar_sb3").handlers


# --- files that do not fit ----------------------------------------------------------------------------

DATA = bytes(range(256)) * 40
AROUND_THE_HEAD = (HEAD_BYTES - 1, HEAD_BYTES, HEAD_BYTES + 1)


def cut(n: int, old: bytes) -> bytes:
    return old[:n]


def flip(n: int, old: bytes) -> bytes:
    changed = bytearray(old)
    changed[n] ^= 4
    return bytes(changed)


DAMAGE: dict[str, Callable[[bytes], bytes]] = {
    "nothing": lambda _: b"",
    "garbage": lambda _: os.urandom(20_000),
    "zeros": lambda old: bytes(len(old)),
    "a byte more": lambda old: old + b"\0",
    "two files": lambda old: old + old,
    "swapped words": lambda old: (
        old[:HEAD_BYTES] + old[-8:] + old[HEAD_BYTES + 8 : -8] + old[HEAD_BYTES : HEAD_BYTES + 8]
    ),
    "the data alone": lambda old: old[HEAD_BYTES:],
    **{f"cut at {n}": partial(cut, n) for n in (1, 100, *AROUND_THE_HEAD, -1)},
    **{f"a flip at {n}": partial(flip, n) for n in (0, 20, 60, 200, *AROUND_THE_HEAD, HEAD_BYTES + 5000, -1)},
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_file_is_as_good_as_none(damage: str, tmp_path: Path) -> None:
    one = Cache(tmp_path)
    assert one.keep(PART, NAME, DATA)
    path = tmp_path / PART / NAME
    path.write_bytes(DAMAGE[damage](path.read_bytes()))
    assert one.read(PART, NAME) is None
    assert one.map(PART, NAME, "", len(DATA)) is None


def test_a_file_of_another_name_kind_or_size_is_as_good_as_none(tmp_path: Path) -> None:
    one = Cache(tmp_path)
    assert one.keep(PART, NAME, DATA, "u1 (2, 5120)")
    (tmp_path / PART / "other").write_bytes((tmp_path / PART / NAME).read_bytes())
    mapped = one.map(PART, NAME, "u1 (2, 5120)", len(DATA))
    assert mapped is not None
    assert bytes(mapped) == DATA
    assert mapped.readonly
    assert one.map(PART, "other", "u1 (2, 5120)", len(DATA)) is None
    assert one.map(PART, NAME, "i1 (2, 5120)", len(DATA)) is None
    assert one.map(PART, NAME, "u1 (5120, 2)", len(DATA)) is None
    assert one.map(PART, NAME, "u1 (2, 5120)", len(DATA) - 1) is None


@needs_posix
@pytest.mark.parametrize(
    "make", [a_pipe, a_link_to_itself, open_to_everybody, lambda path: path.symlink_to("/dev/zero")]
)
def test_what_is_no_file_is_neither_waited_for_nor_read(
    make: Callable[[Path], object], tmp_path: Path
) -> None:
    one = Cache(tmp_path)
    (tmp_path / PART).mkdir()
    make(tmp_path / PART / NAME)
    assert one.read(PART, NAME) is None
    assert one.map(PART, NAME, "", len(DATA)) is None


# --- what is too old ----------------------------------------------------------------------------------

OURS = (
    "kernels-0123456789abcdef/step.advance-0123456789abcdef-0123456789abcdef.kernel",
    "kernels-0123456789abcdef/prepared-0123456789abcdef.list",
    "kernels-0123456789abcdef/.new-step.advance-x.kernel",
    "kernels-0123456789abcdef/engine_0123456789/step.advance-12.py311.nbi",
    "kernels-0123456789abcdef/engine_0123456789/step.advance-12.py311.1.nbc",
    "kernels-0123456789abcdef/engine_0123456789/step.advance-12.py311.1.nbc.tmp.0123456789abcdef",
    "prepared-0123456789abcdef",
    "terrain/0123456789abcdef-eta.npy",
    "terrain/0123456789abcdef-eta.table",
    "terrain/.new-0123456789abcdef-eta-x.table",
)
OTHERS = (
    *("thesis.txt", "terrain/heights.npy", "kernels-of-mine/a.kernel", "kernels-0123456789abcdef/notes.txt"),
    *("kernels-0123456789abcdef/a/b/c.nbi", "prepared-meal", "other/0123456789abcdef-eta.npy", ".new-x"),
)


def fill(root: Path, names: tuple[str, ...], days: float) -> None:
    for name in names:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text("x")
        then = time.time() - days * 86_400
        os.utime(root / name, (then, then))


def test_what_nobody_used_for_a_month_is_removed_and_nothing_else(tmp_path: Path) -> None:
    fill(tmp_path, OURS + OTHERS, days=31)
    (tmp_path / "kernels-fedcba9876543210").symlink_to(tmp_path / "other")
    (tmp_path / "kernels-empty").mkdir()
    Cache(tmp_path).prune()
    left = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()}
    assert left >= set(OTHERS)
    assert not left & set(OURS)
    assert (tmp_path / "kernels-empty").is_dir()
    assert not (tmp_path / "kernels-0123456789abcdef" / "engine_0123456789").exists()


def test_what_was_used_within_a_month_stays(tmp_path: Path) -> None:
    fill(tmp_path, OURS, days=29)
    Cache(tmp_path).prune()
    assert all((tmp_path / name).is_file() for name in OURS)


def test_reading_is_use(tmp_path: Path) -> None:
    one = Cache(tmp_path)
    uses: dict[str, Callable[[str], object]] = {
        "0123456789abcdef-read.table": lambda name: one.read(PART, name),
        "0123456789abcdef-map.table": lambda name: one.map(PART, name, "", 4),
        "0123456789abcdef-use.table": lambda name: one.use(PART, [name]),
        "0123456789abcdef-none.table": lambda _: None,
    }
    for name, use in uses.items():
        assert one.keep(PART, name, b"data")
        os.utime(tmp_path / PART / name, (0, 0))
        use(name)
    one.prune()
    left = [path.name for path in (tmp_path / PART).iterdir()]
    assert sorted(left) == [f"0123456789abcdef-{name}.table" for name in ("map", "read", "use")]


def test_the_folder_is_looked_through_once_a_day(tmp_path: Path) -> None:
    Cache(tmp_path).prune()
    fill(tmp_path, OURS, days=31)
    Cache(tmp_path).prune()
    assert all((tmp_path / name).is_file() for name in OURS)


def test_use_tells_what_is_missing(tmp_path: Path) -> None:
    one = Cache(tmp_path)
    assert one.use(PART, [])
    assert not one.use(PART, [NAME])
    assert one.keep(PART, NAME, b"data")
    assert one.use(PART, [NAME])
    assert one.names(PART) == [NAME]
