"""Grouped self-play (III-C, Fig. 6): groups, round robin, selection."""
