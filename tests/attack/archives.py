"""Zips, arrays and pickles, made byte by byte; nothing here imports the program."""

from __future__ import annotations

import base64
import io
import json
import os
import pickle
import warnings
import zipfile
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.lib import format as npy

MARK = "HEXWAR_ATTACK_MARK"  # environment: a file that exists once a payload ran


class Payload:
    """Leaves a mark when it is unpickled."""

    def __reduce__(self) -> tuple[Callable[[str], int], tuple[str]]:
        return os.system, (f': > "${MARK}"',)


def zipped(entries: dict[str, bytes], how: int = zipfile.ZIP_STORED) -> bytes:
    """A zip of some entries, always the same bytes."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", how) as archive:
        for name, data in entries.items():
            archive.writestr(zipfile.ZipInfo(name), data, how)
    return file.getvalue()


def unzipped(data: bytes) -> dict[str, bytes]:
    """Its entries."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def with_entry(name: str, value: bytes, data: bytes) -> bytes:
    """A zip with an entry, new or in the place of the one of its name."""
    return zipped({**unzipped(data), name: value})


def from_npy(body: bytes) -> Any:
    """The array of a `.npy`."""
    return np.lib.format.read_array(io.BytesIO(body), allow_pickle=False)


def to_npy(array: Any) -> bytes:
    """A `.npy` of an array."""
    file = io.BytesIO()
    with warnings.catch_warnings(action="ignore"):
        npy.write_array(file, np.asanyarray(array), allow_pickle=False)
    return file.getvalue()


def object_array() -> bytes:
    """A `.npy` whose one value is a payload."""
    file = io.BytesIO()
    npy.write_array(file, np.array([Payload()], object), allow_pickle=True)
    return file.getvalue()


@cache
def payloads() -> dict[str, bytes]:
    """Payloads as all that may be unpickled: bare, as torch's two formats, as numpy's objects."""
    bare = pickle.dumps(Payload(), 2)
    magic = pickle.dumps(0x1950A86A20F9469CFC6C, 2) + pickle.dumps(1001, 2) + pickle.dumps({}, 2)
    entries = {"archive/data.pkl": bare, "archive/version": b"3\n", "archive/byteorder": b"little"}
    return {
        "a pickle": bare,
        "a pickle of protocol 0": pickle.dumps(Payload(), 0),
        "a legacy torch file": magic + bare,
        "a torch zip": zipped(entries),
        "a .npy of objects": object_array(),
        "a .npz of objects": zipped({"a.npy": object_array(), "format.npy": object_array()}),
    }


def sb3_pickle() -> str:
    """A payload as Stable-Baselines3 writes what is no JSON."""
    text = base64.b64encode(pickle.dumps(Payload(), 2)).decode()
    return json.dumps({":type:": "<class 'x'>", ":serialized:": text})
