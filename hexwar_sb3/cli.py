"""The `hexwar` command."""

from __future__ import annotations


def main() -> None:
    """Run one sub-command."""
