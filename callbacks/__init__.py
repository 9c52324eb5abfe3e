"""Stable-Baselines3 callbacks: progress, win rate, replays, checkpoints."""

from lazy_loader import attach_stub

if __name__ == "callbacks":  # the folder, found from the root; the package is hexwar_sb3.callbacks
    raise ImportError("import hexwar_sb3.callbacks, not callbacks")

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)  # each name is imported when it is first used
