"""The search over gains: the gains that it tries, their judgement, and the page with the result."""

MAX_TRIALS = 10_000
"""Largest number of trials of a search (chosen); one has three numbers to choose."""
