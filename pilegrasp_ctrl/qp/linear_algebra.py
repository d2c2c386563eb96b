"""Small dense factorisations by Eigen, through the bindings that Pinocchio itself uses.

At six or seven rows the call is what costs: these take a third to a fifth of the time of `numpy.linalg`.
"""

from __future__ import annotations

from eigenpy import LLT, SelfAdjointEigenSolver  # type: ignore[import-untyped]

from ..types import Array


def solve_positive_definite(A: Array, b: Array) -> Array:
    """Return A⁻¹ b for a symmetric positive definite A (n, n) and b (n,) or (n, m), by its Cholesky factor."""
    return LLT(A).solve(b)


def inverse_square_root(A: Array) -> Array:
    """Return A^-½ (n, n) for a symmetric positive definite A, by its eigenvalues."""
    return SelfAdjointEigenSolver(A).operatorInverseSqrt()
