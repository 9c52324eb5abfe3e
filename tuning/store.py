"""Where a study lives: a journal file in its folder, or any database that Optuna knows by URL."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from optuna.exceptions import ExperimentalWarning, StorageInternalError
from optuna.storages import BaseStorage, JournalStorage, RDBStorage
from optuna.storages.journal import JournalFileBackend
from sqlalchemy.exc import SQLAlchemyError

from hexwar_sb3.errors import ConfigError, FileFormatError
from hexwar_sb3.tuning.workers import comes_again

HEARTBEAT_S, GRACE_S = 30, 120  # of trials in a database: who is silent for longer is dead
JOURNAL = "study.journal"


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
    with database_errors(), warnings.catch_warnings(action="ignore", category=ExperimentalWarning):
        return RDBStorage(
            url,
            heartbeat_interval=HEARTBEAT_S,
            grace_period=GRACE_S,
            heartbeat_stale_trial_callback=comes_again,
        )


@contextmanager
def database_errors() -> Iterator[None]:
    """Say in one line what a database does not do; its URL may hold a password and is not told.

    Raises:
        ConfigError: it cannot be reached, is locked, broken, or gone.
    """
    try:
        yield
    except (SQLAlchemyError, StorageInternalError, ImportError) as error:
        cause = error.__cause__ if isinstance(error, StorageInternalError) and error.__cause__ else error
        raise ConfigError(f"the study's database: {str(cause).splitlines()[0]}") from error


def _open_journal(path: Path) -> JournalStorage:
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        return JournalStorage(JournalFileBackend(str(path)))
    except OSError:
        raise
    except Exception as error:  # whatever a stranger's file leads to
        found = f"{type(error).__name__}: {error}"[:80]
        raise FileFormatError(path, "file", found=found, expected="a study's journal") from error
