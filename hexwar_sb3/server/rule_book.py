"""The rule book as a page that needs nothing else.

`make docs` writes `built/rules.html` with it, so that an installed program has the rule book, too.
"""

from __future__ import annotations

import html
import itertools
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from markdown_it import MarkdownIt
from markdown_it.token import Token

BUILT = Path(__file__).parent / "built" / "rules.html"
_STYLE = """
:root { color-scheme: light dark; font: 16px/1.55 system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif; }
body { max-width: 46rem; margin: 0 auto; padding: 1.5rem 1rem 4rem; }
h1, h2, h3 { line-height: 1.2; margin: 2em 0 0.6em; } h1 { margin-top: 0.4em; }
nav ol { list-style: none; margin: 0; padding: 0; columns: 2 14rem; } nav a { display: inline-block; padding: 0.2em 0; }
.wide { overflow-x: auto; } table { border-collapse: collapse; font-size: 0.9em; margin: 1em 0; }
th, td { text-align: left; padding: 0.3em 0.8em 0.3em 0; border-bottom: 1px solid color-mix(in srgb, currentColor 20%, transparent); vertical-align: top; }
pre, code { font-family: ui-monospace, "Liberation Mono", Menlo, Consolas, monospace; font-size: 0.92em; }
pre { line-height: 1.35; }
"""
_PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
{body}
</body>
</html>
"""


def rule_book(markdown: str) -> str:
    """The page of a rule book; links are texts, as nothing else is served."""
    reader = MarkdownIt("commonmark", {"html": True}).enable("table")
    tokens = list(_shown(reader.parse(markdown)))
    headings = [
        (token.tag, text.content)
        for token, text in itertools.pairwise(tokens)
        if token.type == "heading_open"
    ]
    title, chapters = headings[0][1], [text for tag, text in headings if tag == "h2"]
    first = next(k for k, token in enumerate(tokens) if token.type == "heading_close") + 1
    parts = [reader.renderer.render(some, reader.options, {}) for some in (tokens[:first], tokens[first:])]
    body = _contents(chapters).join(parts)
    return _PAGE.format(title=html.escape(title), style=_STYLE, body=_wide(body))


def _shown(tokens: Sequence[Token]) -> Iterator[Token]:
    """What is shown: no comments and no links; headings can be linked to."""
    for token, text in zip(tokens, [*tokens[1:], None], strict=True):
        if token.type == "heading_open" and text is not None:
            token.attrSet("id", _anchor(text.content))
        if token.children:
            token.children = [one for one in token.children if not one.type.startswith("link_")]
        if token.type != "html_block":
            yield token


def _wide(body: str) -> str:
    """Tables of any kind scroll by themselves on a narrow screen."""
    return re.sub(r"<(table|pre)>.*?</\1>", r'<div class="wide">\g<0></div>', body, flags=re.DOTALL)


def _anchor(heading: str) -> str:
    return re.sub(r"\W+", "-", heading.lower()).strip("-")


def _contents(chapters: Sequence[str]) -> str:
    links = (f'<li><a href="#{_anchor(name)}">{html.escape(name)}</a></li>' for name in chapters)
    return f"<nav><ol>{''.join(links)}</ol></nav>"


if __name__ == "__main__":
    BUILT.parent.mkdir(exist_ok=True)
    BUILT.write_text(rule_book(Path(sys.argv[1]).read_text(encoding="utf-8")), encoding="utf-8")
