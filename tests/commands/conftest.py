"""Running `hexwar` inside the test's own process."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from hexwar_sb3.cli import main


@pytest.fixture
def hexwar(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Run `hexwar` with some arguments; exit code, standard output, standard error."""

    def run(*arguments: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as end:
            main(arguments)
        out, err = capsys.readouterr()
        return int(end.value.code or 0), out, err

    return run
