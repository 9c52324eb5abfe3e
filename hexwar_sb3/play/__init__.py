"""Whole games: the compiled drive loop, many games at once."""
