"""Whole games: who plays, the compiled drive loop, many games at once."""
