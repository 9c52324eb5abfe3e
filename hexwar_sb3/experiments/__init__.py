"""Experiments: lists of training runs, each made by one command, and what is drawn from their results."""
