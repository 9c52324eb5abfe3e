"""Where a study lives: a journal file in its folder, or any database that Optuna knows by URL."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from filelock import FileLock
from optuna.exceptions import ExperimentalWarning, StorageInternalError
from optuna.storages import BaseStorage, JournalStorage, RDBStorage
from optuna.storages.journal import JournalFileBackend, JournalFileSymlinkLock
from sqlalchemy.exc import IntegrityError, ProgrammingError, SQLAlchemyError
from sqlalchemy.pool import NullPool

from hexwar_sb3.errors import ConfigError, FileFormatError, HexWarError
from hexwar_sb3.files import check_held
from hexwar_sb3.tuning.workers import comes_again

HEARTBEAT_S, GRACE_S = 30, 120  # of trials in a database: who is silent for longer is dead
BEGINNERS = 5  # tries to make tables, each after another process has made some of them
JOURNAL = "study.journal"
LONGEST_ENTRY = 1 << 20  # bytes of a line of it


def open_storage(folder: Path, url: str | None = None) -> BaseStorage:
    """Open a study's storage.

    Args:
        folder: of the study; its journal lies there.
        url: of a database instead, as "sqlite:///study.db" or "postgresql+psycopg://user@host/base".

    Raises:
        ConfigError: there is no such database, or nothing that speaks to it.
        FileFormatError: the journal is broken.
    """
    if url is None:
        return _open_journal(folder / JOURNAL)
    if url in ("sqlite://", "sqlite:///:memory:"):
        raise ConfigError("the study's database: one in memory is not shared by processes")
    try:
        with database_errors(), warnings.catch_warnings(action="ignore", category=ExperimentalWarning):
            return _open_database(url)
    except HexWarError:
        raise
    except ImportError as error:
        raise ConfigError(f"the study's database: {error}") from error
    except (ValueError, KeyError) as error:  # whose text may be a part of a password
        raise ConfigError("the study's database: its URL is not understood") from error
    except RuntimeError as error:
        raise ConfigError(f"the study's database: {str(error).splitlines()[0]}") from error


def _open_database(url: str) -> RDBStorage:
    """Open a database, and make its tables; again where another machine makes them at this moment."""
    for tries_left in reversed(range(BEGINNERS)):
        try:
            return RDBStorage(
                url,
                engine_kwargs={"poolclass": NullPool},  # nothing stays open behind a refused or a dropped one
                heartbeat_interval=HEARTBEAT_S,
                grace_period=GRACE_S,
                heartbeat_stale_trial_callback=comes_again,
            )
        except (IntegrityError, ProgrammingError):
            if not tries_left:
                raise
    raise AssertionError


@contextmanager
def database_errors() -> Iterator[None]:
    """Say in one line what a database does not do.

    Raises:
        ConfigError: it cannot be reached, is locked, broken, or gone.
    """
    try:
        yield
    except (SQLAlchemyError, StorageInternalError) as error:
        cause = error.__cause__ if isinstance(error, StorageInternalError) and error.__cause__ else error
        raise ConfigError(f"the study's database: {str(cause).splitlines()[0]}") from error


class _Lock(JournalFileSymlinkLock):
    """A lock that ends with its process, also a killed one: Optuna's own would be waited for, half a minute.

    It has nothing of its base but the type that Optuna asks for, whose root is not public.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(str(path))
        self._file = FileLock(path)

    def acquire(self) -> bool:
        check_held(Path(self._file.lock_file).parent)  # it makes folders
        self._file.acquire()
        return True

    def release(self) -> None:
        self._file.release()


class _Journal(JournalFileBackend):
    """A journal whose entries are whole lines: what a full disk or a kill leaves of one is cut off."""

    def __init__(self, path: Path) -> None:
        self._path, self._own_lock = path, _Lock(path.with_suffix(".lock"))
        super().__init__(str(path), lock_obj=self._own_lock)
        self.cut_off()
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - LONGEST_ENTRY))
            *_, last, _ = b"null", *file.read().rsplit(b"\n", 2)
        json.loads(last)  # Optuna waits for the end of a last line that it cannot read

    def append_logs(self, logs: list[dict[str, Any]]) -> None:
        self.cut_off()
        try:
            super().append_logs(logs)
        except OSError:
            self.cut_off()
            raise

    def cut_off(self) -> None:
        """Drop what follows the end of the last line.

        Raises:
            ValueError: no line ends.
        """
        self._own_lock.acquire()
        try:
            with self._path.open("rb+") as file:
                size = file.seek(0, os.SEEK_END)
                file.seek(max(0, size - 1))
                if file.read() not in (b"", b"\n"):
                    file.seek(max(0, size - LONGEST_ENTRY))
                    _, end, rest = file.read().rpartition(b"\n")
                    if not end:
                        raise ValueError("no line ends")
                    file.truncate(size - len(rest))
        finally:
            self._own_lock.release()


def _open_journal(path: Path) -> JournalStorage:
    check_held(path.parent)
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.exists() and not path.is_file():  # a pipe would be waited for
        raise FileFormatError(path, "file", found="no regular file", expected="a study's journal")
    try:
        return JournalStorage(_Journal(path))
    except OSError:
        raise
    except Exception as error:  # whatever a stranger's file leads to
        found = f"{type(error).__name__}: {error}"[:80]
        raise FileFormatError(path, "file", found=found, expected="a study's journal") from error
