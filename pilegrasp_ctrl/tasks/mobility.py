"""The mobility that an arm shows along rows of a task."""

from __future__ import annotations

import numpy as np

from ..kernels.algebra import cholesky, mobility
from ..types import Array


def mobility_of(M: Array, J: Array) -> Array:
    """Return J M⁻¹ Jᵀ (m, m) for the rows J (m, nv) and the inertia M (nv, nv)."""
    factor, columns, out = np.empty(M.shape), np.empty(J.T.shape), np.empty((len(J), len(J)))
    cholesky(M, factor)
    mobility(factor, J, columns, out)
    return out
