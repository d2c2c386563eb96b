"""The largest absolute eigenvalue of a small matrix."""

# mypy: allow-untyped-defs

from __future__ import annotations

from math import exp, frexp, inf, ldexp, log

import numpy as np

from .algebra import product
from .compile import MATRIX, NUMBER, kernel

DOUBLINGS = 50
"""Number of squarings [-]; chosen. What the norm of a power says beside its eigenvalue then counts by 2^-50."""

LOG_2 = log(2.0)
"""Natural logarithm of 2 [-]."""


@kernel(NUMBER, MATRIX)
def spectral_radius(A):
    """Return rho = max |eigenvalue of A|, inf if an entry is not finite.

        rho = lim |A^k|^(1/k),      k = 2, 4, 8, ...

    This is Gelfand's formula. Each power is the square of the last one, divided by a power of two 2^e, which rounds
    nothing. With the exponent e_j of the j-th square, log2(rho) is the sum of e_j / 2^j.
    """
    n = A.shape[0]
    power, square = np.empty((n, n)), np.empty((n, n))
    power[:, :] = A
    exponent, share = 0.0, 1.0
    for _ in range(DOUBLINGS):
        size = 0.0
        for i in range(n):
            for j in range(n):
                # A sum of what is not finite stays so.
                size = max(size, abs(power[i, j])) if abs(power[i, j]) < inf else inf
                if size == inf:
                    return inf
        if size == 0.0:
            return 0.0
        _, e = frexp(size)
        scale = ldexp(1.0, -e)
        for i in range(n):
            for j in range(n):
                power[i, j] *= scale
        exponent += share * e
        share *= 0.5
        product(power, power, square)
        power[:, :] = square
    return exp(LOG_2 * exponent)
