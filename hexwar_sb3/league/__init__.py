"""Grouped self-play (III-C, Fig. 6): groups, round robin, selection."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)  # each name is imported when it is first used
