"""The search over gains: the gains that it tries, their judgement, and the page with the result."""
