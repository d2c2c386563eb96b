"""Studies: conditions times seeds, in a store that survives its process, on one machine or many."""

from ..exceptions import ConfigurationError

FIRST_JUDGING_SEED = 10_000
"""First seed for judging (chosen). Gains are tuned on smaller seeds, so that no result is judged on the piles that
shaped it."""

FIRST_FRESH_SEED = 30_000
"""First seed of what is called fresh outside the kept ledger, and of `pilegrasp paper` by default (chosen). Seeds from
10000 on were looked at again and again, and those from 50000 on are kept for one judgement of the paper's claims."""

MAX_SEED = 2**63 - 1
"""Largest seed; a study keeps seeds as integers of 64 bits."""

MAX_ATTEMPTS = 1_000_000
"""Largest number of attempts of a study that are asked for at once (chosen): two weeks of a processor."""

MAX_CONDITIONS = 10_000
"""Largest number of combinations that a study varies (chosen); checking them takes half a minute."""

MAX_JOBS = 1_000
"""Largest number of worker processes on one machine (chosen): each takes 200 MB."""


def check_count(attempts: int, asker: str) -> None:
    """Refuse more attempts than a study can hold, before they are listed.

    Args:
        attempts: Number of attempts.
        asker: Beginning of the sentence, such as "--seeds '0:3' asks".

    Raises:
        ConfigurationError: There are too many.
    """
    if attempts > MAX_ATTEMPTS:
        raise ConfigurationError(
            f"{asker} for {attempts:.3g} attempts; {MAX_ATTEMPTS} are allowed at once, and more can be added to a study"
        )
