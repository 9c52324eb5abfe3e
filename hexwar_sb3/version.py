"""The version of this software: its one home."""

__version__ = "0.1.0"
