"""Points that cover a box evenly, for the first proposals of a search."""

from __future__ import annotations


def even_shares(number: int, dimensions: int) -> list[float]:
    """Return point `number` of an additive recurrence in the unit cube: one share in [0, 1) for each dimension.

    The shares are multiples of powers of 1 / g modulo 1, with g^(d + 1) = g + 1. They leave no large gaps in d
    dimensions (Kronecker sequences; H. Niederreiter, Random Number Generation and Quasi-Monte Carlo Methods, 1992).
    """
    g = 2.0
    for _ in range(50):
        g = (1.0 + g) ** (1.0 / (dimensions + 1))
    return [(0.5 + number * g ** -(axis + 1)) % 1.0 for axis in range(dimensions)]
