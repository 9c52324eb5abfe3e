"""What is installed is compared with what the package asks for."""

from __future__ import annotations

import configparser
from dataclasses import dataclass
from importlib.metadata import PackagePath
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from hexwar_sb3.commands import installed

GIGABYTES = 1_000_000_000


def config() -> configparser.ConfigParser:
    found = configparser.ConfigParser()
    found.read(Path(__file__).parents[2] / "setup.cfg", encoding="utf-8")
    return found


def test_every_package_that_is_needed_is_told_with_its_range() -> None:
    lines = config()["options"]["install_requires"].splitlines()
    wanted = {one.name: str(one.specifier) for one in map(Requirement, filter(None, lines))}

    assert {name: expected for name, _, expected in installed.versions()} == wanted


@pytest.mark.parametrize(
    ("found", "expected", "fits"),
    [
        ("2.13.0+cpu", ">=2.8,<3", True),
        ("2.7.0", ">=2.8,<3", False),
        ("3.0.0", ">=2.8,<3", False),
        ("", ">=2.8,<3", False),
        ("3.0rc1", ">=2.8", True),
    ],
)
def test_a_version_fits_or_does_not(
    found: str, expected: str, fits: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(installed, "found_version", lambda _: found)
    assert installed.fits("torch", expected) is fits


def test_extras_are_told_but_for_those_of_who_works_on_the_package() -> None:
    names = {*config()["options.extras_require"]} - {*installed.FOR_US}

    assert {name for name, _ in installed.extras()} == names


def test_an_extra_that_is_lacking_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installed, "found_version", lambda name: "" if name == "uvicorn" else "99")
    monkeypatch.setattr(installed, "fits", lambda name, _: name != "uvicorn")
    states = dict(installed.extras())

    assert states["play"] == 'not installed (uvicorn): pip install "hexwar-sb3[play]"'
    assert states["tune"] == "installed"


@dataclass
class Distribution:
    """As importlib.metadata has them."""

    name: str
    size: int

    @property
    def metadata(self) -> dict[str, str]:
        return {"Name": self.name}

    @property
    def files(self) -> list[PackagePath]:
        file = PackagePath("a")
        file.size = self.size
        return [file, file]


def test_the_size_of_torch_is_that_of_all_that_only_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = {"Torch": 10, "nvidia-cublas": 200, "triton": 3_000, "cuda-bindings": 40_000, "numpy": 9}
    monkeypatch.setattr(installed, "distributions", lambda: [Distribution(*one) for one in sizes.items()])
    assert installed.torch_bytes() == 2 * 43_210


@pytest.mark.parametrize(
    ("cuda", "has_gpu", "gigabytes", "said", "warned"),
    [
        (None, False, 1, "for the CPU, 1.0 GB", False),
        ("13.0", True, 5, "for CUDA 13.0, 5.0 GB", False),
        ("13.0", False, 5, "for CUDA 13.0, 5.0 GB", True),
        ("13.0", False, 0, "for CUDA 13.0", False),
    ],
)
def test_a_large_build_without_a_gpu_is_warned_of(
    cuda: str | None,
    has_gpu: bool,
    gigabytes: int,
    said: str,
    warned: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(installed, "torch_bytes", lambda: gigabytes * GIGABYTES)
    build, warning = installed.torch_build(cuda, has_gpu)

    assert build == said
    assert (installed.CPU_INDEX in warning) is warned
