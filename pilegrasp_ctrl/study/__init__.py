"""Studies: conditions times seeds, in a store that survives its process, on one machine or many."""

FIRST_JUDGING_SEED = 10_000
"""First seed for judging (chosen). Gains are tuned on smaller seeds, so that no result is judged on the piles that
shaped it."""
