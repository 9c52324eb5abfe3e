"""Archives that lie about what is in them, or hold more than their size says."""

from __future__ import annotations

import io
import struct
import warnings
import zipfile
import zlib
from functools import cache, partial

from tests.attack.archives import payloads, unzipped, with_entry, zipped
from tests.attack.tricks import Trick, Tricks, instead

MANY_ENTRIES = 40  # then the first and last of them stand for all
INFLATED_MB = 3_500  # of a bomb, in as many kB
SIZES = (0, 1, 2**31 - 1, 2**32 - 2, 2**32 - 1)  # that an entry is said to have


def zip_tricks(data: bytes) -> Tricks:
    """Entries by others, twice, elsewhere; the list of them; packing; sizes; bombs."""
    names = list(unzipped(data))
    for name in names if len(names) < MANY_ENTRIES else names[:3] + names[-2:]:
        yield from _entry_tricks(name)
    for how, kind in ((8, "deflated"), (12, "bzip2"), (14, "lzma")):
        yield Trick("zip entry", f"all {kind}", partial(_repacked, how))
    more = {
        "an unknown entry": "zz",
        "a path up": "../zz",
        "an absolute path": "/zz",
        "NUL": "z\0z",
        "a folder": "zz/",
    }
    for kind, name in more.items():
        yield Trick("zip entry", f"and {kind}", partial(with_entry, name, payloads()["a pickle"]))
    yield Trick("zip entry", "and 40,000 entries", _many_entries)
    yield Trick("zip entry", "no entries", partial(instead, zipped({})))
    yield Trick("zip entry", "behind 1,000 bytes", lambda d: bytes(1000) + d)
    yield Trick("zip entry", "a comment", lambda d: d[:-2] + struct.pack("<H", 65_000) + bytes(65_000))
    for at, size in ((8, 2), (10, 2), (12, 4), (16, 4)):
        for byte in (b"\0", b"\xff"):
            yield Trick(
                "zip size", f"end record, field {at} {byte!r}", partial(_end_patched, at, byte * size)
            )


def _entry_tricks(name: str) -> Tricks:
    yield Trick("zip entry", f"no {name}", partial(_drop, name))
    yield Trick("zip entry", f"{name} empty", partial(with_entry, name, b""))
    yield Trick("zip entry", f"{name} twice", partial(_add_again, name))
    yield Trick("zip entry", f"{name} by another name", partial(_rename, name, f"../{name}"))
    for kind in ("a pickle", "a legacy torch file", "a torch zip", "a .npy of objects"):
        yield Trick("pickle", f"{name} is {kind}", partial(with_entry, name, payloads()[kind]))
    yield Trick("zip entry", f"{name} with a wrong checksum", partial(_patched, name, 14, 16, b"\1\2\3\4"))
    yield Trick("zip entry", f"{name} encrypted", partial(_patched, name, 6, 8, b"\1\0"))
    yield Trick("zip entry", f"{name} by an unknown method", partial(_patched, name, 8, 10, b"\x63\0"))
    for size in SIZES:
        number = struct.pack("<I", size)
        yield Trick("zip size", f"{name} said {size} long", partial(_patched, name, 22, 24, number))
        yield Trick("zip size", f"{name} said {size} packed", partial(_patched, name, 18, 20, number))
    for claim in (INFLATED_MB << 20, 100, 2**32 - 2):
        yield Trick("zip bomb", f"{name} inflates, says {claim}", partial(_bomb, name, claim))
    yield Trick("zip entry", f"{name} in the place of the first", partial(_overlap, name))


def _repacked(how: int, data: bytes) -> bytes:
    return zipped(unzipped(data), how)


def _many_entries(data: bytes) -> bytes:
    return zipped({**unzipped(data), **{str(k): b"" for k in range(40_000)}})


def _drop(name: str, data: bytes) -> bytes:
    return zipped({key: value for key, value in unzipped(data).items() if key != name})


def _rename(name: str, other: str, data: bytes) -> bytes:
    return zipped({other if key == name else key: value for key, value in unzipped(data).items()})


def _add_again(name: str, data: bytes) -> bytes:
    file = io.BytesIO(data)
    with warnings.catch_warnings(action="ignore"), zipfile.ZipFile(file, "a") as archive:
        archive.writestr(zipfile.ZipInfo(name), payloads()["a pickle"])
    return file.getvalue()


def _heads(data: bytes, name: str) -> tuple[int, int]:
    """Where the local and the central record of an entry are."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        local = archive.getinfo(name).header_offset
        central = archive.start_dir
        for info in archive.infolist():
            if info.filename == name:
                break
            central += 46 + sum(struct.unpack_from("<HHH", data, central + 28))
    return local, central


def _patched(name: str, local_at: int, central_at: int, value: bytes, data: bytes) -> bytes:
    """Overwrite a field of an entry in both of its records."""
    plain = bytearray(zipped(unzipped(data)))
    local, central = _heads(bytes(plain), name)
    for at in (local + local_at, central + central_at):
        plain[at : at + len(value)] = value
    return bytes(plain)


def _end_patched(at: int, value: bytes, data: bytes) -> bytes:
    end = data.rindex(b"PK\5\6") + at
    return data[:end] + value + data[end + len(value) :]


def _overlap(name: str, data: bytes) -> bytes:
    """The central record points to the first entry's data."""
    plain = bytearray(zipped(unzipped(data)))
    _, central = _heads(bytes(plain), name)
    plain[central + 42 : central + 46] = bytes(4)
    return bytes(plain)


@cache
def zeros_deflated(millions: int) -> bytes:
    """So many MB of zeros, deflated, made at once: a block after a full flush can be said again."""
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    first = packer.compress(bytes(1 << 20)) + packer.flush(zlib.Z_FULL_FLUSH)
    block = packer.compress(bytes(1 << 20)) + packer.flush(zlib.Z_FULL_FLUSH)
    return first + block * (millions - 1) + packer.flush(zlib.Z_FINISH)


def _bomb(name: str, claim: int, data: bytes) -> bytes:
    """An entry of zeros without end, which says how long it is."""
    found = bytearray(with_entry(name, zeros_deflated(INFLATED_MB), data))
    local, central = _heads(bytes(found), name)
    for start, method_at, size_at in ((local, 8, 22), (central, 10, 24)):
        found[start + method_at : start + method_at + 2] = struct.pack("<H", zipfile.ZIP_DEFLATED)
        found[start + size_at : start + size_at + 4] = struct.pack("<I", claim)
    return bytes(found)
