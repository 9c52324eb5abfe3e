"""The pages that are served, and the policy that each is served with: its own scripts and styles, and nothing else."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterable
from functools import lru_cache
from importlib.resources import files

_SCRIPT = re.compile(r"<script(?![^>]*type=\"text/plain\")[^>]*>(.*?)</script>", re.DOTALL)
_STYLE = re.compile(r"<style[^>]*>(.*?)</style>", re.DOTALL)
_HEADERS = {
    "cache-control": "no-store",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
}


@lru_cache(maxsize=1)
def play_page() -> str:
    """The page of a game that is played."""
    return (files("hexwar_sb3.viewer") / "built" / "play.html").read_text(encoding="utf-8")


@lru_cache(maxsize=1)
def rules_page() -> str:
    """The rule book."""
    return (files("hexwar_sb3.server") / "built" / "rules.html").read_text(encoding="utf-8")


def headers_of(page: str, *, connects: bool = False) -> dict[str, str]:
    """Headers of an answer with a page; it may ask this server (`connects`), and nobody else."""
    scripts, styles = (_sources(kind.findall(page)) for kind in (_SCRIPT, _STYLE))
    policy = {
        "default-src": "'none'",
        "script-src": scripts,
        "style-src": styles,
        "img-src": "data: blob:",
        "media-src": "blob:",
        "connect-src": "'self'" if connects else "'none'",
        "base-uri": "'none'",
        "form-action": "'none'",
        "frame-ancestors": "'none'",
    }
    text = "; ".join(f"{name} {value}" for name, value in policy.items())
    return {**plain_headers(), "content-security-policy": text}


def plain_headers() -> dict[str, str]:
    """Headers of every answer."""
    return dict(_HEADERS)


def _sources(texts: Iterable[str]) -> str:
    hashes = [base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in texts]
    return " ".join(f"'sha256-{one}'" for one in hashes) or "'none'"
