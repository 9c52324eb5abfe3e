"""Pages that repeat the code say what the code says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from hexwar_sb3.tasks.features import markdown


def test_the_feature_page_is_the_feature_table(root: Path) -> None:
    page = (root / "docs" / "features.md").read_text(encoding="utf-8")

    assert page.endswith(markdown()), "run `make docs`"


@pytest.mark.parametrize(
    "page",
    [
        *("README.md", "CONTRIBUTING.md", "results/README.md"),
        *(f"docs/{name}.md" for name in ("glossary", "players", "recipes", "seeds")),
    ],
)
def test_every_link_of_a_page_leads_somewhere(root: Path, page: str) -> None:
    text = (root / page).read_text(encoding="utf-8")

    links = [link for link in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in link]

    assert [link for link in links if not ((root / page).parent / link).exists()] == []


def test_the_readme_names_every_command(root: Path) -> None:
    from hexwar_sb3.cli import COMMANDS

    text = (root / "README.md").read_text(encoding="utf-8")

    assert [name for name in COMMANDS if f"`hexwar {name}" not in text] == []
