"""Who plays: bots, policy folders, models and callables; no game is played here."""
