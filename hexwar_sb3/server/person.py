"""The one who plays: what a person may be called."""

from __future__ import annotations

from hexwar_sb3.errors import ConfigError
from hexwar_sb3.viewer.story import NAME_CHARACTERS

PERSON = "person"  # who gave no name
EXPECTED = f"1 to {NAME_CHARACTERS} printable characters, no blanks at the ends"


def is_name(text: str) -> bool:
    """Whether a person may be called so: all of it can be seen where it is shown."""
    return text.isprintable() and 1 <= len(text) <= NAME_CHARACTERS and text == text.strip()


def check_person(setting: str, name: str) -> None:
    """Check what a person is called.

    Raises:
        ConfigError: it is empty or too long, or not all of it can be seen.
    """
    if not is_name(name):
        raise ConfigError(f"{setting} must be {EXPECTED}, got {ascii(name)[:80]}")
