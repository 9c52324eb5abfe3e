"""Learning algorithms for Stable-Baselines3: QMIX and its kin."""
