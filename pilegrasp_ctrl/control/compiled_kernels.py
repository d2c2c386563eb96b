"""One period of operational-space control as two compiled functions; `CompiledMotion` calls them.

They compute what `FrameMotionTask`, `FrictionCompensation` and `InverseDynamics` compute in the usual case. This module
needs numba, and its first import in an installation compiles it.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from collections.abc import Callable
from math import atan2, sqrt, tanh
from typing import Any

import numba
import numpy as np
from numba import types

_VECTOR = types.Array(types.float64, 1, "A", readonly=True)
"""Compiled type of an input vector."""
_MATRIX = types.Array(types.float64, 2, "A", readonly=True)
"""Compiled type of an input matrix."""
_OUT_VECTOR = types.Array(types.float64, 1, "C")
"""Compiled type of a vector to fill."""
_OUT_MATRIX = types.Array(types.float64, 2, "C")
"""Compiled type of a matrix to fill."""

_MIN_COSINE = -0.9
"""Cosine of the error's angle below which the usual formula of the rotation vector loses digits; chosen."""


def _compile(*signature: Any) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Compile now, for exactly these types: a new type in the middle of a motion would stop it for seconds."""

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        try:
            return numba.njit([signature[0](*signature[1:])], cache=True)(function)
        except RuntimeError:  # no folder is writable for the cache
            return numba.njit([signature[0](*signature[1:])])(function)

    return decorate


@numba.njit(inline="always")
def _shorten(vector, first, length):
    size = sqrt(vector[first] ** 2 + vector[first + 1] ** 2 + vector[first + 2] ** 2)
    if size > length:
        for i in range(first, first + 3):
            vector[i] *= length / size


@numba.njit(inline="always")
def _factorise(A, n):
    """Replace the lower triangle of A by its Cholesky factor; return False if A is not positive definite."""
    for j in range(n):
        for i in range(j, n):
            total = A[i, j]
            for k in range(j):
                total -= A[i, k] * A[j, k]
            if i == j:
                if total <= 0.0:
                    return False
                A[j, j] = sqrt(total)
            else:
                A[i, j] = total / A[j, j]
    return True


@numba.njit(inline="always")
def _substitute(L, b, n):
    """Replace b by (L Lᵀ)⁻¹ b."""
    for i in range(n):
        for k in range(i):
            b[i] -= L[i, k] * b[k]
        b[i] /= L[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            b[i] -= L[k, i] * b[k]
        b[i] /= L[i, i]


@_compile(
    types.float64,
    *(_VECTOR, _MATRIX, _VECTOR, _MATRIX, _VECTOR, _VECTOR, _MATRIX, _VECTOR),
    *(_VECTOR, _MATRIX, _VECTOR, _VECTOR),
    *(_MATRIX, _MATRIX, _MATRIX, _MATRIX, _VECTOR),
    *(_OUT_MATRIX, _OUT_VECTOR, _OUT_MATRIX, _OUT_VECTOR, _OUT_VECTOR, _OUT_VECTOR),
)
def assemble(
    x, M, h, J, Jdot_v, p, R, twist, p_ref, R_ref, twist_ref, a_ref,
    affine, coupling, tool, joint, numbers,
    H, f, G, lower, upper, offset,
):  # fmt: skip
    """Fill the program and its offset; return the nearest bound, or NaN if the case is not the usual one.

    `tool` holds the square roots of the weights, the rates (stiffness over damping) and the damping. `joint` holds the
    largest speed, Coulomb and viscous feed-forward, torque limit, and largest demand below and above. `numbers` holds:

        0       largest length of `rates e` that is not shortened
        1, 2    `free` and `threshold` of `SingularDirections`, squared
        3       square root of the posture's weight
        4       1 with friction feed-forward, 0 without
        5, 6    rate and scale of the feed-forward
        7, 8    largest approach of the feed-forward [m/s], [rad/s]

    Args:
        x: (2 n + 1,) Affine state as in `ArmState`.
        M: (n, n) Inertia as in `ArmState`.
        h: (n,) Bias torques as in `ArmState`.
        J: (6, n) Tool Jacobian as in `ArmState`.
        Jdot_v: (6,) Tool acceleration as in `ArmState`.
        p: (3,) Position of the tool.
        R: (3, 3) Orientation of the tool.
        twist: (6,) Velocity of the tool.
        p_ref: (3,) Position of the reference.
        R_ref: (3, 3) Orientation of the reference.
        twist_ref: (6,) Velocity of the reference.
        a_ref: (6,) Acceleration of the reference.
        affine: (rows, 2 n + 1) Matrix of all that is affine in the state, as `InverseDynamics` stacks it.
        coupling: (n, n) Matrix from joint torques to the torques with a limit.
        tool: (3, 6) Numbers of the tool's axes; see above.
        joint: (6, n) Numbers of the joints; see above.
        numbers: (9,) Scalars; see above.
        H: (n, n) Matrix of the cost, to fill.
        f: (n,) Linear part of the cost, to fill.
        G: (n, n) Rows of the torque limits, to fill.
        lower: (2 n,) Lower bounds, to fill.
        upper: (2 n,) Upper bounds, to fill.
        offset: (n,) Torques except that of the acceleration, to fill [N·m].
    """
    n = h.shape[0]
    values = np.empty(affine.shape[0])
    for i in range(affine.shape[0]):
        total = 0.0
        for j in range(2 * n + 1):
            total += affine[i, j] * x[j]
        values[i] = total
    targets = affine.shape[0] - 2 * (6 + n)
    blocks = targets // (2 * n)
    nearest = -np.inf
    for i in range(n):
        below, above = -np.inf, -np.inf
        for block in range(blocks - 1):
            below = max(below, values[2 * n * block + i])
            above = max(above, values[2 * n * block + n + i])
        if blocks > 0:
            last = 2 * n * (blocks - 1)
            below = min(min(below, values[last + i]), joint[4, i])
            above = min(min(above, values[last + n + i]), joint[5, i])
        nearest = max(nearest, max(below, above))
        lower[i], upper[i] = below, -above

    # The tool's error. Its angular part is the rotation vector of R_ref Rᵀ.
    error = np.empty(6)
    turn = np.zeros((3, 3))
    for i in range(3):
        error[i] = p_ref[i] - p[i]
        for j in range(3):
            for k in range(3):
                turn[i, j] += R_ref[i, k] * R[j, k]
    sx, sy, sz = 0.5 * (turn[2, 1] - turn[1, 2]), 0.5 * (turn[0, 2] - turn[2, 0]), 0.5 * (turn[1, 0] - turn[0, 1])
    sine, cosine = sqrt(sx * sx + sy * sy + sz * sz), 0.5 * (turn[0, 0] + turn[1, 1] + turn[2, 2] - 1.0)
    if not cosine > _MIN_COSINE:
        return np.nan
    scale = atan2(sine, cosine) / sine if sine > 1e-4 else 1.0 + sine * sine / 6.0
    error[3], error[4], error[5] = scale * sx, scale * sy, scale * sz

    speed, missing = 0.0, 0.0
    wanted = np.empty(6)
    for i in range(6):
        approach = tool[1, i] * error[i]
        speed += approach * approach
        wanted[i] = tool[2, i] * (approach + twist_ref[i] - twist[i]) + a_ref[i]
        missing += (wanted[i] - Jdot_v[i]) ** 2
    if not speed <= numbers[0] * numbers[0]:
        return np.nan
    if missing > numbers[1]:
        gram = np.empty((6, 6))
        for i in range(6):
            for j in range(i + 1):
                total = -numbers[2] if i == j else 0.0
                for k in range(n):
                    total += J[i, k] * J[j, k]
                gram[i, j] = total
        if not _factorise(gram, 6):
            return np.nan

    posture = numbers[3]
    factor = np.empty((n, n))
    slow = np.empty(6)
    for i in range(6):
        slow[i] = numbers[5] * error[i]
    if slow[0] ** 2 + slow[1] ** 2 + slow[2] ** 2 + slow[3] ** 2 + slow[4] ** 2 + slow[5] ** 2 > numbers[7] ** 2:
        _shorten(slow, 0, numbers[7])
        _shorten(slow, 3, numbers[8])
    v = np.empty(n)
    for i in range(n):
        total, speeds = 0.0, 0.0
        for k in range(6):
            weight = tool[0, k] * tool[0, k]
            total += J[k, i] * weight * (Jdot_v[k] - wanted[k])
            speeds += J[k, i] * weight * (slow[k] + twist_ref[k])
        f[i] = total + posture * values[targets + 12 + n + i]
        v[i] = speeds + posture * values[targets + 6 + i]
        for j in range(i + 1):
            total = posture * posture if i == j else 0.0
            for k in range(6):
                total += J[k, i] * J[k, j] * tool[0, k] * tool[0, k]
            H[i, j] = H[j, i] = factor[i, j] = total
        offset[i] = h[i]
    if numbers[4] > 0.0:
        if not _factorise(factor, n):
            return np.nan
        _substitute(factor, v, n)
        # This repeats the law of `arm/friction.py`, because compiled code cannot call that function.
        for i in range(n):
            v[i] = min(max(v[i], -joint[0, i]), joint[0, i])
            offset[i] += joint[1, i] * tanh(v[i] / numbers[6]) + joint[2, i] * v[i]
    for i in range(n):
        held = 0.0
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += coupling[i, k] * M[k, j]
            G[i, j] = total
            held += coupling[i, j] * offset[j]
        lower[n + i], upper[n + i] = -joint[3, i] - held, joint[3, i] - held
    return nearest


@_compile(types.float64, *(_VECTOR, _MATRIX, _OUT_VECTOR, _OUT_MATRIX, _OUT_VECTOR, _OUT_VECTOR, _OUT_VECTOR))
def judge(a, M, offset, G, lower, upper, torque):
    """Fill the `torque` (n,) of the accelerations `a`; return the smallest distance to a bound, or NaN."""
    n = a.shape[0]
    margin = np.inf
    for i in range(n):
        row, total = 0.0, offset[i]
        for j in range(n):
            row += G[i, j] * a[j]
            total += M[i, j] * a[j]
        torque[i] = total
        for distance in (a[i] - lower[i], upper[i] - a[i], row - lower[n + i], upper[n + i] - row):
            # A NaN stays, because it fails every comparison.
            if not distance >= margin:
                margin = distance
    return margin
