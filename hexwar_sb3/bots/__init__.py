"""Scripted players: MA1 and MA2, the ladder of simpler ones, the drawn families."""
