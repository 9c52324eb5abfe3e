"""The site (`make site`): the pages as they lie, the notebooks as they were run, the public names as the folders open."""

from __future__ import annotations

import ast
import importlib.util
import inspect
import re
import shutil
import sys
from enum import Enum
from itertools import pairwise
from pathlib import Path
from textwrap import indent
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

project = "hexwar-sb3"
html_title = project
html_theme = "furo"
html_copy_source = False
html_show_copyright = False
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
root_doc = "README"
include_patterns = [
    "*.md",
    "docs/*.md",
    "docs/formats/*.md",
    "docs/api/*.rst",
    "results/README.md",
    "examples/*.ipynb",
    "examples/games/README.md",
]
myst_heading_anchors = 3
nb_execution_mode = "off"
nb_ipywidgets_js: dict[str, Any] = {}  # nothing is fetched from elsewhere
add_module_names = False
autodoc_default_options = {"members": True, "member-order": "bysource"}
autodoc_preserve_defaults = True
autodoc_typehints_format = "short"
default_role = "code"  # docstrings quote as Markdown does
napoleon_attr_annotations = False  # the signature has them
napoleon_use_ivar = True
python_maximum_signature_line_length = 88

CONTENTS = """

```{toctree}
:hidden:
:caption: Guide
:glob:

docs/watch
docs/play
docs/rules
docs/players
docs/recipes
docs/learning
docs/*
```
```{toctree}
:hidden:
:caption: File formats
:glob:

docs/formats/*
```
```{toctree}
:hidden:
:caption: Notebooks
:glob:

examples/*
Sample games <examples/games/README>
```
```{toctree}
:hidden:
:caption: Public names
:glob:

docs/api/*
```
```{toctree}
:hidden:
:caption: Project
:glob:

Kept runs <results/README>
*
```
"""
FIELD_COMMENT = re.compile(r"^(    \w+(?::| =) [^#\n]*) # (?!noqa|type:)", re.MULTILINE)
ARRAY = r"~numpy\.ndarray\[tuple\[~typing\.Any, \.\.\.\], ~numpy\.dtype\[(.*?)\]\]"


def folders() -> list[str]:
    """The package and those of its folders that open with public names."""
    inside = sorted(f"hexwar_sb3.{page.parent.name}" for page in (ROOT / "hexwar_sb3").glob("*/__init__.py"))
    return [name for name in ("hexwar_sb3", *inside) if hasattr(importlib.import_module(name), "__all__")]


def homes(folder: str) -> dict[str, str]:
    """The module of each public name, as the folder's `__init__.pyi` (or its `__init__.py`) imports it."""
    opened = importlib.import_module(folder)
    page = Path(str(opened.__file__))
    stub = page.with_suffix(".pyi")
    found = {}
    for line in ast.parse((stub if stub.exists() else page).read_text("utf-8")).body:
        if isinstance(line, ast.ImportFrom):
            module = importlib.util.resolve_name("." * line.level + (line.module or ""), folder)
            found.update({one.name: module for one in line.names})
    return {name: found[name] for name in opened.__all__}


def said(folder: str, name: str, home: str) -> str:
    """Docstring of a public name; that of a value is the string below it. Empty where there is none."""
    value = getattr(importlib.import_module(folder), name)
    if inspect.isclass(value):
        text = value.__doc__ or ""
        generated = text.startswith(f"{name}(")  # a dataclass says something by itself
        return "" if generated else inspect.cleandoc(text)
    if inspect.ismodule(value) or inspect.isroutine(value):
        return inspect.getdoc(value) or ""
    lines = ast.parse(inspect.getsource(importlib.import_module(home))).body
    for line, below in pairwise(lines):
        if isinstance(line, ast.Assign | ast.AnnAssign) and re.match(rf"{name}\b", ast.unparse(line)):
            return ast.get_docstring(ast.Module([below], [])) or ""
    return ""


def undocumented() -> list[str]:
    """Public names without a docstring of their own."""
    places = [(folder, name, home) for folder in folders() for name, home in homes(folder).items()]
    return [f"{folder}.{name}" for folder, name, home in places if not said(folder, name, home)]


def entry(folder: str, name: str, home: str) -> str:
    """A public name in full, or, on the page of the whole package, where its folder shows it."""
    value = getattr(importlib.import_module(folder), name)
    text = said(folder, name, home)
    inner = ".".join(home.split(".")[:2])
    if inspect.ismodule(value):
        return f":doc:`{name} <{folder}.{name}>`\n    {text.splitlines()[0]}\n"
    if folder != inner and name in getattr(importlib.import_module(inner), "__all__", ()):
        return f":py:obj:`{name} <{inner}.{name}>`\n    {text.splitlines()[0]}\n"
    if inspect.isroutine(value):
        return f".. autofunction:: {name}\n"
    if not inspect.isclass(value):
        return f".. py:data:: {name}\n\n{indent(text, '    ')}\n"
    bases = "" if value.__bases__ == (object,) else "    :show-inheritance:\n"
    members = "    :undoc-members:\n" if issubclass(value, Enum) else ""
    return f".. autoclass:: {name}\n{bases}{members}"


def write_names(_: Sphinx) -> None:
    """Write a page a folder into docs/api/.

    Raises:
        ValueError: names the public names that say nothing.
    """
    if silent := undocumented():
        raise ValueError(f"no docstring: {', '.join(silent)}")
    pages = ROOT / "docs" / "api"
    shutil.rmtree(pages, ignore_errors=True)
    pages.mkdir()
    for folder in folders():
        entries = [entry(folder, name, home) for name, home in homes(folder).items()]
        entries.sort(key=lambda one: one.startswith(".."))  # first where to find what stands elsewhere
        about = inspect.getdoc(importlib.import_module(folder))
        page = "\n".join(
            [folder, "=" * len(folder), "", f"{about}\n", f".. py:currentmodule:: {folder}\n", *entries]
        )
        (pages / f"{folder}.rst").write_text(page, "utf-8")


def show_field_comments(_: Sphinx) -> None:
    """Let a comment behind a field be its docstring, as it is the help of a flag."""
    from sphinx.pycode import ModuleAnalyzer

    for home in {home for folder in folders() for home in homes(folder).values()}:
        source = inspect.getsource(importlib.import_module(home))
        analyzer = ModuleAnalyzer.for_string(FIELD_COMMENT.sub(r"\1 #: ", source), home)
        analyzer.analyze()
        analyzer.code = source
        ModuleAnalyzer.cache["module", home] = analyzer


def add_contents(_: Sphinx, page: str, source: list[str]) -> None:
    """Give the README the list of all pages."""
    if page == root_doc:
        source[0] += CONTENTS


def name_arrays(*event: Any) -> tuple[str | None, str | None]:
    """Write an array's type as its author did."""
    arguments, result = (re.sub(ARRAY, r"NDArray[\1]", text) if text else text for text in event[-2:])
    return arguments, result


def keep_colons(_: Sphinx, kind: str, *event: Any) -> None:
    """Let a value's docstring have a colon: napoleon takes the words before it for a type."""
    if kind in {"attribute", "property"}:
        event[-1][:0] = ["..", ""]


def mend_links(app: Sphinx, document: Any) -> None:
    """Let a link to a folder lead to the README above it, and a type's name to no namesake in another folder."""
    from sphinx.addnodes import pending_xref

    for link in document.findall(pending_xref):
        if not link.get("refspecific", True):
            del link["refspecific"]  # Sphinx asks whether it is there
        place = Path(app.env.relfn2path(link["reftarget"])[1])
        if link["reftype"] == "myst" and place.is_dir():
            near = next(up for up in (place, *place.parents) if (up / "README.md").is_file())
            page = (near / "README").relative_to(app.srcdir).as_posix()
            link.attributes.update(refdomain="doc", reftarget=page, reftargetid=None)


def open_at_index(app: Sphinx, error: Exception | None) -> None:
    """The README is the first page."""
    if error is None:
        shutil.copy(app.outdir / f"{root_doc}.html", app.outdir / "index.html")


def setup(app: Sphinx) -> None:
    """Hang our seven steps into the build."""
    import myst_nb.sphinx_ext

    myst_nb.sphinx_ext.OUTPUT_FOLDER = "build/notebooks"  # beside the site; git ignores it
    app.connect("builder-inited", write_names)
    app.connect("builder-inited", show_field_comments)
    app.connect("source-read", add_contents)
    app.connect("autodoc-process-signature", name_arrays)
    app.connect("autodoc-process-docstring", keep_colons, priority=400)  # before napoleon
    app.connect("doctree-read", mend_links)
    app.connect("build-finished", open_at_index)
