"""Products and lengths of vectors and small matrices, with the same bits on every processor.

numpy's `@`, `dot` and `linalg` call BLAS and LAPACK, which add in another order on another processor. These functions
multiply and add elementwise, in the order of the indices (from eight terms on in numpy's fixed pairwise order). They
serve set-up and planning; what runs in every control period has a kernel.
"""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Array = NDArray[np.float64]


def components(vectors: ArrayLike, axis: ArrayLike) -> _Array:
    """Return the scalar products (...) of `vectors` (..., n) with `axis` (n,)."""
    products: _Array = (np.asarray(vectors, dtype=np.float64) * np.asarray(axis, dtype=np.float64)).sum(axis=-1)
    return products


def inner(first: ArrayLike, second: ArrayLike) -> float:
    """Return the scalar product of two vectors (n,)."""
    return float(components(first, second))


def norm(vector: ArrayLike) -> float:
    """Return the length of a vector (n,)."""
    return sqrt(inner(vector, vector))


def rotated(rotation: ArrayLike, vectors: ArrayLike) -> _Array:
    """Return `vectors` (..., n) multiplied by a matrix (m, n), or each by its own matrix (..., m, n)."""
    return components(rotation, np.asarray(vectors, dtype=np.float64)[..., None, :])


def product(first: ArrayLike, second: ArrayLike) -> _Array:
    """Return the matrix product (..., m, n) of matrices (..., m, k) and (..., k, n)."""
    a, b = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    total: _Array = (a[..., :, :, None] * b[..., None, :, :]).sum(axis=-2)
    return total


def in_order(numbers: Any) -> float:
    """Return the sum of numbers, added in their order; the builtin `sum` rounds differently since Python 3.12."""
    total = 0.0
    for number in numbers:
        total += number
    return total
