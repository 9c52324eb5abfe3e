"""Hyperparameter search: Optuna studies over alpha, beta and Delta-t (learning.md, section 6)."""

if __name__ == "tuning":  # the folder, found from the root; the package is hexwar_sb3.tuning
    raise ImportError("import hexwar_sb3.tuning, not tuning")
