"""The search over strategies: it proposes candidates, lets them race, and judges the winner on fresh seeds."""

MAX_BUDGET = 100_000
"""Largest number of attempts of a search (chosen): two days of a processor."""
MAX_CANDIDATES = 64
"""Largest number of candidates of a search (chosen)."""
MAX_PARAMETERS = 20
"""Largest number of keys that a search varies (chosen)."""
MAX_CHOICES = 100
"""Largest number of values of a key without an order, and of worlds (chosen)."""
