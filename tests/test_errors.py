"""Errors cross from a worker's process to the one that waits for it."""

from __future__ import annotations

import pickle

import pytest

from hexwar_sb3.errors import FileFormatError, HexWarError, UnknownNameError, UnknownSettingError
from hexwar_sb3.maps.files import UnknownFileError
from hexwar_sb3.maps.scenario import Problem, StartError


def kinds(kind: type[HexWarError]) -> list[type[HexWarError]]:
    return [kind, *(deeper for below in kind.__subclasses__() for deeper in kinds(below))]


def made(kind: type[HexWarError]) -> HexWarError:
    if issubclass(kind, FileFormatError):
        return kind("a.json", "line 7", found="this", expected="that")
    if issubclass(kind, StartError):
        return kind("plain", Problem("tank0", "a cell", "no cell"))
    if issubclass(kind, UnknownFileError):
        return kind("map", "creek", ["plain"], "creek.map.json")
    return kind("bot", "MA3", ["MA1", "MA2"]) if issubclass(kind, UnknownNameError) else kind("no")


@pytest.mark.parametrize("kind", kinds(HexWarError))
def test_an_error_is_the_same_in_another_process(kind: type[HexWarError]) -> None:
    error = made(kind)
    again = pickle.loads(pickle.dumps(error))  # noqa: S301  # our own

    assert type(again) is kind
    assert str(again) == str(error)
    assert vars(again) == vars(error)


def test_a_keyword_error_can_be_made_anew_from_its_text() -> None:
    """As `gymnasium.make` does with every TypeError of an env that it makes."""
    first = UnknownSettingError("setting", "frameskip", ["side"])
    again = type(first)(f"{first} was raised from the environment creator")
    assert "got an unexpected keyword argument 'frameskip'" in str(again)
    assert str(pickle.loads(pickle.dumps(again))) == str(again)  # noqa: S301 - our own bytes
