"""Stable-Baselines3 callbacks: progress, win rate, replays, checkpoints."""

if __name__ == "callbacks":  # the folder, found from the root; the package is hexwar_sb3.callbacks
    raise ImportError("import hexwar_sb3.callbacks, not callbacks")
