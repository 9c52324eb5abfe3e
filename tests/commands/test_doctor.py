"""`hexwar doctor` tells what is wrong last, and by its exit code."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from hexwar_sb3.commands import doctor, installed
from hexwar_sb3.commands.doctor import Doctor

Command = Callable[..., tuple[int, str, str]]


@pytest.fixture(autouse=True)
def without_a_game(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Look at all but the game, and at a cache of the test's own."""
    monkeypatch.setattr(Doctor, "_game", lambda _: iter(()))
    monkeypatch.setenv("HEXWAR_CACHE", str(tmp_path))


def one_package(found: str) -> Callable[[], Iterator[tuple[str, str, str]]]:
    return lambda: iter([("numpy", found, ">=2.0,<2.5")])


def test_where_all_is_well_it_ends_with_0(hexwar: Command) -> None:
    code, out, _ = hexwar("doctor", "--json")
    findings = json.loads(out)

    assert (code, findings["problems"]) == (0, [])
    assert findings["extra play"] == "installed"
    assert findings["torch build"].startswith("for ")
    assert {"cores", "memory", "cache", "free disk", "to delete all"} <= {*findings}


@pytest.mark.parametrize("found", ["1.26.4", ""])
def test_a_package_of_another_version_is_a_problem(
    found: str, hexwar: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(installed, "versions", one_package(found))
    monkeypatch.setattr(installed, "found_version", lambda _: found)
    code, out, _ = hexwar("doctor")

    assert code == 1
    assert f"problem: numpy is {found or 'not installed'}, expected >=2.0,<2.5" in out


def test_another_python_is_a_problem(hexwar: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installed, "expected_python", lambda: "<3")
    code, out, _ = hexwar("doctor", "--json")

    assert code == 1
    assert json.loads(out)["problems"][0].endswith(", expected <3")


def test_a_build_for_gpus_without_one_is_a_warning_and_no_problem(
    hexwar: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(installed, "torch_build", lambda *_: ("for CUDA", "too large"))
    code, out, _ = hexwar("doctor")

    assert code == 0
    assert out.endswith("\nwarning: too large\n")


def test_what_is_imported_and_what_is_installed_should_be_one(
    hexwar: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(doctor, "__version__", "99.0")
    warnings = json.loads(hexwar("doctor", "--json")[1])["warnings"]

    assert any("but 99.0 is imported" in one for one in warnings)


def test_clean_deletes_and_says_how_much(hexwar: Command, tmp_path: Path) -> None:
    (tmp_path / "prepared-0123456789abcdef").write_bytes(bytes(2_000_000))
    findings = json.loads(hexwar("doctor", "--clean", "--json")[1])

    assert findings["deleted"] == "2 MB"
    assert "to delete them" not in findings
