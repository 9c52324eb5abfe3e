"""A recorded game as a page to watch: what each side knew, tick by tick, in one HTML file."""

from lazy_loader import attach_stub

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)  # each name is imported when it is first used
