"""The forces of an impedance's springs and dampers, and what a frame shows in axes other than the world's."""

# mypy: allow-untyped-defs

from __future__ import annotations

from .compile import MATRIX, NOTHING, OUT_MATRIX, OUT_VECTOR, VECTOR, kernel


@kernel(NOTHING, MATRIX, VECTOR, OUT_VECTOR)
def turn_vector(R, x, turned):
    """Fill R^T of the linear part of x (6,), then of its angular part: a wrench or twist in axes with rotation R."""
    for half in range(0, 6, 3):
        for i in range(3):
            total = 0.0
            for k in range(3):
                total += R[k, i] * x[half + k]
            turned[half + i] = total


@kernel(NOTHING, MATRIX, MATRIX, OUT_MATRIX)
def turn_rows(R, J, turned):
    """Fill R^T of the linear rows of J (6, nv), then of its angular rows: a Jacobian in axes with rotation R."""
    for half in range(0, 6, 3):
        for i in range(3):
            for j in range(J.shape[1]):
                total = 0.0
                for k in range(3):
                    total += R[k, i] * J[half + k, j]
                turned[half + i, j] = total


@kernel(NOTHING, MATRIX, MATRIX, OUT_MATRIX)
def congruence(B, L, out):
    """Fill Bᵀ L B."""
    for i in range(B.shape[1]):
        for j in range(i + 1):
            total = 0.0
            for k in range(B.shape[0]):
                for m in range(B.shape[0]):
                    total += B[k, i] * L[k, m] * B[m, j]
            out[i, j] = total
            out[j, i] = total


@kernel(NOTHING, MATRIX, MATRIX, VECTOR, VECTOR, OUT_VECTOR)
def damping_force(B, root, ratio_and_viscous, rate, force):
    """Add the dampers' force to `force` (6,): 2 ratio B root Bᵀ rate + viscous rate.

    B is a factor of the stiffness, K = B Bᵀ, and `root` is (Bᵀ Lambda⁻¹ B)^-½. `ratio_and_viscous` (7,) holds the
    damping ratio and the viscous damping of the axes.
    """
    m = B.shape[1]
    for i in range(m):
        total = 0.0
        for j in range(m):
            along = 0.0
            for k in range(6):
                along += B[k, j] * rate[k]
            total += root[i, j] * along
        for k in range(6):
            force[k] += 2.0 * ratio_and_viscous[0] * B[k, i] * total
    for k in range(6):
        force[k] += ratio_and_viscous[1 + k] * rate[k]
