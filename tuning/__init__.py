"""Hyperparameter search (none yet)."""

if __name__ == "tuning":  # the folder, found from the root; the package is hexwar_sb3.tuning
    raise ImportError("import hexwar_sb3.tuning, not tuning")
