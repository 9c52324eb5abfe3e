"""The version of this software: its one home."""

__version__ = "0.2.0"
"""As the distribution is called on the shelf: major, minor, patch (SemVer)."""
