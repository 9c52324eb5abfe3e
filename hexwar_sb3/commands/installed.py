"""What is installed, against what setup.cfg asks for: packages, extras, and which build of PyTorch."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, distributions, metadata, requires, version

from packaging.requirements import Requirement

NAME = "hexwar-sb3"
CPU_INDEX = "https://download.pytorch.org/whl/cpu"
FOR_US = ("dev", "docs", "test")  # extras of who works on the package
_CUDA = ("cuda-", "nvidia-", "triton")  # how packages begin that a CUDA build of PyTorch brings along
_LARGE_BYTES = 2e9  # no CPU build is nearly as large


def versions() -> Iterator[tuple[str, str, str]]:
    """Packages that are always needed: name, version that was found ("" for none), range that is expected."""
    for one in requirements():
        yield one.name, found_version(one.name), str(one.specifier)


def requirements(extra: str = "") -> list[Requirement]:
    """What the package needs by its metadata, always or for one extra; nothing where it is not installed."""
    try:
        every = [Requirement(text) for text in requires(NAME) or ()]
    except PackageNotFoundError:
        return []
    always = [one for one in every if one.marker is None or one.marker.evaluate({"extra": ""})]
    return [one for one in every if one not in always and _asks(one, extra)] if extra else always


def _asks(one: Requirement, extra: str) -> bool:
    return one.marker is not None and one.marker.evaluate({"extra": extra})


def extras() -> Iterator[tuple[str, str]]:
    """Extras for users, and whether they are there: "play", "installed"."""
    try:
        names = metadata(NAME).get_all("Provides-Extra") or []
    except PackageNotFoundError:
        return
    for extra in sorted({*names} - {*FOR_US}):
        needed = requirements(extra)
        lacking = [one.name for one in needed if not fits(one.name, str(one.specifier))]
        if not lacking:
            yield extra, "installed"
        else:
            yield extra, f'not installed ({", ".join(lacking)}): pip install "{NAME}[{extra}]"'


def fits(name: str, expected: str) -> bool:
    """Whether a package is there in a version that is expected."""
    found = found_version(name)
    return bool(found) and Requirement(f"{name}{expected}").specifier.contains(found, prereleases=True)


def found_version(name: str) -> str:
    """Version of an installed package; empty if there is none."""
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def expected_python() -> str:
    """Range of Pythons by the metadata; empty where the package is not installed."""
    try:
        return metadata(NAME)["Requires-Python"]
    except PackageNotFoundError:
        return ""


def torch_build(cuda: str | None, has_gpu: bool) -> tuple[str, str]:
    """Say which build of PyTorch is there and how large, and what is wrong with it.

    Args:
        cuda: version of CUDA that it was built for; None: it is a CPU build.
        has_gpu: whether it finds a GPU here.

    Returns:
        The build in words, and a warning; empty if there is none.
    """
    size = torch_bytes()
    kind = f"for CUDA {cuda}" if cuda else "for the CPU"
    said = f"{kind}, {size / 1e9:.1f} GB" if size else kind
    if not cuda or has_gpu or size < _LARGE_BYTES:
        return said, ""
    how = f"pip install --no-deps --index-url {CPU_INDEX} torch=={found_version('torch').partition('+')[0]}"
    says = (
        f"PyTorch is {said} with its libraries, but there is no GPU. The one for the CPU takes a fifth of it"
    )
    return said, f"{says}: begin a new environment with {how}"


def torch_bytes() -> int:
    """Bytes on disk of PyTorch and of the packages that only its CUDA builds need, as their lists of files say."""
    found = {(one.metadata["Name"] or "").lower(): one for one in distributions()}
    named = [one for name, one in found.items() if name == "torch" or name.startswith(_CUDA)]
    return sum(file.size or 0 for one in named for file in one.files or ())
