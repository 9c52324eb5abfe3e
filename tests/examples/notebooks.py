"""The notebooks of examples/ as they are committed: run, tidy, sealed; and what of them must come out again.

`python -m tests.examples.notebooks` (`make notebooks`) runs them and writes them anew; review what changed.
"""

from __future__ import annotations

import base64
import hashlib
import io
import json
import os
import re
from copy import deepcopy
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
import numpy as np
from nbclient import NotebookClient
from PIL import Image

NOTEBOOKS = sorted((Path(__file__).parents[2] / "examples").glob("*.ipynb"))
FIGURES_VARY = (
    "figures-vary"  # tag of a cell whose figures come from a training: another processor has others
)
WORDS_VARY = (
    "words-vary"  # tag of a cell that may say something else there: only the kinds of its outputs count
)
METADATA = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}
QUIET = "ignore:IProgress not found"  # tqdm asks for ipywidgets, which no notebook needs
DPI = 90  # of pictures, where nothing else is said
COLOURS = 128  # of a picture
FAR = 48  # levels of a colour, of 256
FAR_SHARE = 0.001  # of the pixels of one picture drawn twice, at most; another game differs in 0.01

_FIGURE = re.compile(r"-?\d+(\.\d+)?(e[-+]?\d+)?|\b(True|False)\b")
_PNG = "image/png"


def load(path: Path) -> nbformat.NotebookNode:
    """Read a notebook."""
    return nbformat.read(path, as_version=4)  # type: ignore[no-untyped-call]  # it has no types


def as_text(notebook: nbformat.NotebookNode) -> str:
    """Text of its file."""
    return nbformat.writes(notebook) + "\n"  # type: ignore[no-untyped-call]  # it has no types


def code_cells(notebook: nbformat.NotebookNode) -> list[Any]:
    """Cells that are run."""
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def run(notebook: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """Run a copy of a notebook in a folder of its own, and make it tidy."""
    fresh = deepcopy(notebook)
    with TemporaryDirectory() as folder:
        (Path(folder) / "matplotlibrc").write_text(f"figure.dpi: {DPI}\n", encoding="utf-8")
        client = NotebookClient(
            fresh,
            timeout=300,
            record_timing=False,
            coalesce_streams=True,
            resources={"metadata": {"path": folder}},
        )
        client.execute(env={**os.environ, "PYTHONWARNINGS": QUIET})
    for output in (output for cell in code_cells(fresh) for output in cell.outputs):
        if _PNG in output.get("data", {}):
            output.data, output.metadata = {_PNG: _with_few_colours(output.data[_PNG])}, {}
    return tidy(fresh)


def tidy(notebook: nbformat.NotebookNode) -> nbformat.NotebookNode:
    """The notebook without what changes from run to run, and with its seal."""
    new = deepcopy(notebook)
    for number, cell in enumerate(new.cells):
        cell.id = f"cell-{number}"
        cell.metadata = {"tags": cell.metadata.tags} if cell.metadata.get("tags") else {}
    for number, cell in enumerate(code_cells(new), start=1):
        cell.execution_count = number
        for output in cell.outputs:
            if output.output_type == "execute_result":
                output.execution_count = number
    new.metadata = nbformat.from_dict({**METADATA, "seal": seal(new)})  # type: ignore[no-untyped-call]
    return new


def seal(notebook: nbformat.NotebookNode) -> str:
    """Hash of all sources and outputs: neither changes alone."""
    cells = [(cell.source, [_content(output) for output in cell.outputs]) for cell in code_cells(notebook)]
    return hashlib.sha256(json.dumps(cells, sort_keys=True).encode()).hexdigest()[:16]


def changed_cells(old: nbformat.NotebookNode, new: nbformat.NotebookNode) -> list[str]:
    """Ids of the cells whose outputs differ in what must come out again."""
    pairs = zip(code_cells(old), code_cells(new), strict=True)
    return [before.id for before, after in pairs if not _come_out_again(before, after)]


def _come_out_again(old: Any, new: Any) -> bool:
    tags = old.metadata.get("tags", [])
    if [_kind(output) for output in old.outputs] != [_kind(output) for output in new.outputs]:
        return False
    pairs = zip(old.outputs, new.outputs, strict=True)
    return WORDS_VARY in tags or all(
        _same(before, after, figures=FIGURES_VARY not in tags) for before, after in pairs
    )


def _same(old: Any, new: Any, *, figures: bool) -> bool:
    """Whether two outputs of one kind are the same; without figures: whether their words are, in any order of lines."""
    if _PNG in _kind(old):
        return not figures or pictures_are_alike(_content(old)[_PNG], _content(new)[_PNG])
    if figures:
        return bool(_content(old) == _content(new))
    return _words(_content(old)) == _words(_content(new))


def _kind(output: Any) -> tuple[str, ...]:
    return (output.output_type, output.get("name", ""), *sorted(output.get("data", {})))


def _content(output: Any) -> Any:
    return output.text if output.output_type == "stream" else dict(output.data)


def _words(content: Any) -> list[list[str]]:
    text = content if isinstance(content, str) else "\n".join(map(str, content.values()))
    return sorted(_FIGURE.sub("#", line).split() for line in text.splitlines())


def pictures_are_alike(one: str, other: str) -> bool:
    """Whether hardly a pixel differs: the last bits of lines and colours are the processor's."""
    a, b = (np.asarray(_picture(code).convert("RGB"), np.int16) for code in (one, other))
    return a.shape == b.shape and bool((np.abs(a - b).max(axis=2) > FAR).mean() <= FAR_SHARE)


def _with_few_colours(code: str) -> str:
    """A picture in a third of its bytes; the octree keeps rare colours, as those of thin lines."""
    if _picture(code).mode == "P":
        return code  # it has few already
    few = _picture(code).convert("RGB").quantize(COLOURS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    few.save(file := io.BytesIO(), "PNG", optimize=True)
    return base64.b64encode(file.getvalue()).decode()


def _picture(code: str) -> Image.Image:
    return Image.open(io.BytesIO(base64.b64decode(code)))


if __name__ == "__main__":
    for notebook_path in NOTEBOOKS:
        notebook_path.write_text(as_text(run(load(notebook_path))), encoding="utf-8")
