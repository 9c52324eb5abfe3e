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
        ("a < b & *c* and `d*e*f`", "<p>a &lt; b &amp; <em>c</em> and <code>d*e*f</code></p>"),
        ("1. one\n   more\n2. two", "<ol><li>one more</li><li>two</li></ol>"),
        ("| a | b |\n|---|---|\n| 1 | 2 |", "<tr><td>1</td><td>2</td></tr>"),
        ("```text\na  <b\n\nc\n```", "<pre>a  &lt;b\n\nc</pre>"),
        ("[x](elsewhere)", "<p>x</p>"),
    ],
)
def test_markdown_as_far_as_the_rule_book_uses_it(markdown: str, part: str) -> None:
    assert part in rule_book(f"# Title\n\n{markdown}\n")
