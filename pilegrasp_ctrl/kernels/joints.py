"""Tasks of the joints: springs and dampers on linear functions of the joint positions, and on the joints' torques."""

# mypy: allow-untyped-defs

from __future__ import annotations

from math import sqrt

from .compile import MATRIX, NOTHING, NUMBER, OUT_MATRIX, OUT_VECTOR, VECTOR, kernel


@kernel(NOTHING, MATRIX, VECTOR, VECTOR, VECTOR, VECTOR, NUMBER, OUT_VECTOR)
def linear_velocity(C, q, target, rates, speed, root, velocity):
    """Fill `root clip(rates (target - C q))`, the velocity of C q toward its target: the slow mode of the springs.

    `rates` is stiffness over damping [1/s]; clip keeps each row within -speed and speed.
    """
    for i in range(C.shape[0]):
        missing = target[i]
        for j in range(C.shape[1]):
            missing -= C[i, j] * q[j]
        velocity[i] = root * min(max(rates[i] * missing, -speed[i]), speed[i])


@kernel(NOTHING, MATRIX, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, NUMBER, OUT_MATRIX, OUT_VECTOR)
def linear_rows(C, v, velocity, v_ref, a_ref, damping, root, A, b):
    """Fill the rows of C a = a_ref + damping (u + v_ref - C v): A = root C and b, with root u in `velocity`.

    With u = stiffness / damping (target - C q), these are springs and dampers; see `linear_velocity`.
    """
    for i in range(C.shape[0]):
        moving = -v_ref[i]
        for j in range(C.shape[1]):
            A[i, j] = root * C[i, j]
            moving += C[i, j] * v[j]
        b[i] = root * a_ref[i] + damping[i] * (velocity[i] - root * moving)


@kernel(
    *(NOTHING, MATRIX, MATRIX, VECTOR, VECTOR, VECTOR, VECTOR, NUMBER, VECTOR, NUMBER),
    *(OUT_MATRIX, OUT_MATRIX, OUT_VECTOR),
)
def impedance_rows(C, M, q, v, target, stiffness, ratio, damping, root, R, A, b):
    """Fill the rows R⁻¹ C M a = R⁻¹ tau of joints that C selects, for tau = K (target - C q) - D C v [N·m].

    R is the Cholesky factor of their inertia C M Cᵀ. The rows therefore measure a deviation by the inertia, as Gauss's
    principle of least constraint does; a limit on a light joint does not move the heavy ones. With m the joint's own
    entry of M, D = damping + 2 ratio sqrt(K m) damps a joint that moves alone at that ratio.
    """
    m, n = C.shape
    for i in range(m):
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += C[i, k] * M[k, j]
            A[i, j] = total
    for i in range(m):
        for j in range(i + 1):
            total = 0.0
            for k in range(n):
                total += A[i, k] * C[j, k]
            for k in range(j):
                total -= R[i, k] * R[j, k]
            R[i, j] = sqrt(total) if i == j else total / R[j, j]
    for i in range(m):
        missing, moving, inertia = target[i], 0.0, 0.0
        for j in range(n):
            missing -= C[i, j] * q[j]
            moving += C[i, j] * v[j]
            inertia += A[i, j] * C[i, j]
        drag = damping[i] + 2.0 * ratio * sqrt(stiffness[i] * inertia)
        b[i] = root * (stiffness[i] * missing - drag * moving)
    for i in range(m):
        for k in range(i):
            b[i] -= R[i, k] * b[k]
        b[i] /= R[i, i]
    for j in range(n):
        for i in range(m):
            A[i, j] *= root
            for k in range(i):
                A[i, j] -= R[i, k] * A[k, j]
            A[i, j] /= R[i, i]
