"""The rule book that is served is docs/rules.md, whole, and needs nothing else."""

from __future__ import annotations

import html
import re
from pathlib import Path

import pytest

from hexwar_sb3.server.pages import rules_page
from hexwar_sb3.server.rule_book import rule_book

RULES = (Path(__file__).parents[2] / "docs" / "rules.md").read_text(encoding="utf-8")


def words(text: str) -> list[str]:
    return re.findall(r"\w+", text)


def test_the_page_is_made_of_the_rule_book() -> None:
    assert rules_page() == rule_book(RULES), "make docs"


def test_no_word_of_it_is_lost() -> None:
    text = re.sub(r"^<!--.*?-->$|^\|[ |-]+\|$|^```\w*$|^\d+\. ", "", RULES, flags=re.MULTILINE)
    text = re.sub(r"\[([^\]]+)\]\([^)]+\)", r"\1", text)
    body = rules_page().partition("</nav>")[2]
    heading = re.findall(r"<h1[^>]*>(.*?)</h1>", rules_page())

    assert words("".join(heading)) + words(html.unescape(re.sub(r"<[^>]+>", " ", body))) == words(text)


def test_it_asks_nobody() -> None:
    assert not re.search(r"https?:|src=|url\(|@import|<script", rules_page())
    targets, names = (set(re.findall(mark, rules_page())) for mark in (r'href="#([^"]+)"', r' id="([^"]+)"'))
    assert targets <= names
    assert len(targets) > 10


@pytest.mark.parametrize(
    ("markdown", "part"),
    [
        ("[x](elsewhere) and [`y`](elsewhere#part)", "<p>x and <code>y</code></p>"),
        ("| a | b |\n|---|---|\n| 1 | 2 |", '<div class="wide"><table>'),
        ("```text\na  <b\n\nc\n```", '<div class="wide"><pre>'),
        ("## 2 Two < three", '<li><a href="#2-two-three">2 Two &lt; three</a></li>'),
        ("## 2 Two < three", '<h2 id="2-two-three">2 Two &lt; three</h2>'),
        ("<!-- table: hops -->\n\ntext", "</nav><p>text</p>"),
    ],
)
def test_links_are_texts_tables_scroll_and_headings_can_be_linked_to(markdown: str, part: str) -> None:
    assert part in re.sub(r"\n+", "\n", rule_book(f"# Title\n\n{markdown}\n"))
