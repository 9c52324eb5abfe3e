"""The notebooks run from top to bottom, stay small, and show what comes out."""

from __future__ import annotations

import ast
import base64
import io
import json
from pathlib import Path

import nbformat
import pytest
from PIL import Image, ImageDraw

from tests.examples.notebooks import (
    FIGURES_VARY,
    NOTEBOOKS,
    WORDS_VARY,
    as_text,
    changed_cells,
    code_cells,
    load,
    pictures_are_alike,
    run,
    tidy,
)

each_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
LONG = ("03_", "04_", "05_")  # a minute each; the others run in `make test`
each_notebook_that_runs = pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, id=path.stem, marks=[pytest.mark.slow] if path.name.startswith(LONG) else [])
        for path in NOTEBOOKS
    ],
)
OF_A_MACHINE = ("/tmp", "/home", "/root", "/Users", "site-packages", "ipykernel", " at 0x", "Warning")  # noqa: S108


@each_notebook
def test_a_notebook_has_at_most_12_code_cells_and_defines_no_class(path: Path) -> None:
    sources = [cell.source for cell in code_cells(load(path))]
    trees = [ast.parse(source.replace("%matplotlib inline", "")) for source in sources]

    assert len(sources) <= 12
    assert not any(isinstance(node, ast.ClassDef) for tree in trees for node in ast.walk(tree))


@each_notebook
def test_a_notebook_is_committed_as_make_notebooks_leaves_it(path: Path) -> None:
    """Its seal covers sources and outputs: neither was changed by hand."""
    text = path.read_text(encoding="utf-8")

    assert text == as_text(tidy(load(path))), "run `make notebooks`"
    assert len(text) < 400_000


@each_notebook
def test_the_outputs_of_a_notebook_hold_no_warning_and_nothing_of_a_machine(path: Path) -> None:
    outputs = [output for cell in code_cells(load(path)) for output in cell.outputs]
    texts = [output.get("text", "") + str(output.get("data", {}).get("text/plain", "")) for output in outputs]

    assert not any(output.get("name") == "stderr" for output in outputs)
    assert [(sign, text) for text in texts for sign in OF_A_MACHINE if sign in text] == []


@each_notebook_that_runs
def test_a_notebook_runs_and_its_outputs_come_out_again(path: Path) -> None:
    notebook = load(path)

    assert changed_cells(notebook, run(notebook)) == [], "run `make notebooks`, and look at what changed"


def of_one_cell(text: str, tag: str = "", source: str = "print(games)") -> nbformat.NotebookNode:
    output = {"output_type": "stream", "name": "stdout", "text": text}
    cell = {"cell_type": "code", "id": "cell-0", "source": source, "outputs": [output]}
    metadata = {"tags": [tag]} if tag else {}
    document = {
        "cells": [{**cell, "metadata": metadata, "execution_count": 1}],
        "metadata": {},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return tidy(nbformat.reads(json.dumps(document), as_version=4))  # type: ignore[no-untyped-call]


@pytest.mark.parametrize(
    ("tag", "now", "again"),
    [
        ("", "7 won\n8 lost\n", True),
        ("", "7 won\n9 lost\n", False),
        (FIGURES_VARY, "6 lost\n-9.5 won\n", True),
        (FIGURES_VARY, "7 won\n8 drawn\n", False),
        (FIGURES_VARY, "7 won\n", False),
        (WORDS_VARY, "7 drawn\n", True),
    ],
)
def test_what_must_come_out_again_is_said_by_the_tag_of_a_cell(tag: str, now: str, again: bool) -> None:
    committed, fresh = of_one_cell("7 won\n8 lost\n", tag), of_one_cell(now, tag)

    assert changed_cells(committed, fresh) == ([] if again else ["cell-0"])


@pytest.mark.parametrize("tag", [FIGURES_VARY, WORDS_VARY])
def test_an_output_that_is_missing_is_noticed_whatever_the_tag(tag: str) -> None:
    committed, fresh = of_one_cell("7 won", tag), of_one_cell("7 won", tag)
    fresh.cells[0].outputs = []

    assert changed_cells(committed, fresh) == ["cell-0"]


@pytest.mark.parametrize("other", [of_one_cell("8 won"), of_one_cell("7 won", source="print(more)")])
def test_a_seal_breaks_with_a_source_and_with_an_output(other: nbformat.NotebookNode) -> None:
    assert other.metadata.seal != of_one_cell("7 won").metadata.seal


def with_line(end: int, shade: int = 200) -> str:
    picture = Image.new("RGB", (100, 100), (shade, shade, 180))
    ImageDraw.Draw(picture).line((5, 5, end, 60), fill=(190, 30, 30))
    picture.save(file := io.BytesIO(), "PNG")
    return base64.b64encode(file.getvalue()).decode()


def test_pictures_are_alike_up_to_shades_and_not_with_another_line() -> None:
    assert pictures_are_alike(with_line(60), with_line(60, shade=203))
    assert not pictures_are_alike(with_line(60), with_line(75))
