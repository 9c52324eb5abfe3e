"""The rule book as a page that needs nothing else: docs/rules.md, as much of Markdown as it uses.

`make docs` writes `built/rules.html` with it, so that an installed program has the rule book, too.
"""

from __future__ import annotations

import html
import re
import sys
from collections.abc import Iterator
from pathlib import Path

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
_INLINE = (
    (re.compile(r"`([^`]+)`"), r"<code>\1</code>"),
    (re.compile(r"\*\*([^*]+)\*\*"), r"<strong>\1</strong>"),
    (re.compile(r"(?<![\w*])\*([^*\s][^*]*)\*(?![\w*])"), r"<em>\1</em>"),
    (re.compile(r"\[([^\]]+)\]\([^)]+\)"), r"\1"),  # pages that are not served
)


def rule_book(markdown: str) -> str:
    """The page of a rule book."""
    blocks = list(_blocks(markdown))
    title = next(block[2:] for block in blocks if block.startswith("# "))
    parts = [_rendered(block) for block in blocks]
    parts.insert(1, _contents(blocks))
    return _PAGE.format(title=html.escape(title), style=_STYLE, body="\n".join(parts))


def _blocks(markdown: str) -> Iterator[str]:
    """Pieces of text between empty lines; a heading and what is fenced is one of its own, comments are none."""
    text = re.sub(r"^<!--.*?-->$", "", markdown, flags=re.MULTILINE)
    for part in re.split(r"(^```.*?^```$)", text, flags=re.MULTILINE | re.DOTALL):
        if part.startswith("```"):
            yield part
        else:
            yield from (block.strip("\n") for block in re.split(r"\n\s*\n", part) if block.strip())


def _rendered(block: str) -> str:
    if block.startswith("#"):
        return _heading(block)
    if block.startswith("```"):
        code = "\n".join(block.splitlines()[1:-1])
        return f'<div class="wide"><pre>{html.escape(code)}</pre></div>'
    if block.startswith("|"):
        return _table(block)
    for mark, name in ((r"\* ", "ul"), (r"\d+\. ", "ol")):
        if re.match(mark, block):
            items = re.split(rf"^{mark}", block, flags=re.MULTILINE)[1:]
            return f"<{name}>" + "".join(f"<li>{_inline(item)}</li>" for item in items) + f"</{name}>"
    return f"<p>{_inline(block)}</p>"


def _heading(block: str) -> str:
    marks, _, text = block.partition(" ")
    return f'<h{len(marks)} id="{_anchor(text)}">{_inline(text)}</h{len(marks)}>'


def _anchor(heading: str) -> str:
    return re.sub(r"\W+", "-", heading.lower()).strip("-")


def _contents(blocks: list[str]) -> str:
    names = [block[3:] for block in blocks if block.startswith("## ")]
    links = (f'<li><a href="#{_anchor(name)}">{_inline(name)}</a></li>' for name in names)
    return f"<nav><ol>{''.join(links)}</ol></nav>"


def _table(block: str) -> str:
    head, _, *rows = block.splitlines()
    body = "".join(_row(row, "td") for row in rows)
    return f'<div class="wide"><table><thead>{_row(head, "th")}</thead><tbody>{body}</tbody></table></div>'


def _row(line: str, cell: str) -> str:
    texts = line.strip().strip("|").split("|")
    return "<tr>" + "".join(f"<{cell}>{_inline(text.strip())}</{cell}>" for text in texts) + "</tr>"


def _inline(text: str) -> str:
    shown = html.escape(" ".join(text.split()), quote=False)
    for mark, tag in _INLINE:
        shown = mark.sub(tag, shown)
    return shown


if __name__ == "__main__":
    BUILT.parent.mkdir(exist_ok=True)
    BUILT.write_text(rule_book(Path(sys.argv[1]).read_text(encoding="utf-8")), encoding="utf-8")
