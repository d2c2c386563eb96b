"""The usual period of motion control: the small kernels of tasks, friction and limits, called one after another.

A call costs more for each array than most kernels cost inside, so these take constant numbers in rows:

- `axes` (3, 6): root, rates, damping of the frame; `shape` (7,): its largest speeds, and `free`, `threshold`,
  `error_rate` and the two `approach` speeds of the friction feed-forward;
- `springs` (6, m): target, rates, largest speed, velocity and acceleration of the target, damping of the joints;
- `bounds` (12, n): Coulomb and viscous friction, largest compensated velocity; speed and least deceleration of the
  velocity limit; lower and upper position, friction, gravity, least deceleration and retreat of the position limit;
  torque limit. `margins` (9,): friction scale; horizon and demand of the velocity limit; share, gain, horizon, demand
  and demand of a retreat of the position limit; reserve.

They fill `matrices` (2, n, n): H and G; `vectors` (8, n): f, g, friction, held, lower and upper
bounds of the velocity limit and of the position limit; `ranges` (2, 2 n): lower and upper bounds of all limits.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from math import inf

import numpy as np

from .algebra import add_multiplied_transposed, add_normal_equations, cholesky, gram_of_rows, product, solve_factored
from .compile import FLAG, MATRIX, NUMBER, OUT_MATRICES, OUT_MATRIX, OUT_VECTOR, VECTOR, kernel
from .frame import frame_rows, frame_velocity, motion_law, pose_error
from .friction import clip, friction_torque
from .joint_limits import position_limit, velocity_bounds
from .joints import linear_rows, linear_velocity
from .program import joint_torque, narrow, nearest_bound, smallest_margin, torque_bounds

_STATE = (VECTOR, VECTOR, MATRIX, VECTOR, VECTOR, MATRIX, VECTOR)
"""Types of q, v, J, Jdot v, position, rotation and twist."""
_TASKS = (VECTOR, MATRIX, VECTOR, VECTOR, MATRIX, VECTOR, MATRIX, MATRIX, NUMBER)
"""Types of the reference (position, rotation, twist, acceleration), and of axes, shape, C, springs and their root."""
_LIMITS = (MATRIX, MATRIX, VECTOR)
"""Types of S, bounds and margins."""


@kernel(FLAG, *_STATE, *_TASKS, OUT_MATRICES, OUT_MATRIX)
def task_equations(
    q, v, J, Jdot_v, p, R, twist, p_ref, R_ref, twist_ref, a_ref, axes, shape, C, springs, spring_root,
    matrices, vectors,
):  # fmt: skip
    """Fill the normal equations H, f of a frame task and a task of the joints, and g = Aᵀ u of their velocities u.

    The numbers of the frame are those of `motion_law` and `frame_velocity`, those of the joints those of `linear_rows`.
    The answer is False if the frame's acceleration may have to be reduced: its joints' part is longer than `free`, and
    a singular value of J is below `threshold`.
    """
    n = q.shape[0]
    H, f, g = matrices[0], vectors[0], vectors[1]
    root, rates, damping = axes[0], axes[1], axes[2]
    free, threshold = shape[2], shape[3]
    for i in range(n):
        f[i], g[i] = 0.0, 0.0
        for j in range(n):
            H[i, j] = 0.0
    error, wanted = np.empty(6), np.empty(6)
    pose_error(p_ref, R_ref, p, R, error)
    missing = motion_law(error, twist, Jdot_v, twist_ref, a_ref, rates, damping, shape[0], shape[1], wanted)
    if not missing <= free * free:
        gram, factor = np.empty((6, 6)), np.empty((6, 6))
        gram_of_rows(J, -threshold * threshold, gram)
        if not cholesky(gram, factor):
            return False
    A, b = np.empty((6, n)), np.empty(6)
    frame_rows(J, Jdot_v, wanted, root, A, b)
    add_normal_equations(A, b, H, f)
    frame_velocity(error, twist_ref, root, shape[4], shape[5], shape[6], b)
    add_multiplied_transposed(A, b, g)
    m = C.shape[0]
    velocity, B, c = np.empty(m), np.empty((m, n)), np.empty(m)
    linear_velocity(C, q, springs[0], springs[1], springs[2], spring_root, velocity)
    linear_rows(C, v, velocity, springs[3], springs[4], springs[5], spring_root, B, c)
    add_normal_equations(B, c, H, f)
    for i in range(m):
        velocity[i] += spring_root * springs[3, i]
    add_multiplied_transposed(B, velocity, g)
    return True


@kernel(
    *(NUMBER, VECTOR, VECTOR, MATRIX, VECTOR, *_LIMITS),
    *(OUT_VECTOR, OUT_VECTOR, OUT_MATRICES, OUT_MATRIX, OUT_MATRIX),
)
def optimum_and_bounds(q, v, M, h, S, bounds, margins, x, torque, matrices, vectors, ranges):
    """Fill the accelerations x that minimise ½ xᵀ H x + fᵀ x, their torque, and the bounds of the limits.

    The velocities H⁻¹ g are those for which `friction` is fed forward; `held` is h with it. The bounds are those on x,
    then on G x. The answer is the smallest distance of x to a bound. It is negative if a bound on x is nearer than the
    reserve, and -inf if H is not positive definite. The numbers are those of `friction_torque`, `velocity_bounds`,
    `position_limit` and `torque_bounds`.
    """
    n = h.shape[0]
    H, G = matrices[0], matrices[1]
    f, g, friction, held = vectors[0], vectors[1], vectors[2], vectors[3]
    lower, upper = ranges[0], ranges[1]
    factor = np.empty((n, n))
    if not cholesky(H, factor):
        return -inf
    for i in range(n):
        x[i], torque[i] = -f[i], g[i]
    solve_factored(factor, x)
    solve_factored(factor, torque)
    clip(torque, bounds[2], torque)
    friction_torque(torque, bounds[0], bounds[1], margins[0], friction)
    for i in range(n):
        held[i] = h[i] + friction[i]
    velocity_bounds(v, bounds[3], bounds[4], margins[1], margins[2], vectors[4], vectors[5])
    for i in range(n):
        lower[i], upper[i] = vectors[4, i], vectors[5, i]
    position_limit(
        q, v, M, held, S, bounds[11], bounds[5], bounds[6], bounds[7], bounds[8], margins[3], bounds[9], bounds[10],
        margins[4], margins[5], margins[6], margins[7], vectors[6], vectors[7],
    )  # fmt: skip
    narrow(vectors[6], vectors[7], lower[:n], upper[:n])
    product(S, M, G)
    torque_bounds(S, bounds[11], held, lower[n:], upper[n:])
    joint_torque(x, M, held, torque)
    if not nearest_bound(lower[:n], upper[:n]) <= -margins[8]:
        return -1.0
    return smallest_margin(x, G, lower, upper)


@kernel(
    *(NUMBER, *_STATE, MATRIX, VECTOR, *_TASKS, *_LIMITS),
    *(OUT_VECTOR, OUT_VECTOR, OUT_MATRICES, OUT_MATRIX, OUT_MATRIX),
)
def usual_period(
    q, v, J, Jdot_v, p, R, twist, M, h, p_ref, R_ref, twist_ref, a_ref, axes, shape, C, springs, spring_root,
    S, bounds, margins, x, torque, matrices, vectors, ranges,
):  # fmt: skip
    """Call `task_equations`, then `optimum_and_bounds`; the answer is -inf if the first one answers False."""
    if not task_equations(
        q, v, J, Jdot_v, p, R, twist, p_ref, R_ref, twist_ref, a_ref, axes, shape, C, springs, spring_root,
        matrices, vectors,
    ):  # fmt: skip
        return -inf
    return optimum_and_bounds(q, v, M, h, S, bounds, margins, x, torque, matrices, vectors, ranges)
