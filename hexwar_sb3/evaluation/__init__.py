"""Matches between players, with intervals (how results are counted)."""
