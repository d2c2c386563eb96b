"""A quadratic program as a least distance: with y = Lᵀ x and L Lᵀ = H, the cost ½ xᵀ H x + fᵀ x is a sphere in y."""

# mypy: allow-untyped-defs

from __future__ import annotations

from math import sqrt

import numpy as np

from .algebra import cholesky
from .compile import FLAG, MATRIX, NOTHING, OUT_MATRIX, OUT_VECTOR, VECTOR, kernel


@kernel(FLAG, MATRIX, OUT_MATRIX)
def invert_factor(H, inverse):
    """Fill L⁻¹ for H = L Lᵀ, with zeros above its diagonal; return False if H is not positive definite."""
    n = H.shape[0]
    L = np.empty((n, n))
    if not cholesky(H, L):
        return False
    for j in range(n):
        for i in range(j):
            inverse[i, j] = 0.0
        inverse[j, j] = 1.0 / L[j, j]
        for i in range(j + 1, n):
            total = 0.0
            for k in range(j, i):
                total -= L[i, k] * inverse[k, j]
            inverse[i, j] = total / L[i, i]
    return True


@kernel(NOTHING, VECTOR, MATRIX, MATRIX, OUT_VECTOR, OUT_MATRIX, OUT_VECTOR)
def transform(f, G, inverse, goal, rows, length):
    """Fill goal = -L⁻¹ f, the rows of (1, G) L⁻ᵀ, and the lengths of these rows."""
    n, m = f.shape[0], G.shape[0]
    for i in range(n):
        total = 0.0
        for j in range(i + 1):
            total -= inverse[i, j] * f[j]
        goal[i] = total
    for row in range(n + m):
        square = 0.0
        for i in range(n):
            if row < n:
                total = inverse[i, row]
            else:
                total = 0.0
                for j in range(i + 1):
                    total += G[row - n, j] * inverse[i, j]
            rows[row, i] = total
            square += total * total
        length[row] = sqrt(square)
