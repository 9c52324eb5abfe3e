"""Pages that repeat the code say what the code says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.rules.page import filled, rule_tables
from hexwar_sb3.tasks.features import markdown

CODE = ("hexwar_sb3", "policies", "callbacks", "tuning", "tests")


def test_the_feature_page_is_the_feature_table(root: Path) -> None:
    page = (root / "docs" / "features.md").read_text(encoding="utf-8")

    assert page.endswith(markdown()), "run `make docs`"


def test_the_tables_of_the_rule_book_are_the_rule_tables(root: Path) -> None:
    page = (root / "docs" / "rules.md").read_text(encoding="utf-8")

    assert page == filled(page), "run `make docs`"
    assert sorted(re.findall("<!-- table: (.*) -->", page)) == sorted(rule_tables())


def test_a_table_that_there_is_not_is_refused() -> None:
    with pytest.raises(ConfigError, match="no table 'hop'; there are pieces"):
        filled("<!-- table: hop -->\n<!-- end -->\n")


def test_every_section_of_the_rule_book_that_the_code_names_is_there(root: Path) -> None:
    page = (root / "docs" / "rules.md").read_text(encoding="utf-8")
    sections = {int(number) for number in re.findall(r"^## (\d+) ", page, re.MULTILINE)}
    sources = [path for top in CODE for path in (root / top).rglob("*.py")]

    named = {
        int(number)
        for path in sources
        for words in re.findall(r"rule book, sections? ([\d., and]+)", path.read_text(encoding="utf-8"))
        for number in re.findall(r"\d+(?=[.,\s]|$)", re.sub(r"(\d+)\.\d+", r"\1", words))
    }
    assert named
    assert named <= sections


POINTER = re.compile(r"\b((?:[a-z_]+/)*[A-Za-z_]+\.md)((?:,? sections? [\d., and]+)?)", re.IGNORECASE)


def test_every_page_and_section_that_the_code_names_is_there(root: Path) -> None:
    sources = [path for top in CODE for path in (root / top).rglob("*.py") if path.name != "test_docs.py"]
    lost, served = [], 0
    for path in sources:
        for name, numbers in POINTER.findall(path.read_text(encoding="utf-8")):
            page = next((place for place in (root / "docs" / name, root / name) if place.is_file()), None)
            found = re.findall(r"^## (\d+) ", page.read_text(encoding="utf-8"), re.MULTILINE) if page else []
            missing = set(re.findall(r"\d+(?=[.,\s]|$)", re.sub(r"(\d+)\.\d+", r"\1", numbers))) - set(found)
            served += page is not None
            if page is None or missing:
                lost.append(f"{path.relative_to(root)}: {name}{numbers}")

    assert lost == []
    assert served > 50


def test_every_link_of_a_page_leads_somewhere(root: Path) -> None:
    pages = [*root.glob("*.md"), *root.glob("docs/**/*.md"), root / "results" / "README.md"]
    lost = [
        f"{page.relative_to(root)}: {link}"
        for page in pages
        for link in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8"))
        if "://" not in link and not (page.parent / link).exists()
    ]

    assert lost == []


def test_the_readme_names_every_command(root: Path) -> None:
    from hexwar_sb3.cli import COMMANDS

    text = (root / "README.md").read_text(encoding="utf-8")

    assert [name for name in COMMANDS if f"`hexwar {name}" not in text] == []


def test_every_test_that_a_page_names_is_there(root: Path) -> None:
    """`test_name` (`tests/.../test_module.py`): one or more names, then their file."""
    page = (root / "docs" / "formats.md").read_text(encoding="utf-8")
    named = re.findall(r"((?:`test_\w+`,? ?)+)\(`([\w/.]+)`\)", page)
    files = re.findall(r"`(tests/[\w/]+\.py|viewer/test/[\w.]+)`", page)

    lost = [
        f"{path}: {name}"
        for names, path in named
        for name in re.findall(r"test_\w+", names)
        if f"def {name}(" not in (root / path).read_text(encoding="utf-8")
    ]
    assert lost == [path for path in files if not (root / path).is_file()] == []
    assert len(named) > 8
