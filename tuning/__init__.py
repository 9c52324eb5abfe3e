"""Hyperparameter search: Optuna studies over alpha, beta and Delta-t (learning.md, section 6)."""

from lazy_loader import attach_stub

if __name__ == "tuning":  # the folder, found from the root; the package is hexwar_sb3.tuning
    raise ImportError("import hexwar_sb3.tuning, not tuning")

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)  # each name is imported when it is first used
