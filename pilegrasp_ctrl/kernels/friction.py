"""The friction law of the joints, which every controller and observer shares."""

# mypy: allow-untyped-defs

from __future__ import annotations

from math import tanh

import numpy as np

from .algebra import cholesky, solve_factored
from .compile import MATRIX, NOTHING, NUMBER, OUT_MATRIX, OUT_VECTOR, VECTOR, kernel


@kernel(NOTHING, VECTOR, VECTOR, NUMBER, OUT_VECTOR)
def coulomb_torque(v, coulomb, scale, torque):
    """Fill `coulomb tanh(v / scale)`, the torque against the dry friction of joints that move at v [N·m].

    Dry friction jumps at rest, and a control law must not follow that jump; the hyperbolic tangent passes through zero.
    At the speed `scale` [rad/s] three quarters of the Coulomb friction act. A simulated joint that sticks needs another
    law; see `plant/joint_friction.py`.
    """
    for i in range(v.shape[0]):
        torque[i] = coulomb[i] * tanh(v[i] / scale)


@kernel(NOTHING, VECTOR, VECTOR, VECTOR, NUMBER, OUT_VECTOR)
def friction_torque(v, coulomb, viscous, scale, torque):
    """Fill `coulomb tanh(v / scale) + viscous v`, the torque against all friction of joints that move at v [N·m]."""
    coulomb_torque(v, coulomb, scale, torque)
    for i in range(v.shape[0]):
        torque[i] += viscous[i] * v[i]


@kernel(NOTHING, VECTOR, VECTOR, OUT_VECTOR)
def clip(v, limit, clipped):
    """Fill v within -limit and limit."""
    for i in range(v.shape[0]):
        clipped[i] = min(max(v[i], -limit[i]), limit[i])


@kernel(
    *(NOTHING, MATRIX, VECTOR, VECTOR, VECTOR, VECTOR, NUMBER, VECTOR, MATRIX, VECTOR),
    *(VECTOR, VECTOR, OUT_MATRIX, OUT_VECTOR, OUT_VECTOR, OUT_VECTOR),
)
def allow_for_friction(
    M, v, moving, coulomb, viscous, scale, forward, G, on_torque, lower, upper, range_, drift, new_lower, new_upper
):
    """Move bounds on accelerations, so that those that follow after friction has acted keep lower and upper.

        drift = M⁻¹ (forward - coulomb tanh(moving / scale) - viscous v),      lower <= a + drift <= upper

    for the feed-forward `forward` against friction and the direction in which the joints are `moving`. `range_` holds
    the smallest (row 0) and the largest (row 1) change of each bound so far, which all count. Bounds that are
    `on_torque` (not 0) stay. Where nothing is left between two bounds, the lower one wins.
    """
    n, rows = v.shape[0], lower.shape[0]
    factor, rest = np.empty((n, n)), np.empty(n)
    coulomb_torque(moving, coulomb, scale, rest)
    for i in range(n):
        drift[i] = (-rest[i] - viscous[i] * v[i]) + forward[i]
    if not cholesky(M, factor):
        factor[:, :] = np.nan
    solve_factored(factor, drift)
    for i in range(rows):
        change = 0.0
        if on_torque[i] == 0.0:
            if i < n:
                change = drift[i]
            else:
                for j in range(n):
                    change += G[i - n, j] * drift[j]
        # A NaN replaces every number, and none replaces it.
        if change < range_[0, i] or change != change:
            range_[0, i] = change
        if change > range_[1, i] or change != change:
            range_[1, i] = change
        new_lower[i] = lower[i] - range_[0, i]
        new_upper[i] = max(upper[i] - range_[1, i], new_lower[i])
