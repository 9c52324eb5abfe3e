"""Tasks (III-A): task sets, what a shot is worth, features, phi, eq. (2), and the hot spots that tasks lead to."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)  # each name is imported when it is first used
