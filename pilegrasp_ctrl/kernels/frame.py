"""The task of a frame: the error of its pose, the acceleration that is wanted, and the task's rows."""

# mypy: allow-untyped-defs

from __future__ import annotations

from math import atan2, sqrt

import numpy as np

from .compile import MATRIX, NOTHING, NUMBER, OUT_MATRIX, OUT_VECTOR, VECTOR, kernel


@kernel(NOTHING, MATRIX, MATRIX, OUT_VECTOR)
def rotation_vector(R_ref, R, vector):
    """Fill the rotation vector of R_ref Rᵀ, the shortest turn from R to R_ref [rad].

    With the unit quaternion (w, u) of the turn and w >= 0 it is 2 atan2(|u|, w) u / |u|. The largest of the four
    components of the quaternion is computed first (S. W. Shepperd, J. Guidance and Control 1(3), 1978), so that no
    digits are lost at any angle.
    """
    # The turn T = R_ref Rᵀ, by rows.
    a = R_ref[0, 0] * R[0, 0] + R_ref[0, 1] * R[0, 1] + R_ref[0, 2] * R[0, 2]
    b = R_ref[0, 0] * R[1, 0] + R_ref[0, 1] * R[1, 1] + R_ref[0, 2] * R[1, 2]
    c = R_ref[0, 0] * R[2, 0] + R_ref[0, 1] * R[2, 1] + R_ref[0, 2] * R[2, 2]
    d = R_ref[1, 0] * R[0, 0] + R_ref[1, 1] * R[0, 1] + R_ref[1, 2] * R[0, 2]
    e = R_ref[1, 0] * R[1, 0] + R_ref[1, 1] * R[1, 1] + R_ref[1, 2] * R[1, 2]
    f = R_ref[1, 0] * R[2, 0] + R_ref[1, 1] * R[2, 1] + R_ref[1, 2] * R[2, 2]
    g = R_ref[2, 0] * R[0, 0] + R_ref[2, 1] * R[0, 1] + R_ref[2, 2] * R[0, 2]
    h = R_ref[2, 0] * R[1, 0] + R_ref[2, 1] * R[1, 1] + R_ref[2, 2] * R[1, 2]
    i = R_ref[2, 0] * R[2, 0] + R_ref[2, 1] * R[2, 1] + R_ref[2, 2] * R[2, 2]
    trace = a + e + i
    # Each branch gives four times the product of the quaternion with its largest component.
    if trace >= a and trace >= e and trace >= i:
        w, x, y, z = 1.0 + trace, h - f, c - g, d - b
    elif a >= e and a >= i:
        w, x, y, z = h - f, 1.0 + a - e - i, b + d, c + g
    elif e >= i:
        w, x, y, z = c - g, b + d, 1.0 - a + e - i, f + h
    else:
        w, x, y, z = d - b, c + g, f + h, 1.0 - a - e + i
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    length = sqrt(x * x + y * y + z * z)
    # For a small turn the angle over the length is 2 / w, up to its square.
    scale = 2.0 * atan2(length, w) / length if length > 0.0 else 2.0 / w
    vector[0], vector[1], vector[2] = scale * x, scale * y, scale * z


@kernel(NOTHING, VECTOR, MATRIX, VECTOR, MATRIX, OUT_VECTOR)
def pose_error(p_ref, R_ref, p, R, error):
    """Fill the error of a pose: p_ref - p [m], then the rotation vector of R_ref Rᵀ [rad]."""
    turn = error[3:]
    rotation_vector(R_ref, R, turn)
    for i in range(3):
        error[i] = p_ref[i] - p[i]


@kernel(NOTHING, OUT_VECTOR, NUMBER, NUMBER)
def shorten(vector, linear, angular):
    """Scale the linear part of `vector` (6,) to at most the length `linear`, and the angular part to `angular`."""
    for first, longest in ((0, linear), (3, angular)):
        x, y, z = vector[first], vector[first + 1], vector[first + 2]
        length = sqrt(x * x + y * y + z * z)
        if length > longest:
            for i in range(first, first + 3):
                vector[i] *= longest / length


@kernel(NUMBER, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, VECTOR, NUMBER, NUMBER, OUT_VECTOR)
def motion_law(error, twist, Jdot_v, twist_ref, a_ref, rates, damping, linear, angular, wanted):
    """Fill the wanted acceleration of a frame; return the squared length of what the joints have to add to Jdot v.

        wanted = a_ref + damping (twist_ref - twist + s(rates error)),      rates = stiffness / damping

    s shortens the speed that the springs ask for to `linear` [m/s] and `angular` [rad/s].
    """
    for i in range(6):
        wanted[i] = rates[i] * error[i]
    shorten(wanted, linear, angular)
    missing = 0.0
    for i in range(6):
        wanted[i] = a_ref[i] + damping[i] * (twist_ref[i] - twist[i] + wanted[i])
        missing += (wanted[i] - Jdot_v[i]) * (wanted[i] - Jdot_v[i])
    return missing


@kernel(NOTHING, MATRIX, VECTOR, VECTOR, VECTOR, OUT_MATRIX, OUT_VECTOR)
def frame_rows(J, Jdot_v, wanted, root, A, b):
    """Fill the rows of J a + Jdot v = wanted, each times the root of its weight: A and b = root (wanted - Jdot v)."""
    for i in range(6):
        for j in range(J.shape[1]):
            A[i, j] = root[i] * J[i, j]
        b[i] = root[i] * (wanted[i] - Jdot_v[i])


@kernel(NOTHING, VECTOR, VECTOR, VECTOR, NUMBER, NUMBER, NUMBER, OUT_VECTOR)
def frame_velocity(error, twist_ref, root, error_rate, linear, angular, velocity):
    """Fill the wanted velocity of a frame, times the roots of the weights: root (twist_ref + s(error_rate error)).

    s shortens as in `motion_law`.
    """
    for i in range(6):
        velocity[i] = error_rate * error[i]
    shorten(velocity, linear, angular)
    for i in range(6):
        velocity[i] = root[i] * (twist_ref[i] + velocity[i])


@kernel(
    *(NOTHING, MATRIX, MATRIX, VECTOR, VECTOR, VECTOR, VECTOR),
    *(VECTOR, VECTOR, NUMBER, NUMBER, OUT_VECTOR, OUT_MATRIX, OUT_MATRIX, OUT_VECTOR),
)
def axis_rows(R, J, Jdot_v, twist, axis, direction, stiffness, damping, speed, root, error, P, A, b):
    """Fill the rows of P (J_w a + Jdot v) = P (stiffness e - damping omega), with P = 1 - n nᵀ and the axis n = R axis.

    `error` gets e, the shortest rotation vector from n to `direction`; `stiffness / damping e` is shortened to `speed`.
    """
    n = np.empty(3)
    for i in range(3):
        n[i] = R[i, 0] * axis[0] + R[i, 1] * axis[1] + R[i, 2] * axis[2]
    x = n[1] * direction[2] - n[2] * direction[1]
    y = n[2] * direction[0] - n[0] * direction[2]
    z = n[0] * direction[1] - n[1] * direction[0]
    sine = sqrt(x * x + y * y + z * z)
    cosine = n[0] * direction[0] + n[1] * direction[1] + n[2] * direction[2]
    if sine < 1e-9 and cosine < 0.0:
        # Half a turn away every perpendicular axis serves: the one across the smallest component of n.
        small = 0
        for i in range(1, 3):
            if abs(n[i]) < abs(n[small]):
                small = i
        x, y, z = 0.0, 0.0, 0.0
        if small == 0:
            y, z = n[2], -n[1]
        elif small == 1:
            x, z = -n[2], n[0]
        else:
            x, y = n[1], -n[0]
        sine = sqrt(x * x + y * y + z * z)
        angle = atan2(0.0, -1.0)
    else:
        angle = atan2(sine, cosine)
    scale = angle / sine if sine > 0.0 else 0.0
    error[0], error[1], error[2] = scale * x, scale * y, scale * z
    asked = 0.0
    for i in range(3):
        asked += (stiffness[i] / damping[i] * error[i]) * (stiffness[i] / damping[i] * error[i])
    share = min(1.0, speed / sqrt(asked)) if asked > 0.0 else 1.0
    for i in range(3):
        for j in range(3):
            P[i, j] = (1.0 if i == j else 0.0) - n[i] * n[j]
    for i in range(3):
        b[i] = 0.0
        for j in range(J.shape[1]):
            A[i, j] = 0.0
        for k in range(3):
            wanted = damping[k] * (share * stiffness[k] / damping[k] * error[k] - twist[3 + k]) - Jdot_v[3 + k]
            b[i] += root * P[i, k] * wanted
            for j in range(J.shape[1]):
                A[i, j] += root * P[i, k] * J[3 + k, j]


@kernel(
    *(NOTHING, MATRIX, VECTOR, VECTOR, MATRIX, VECTOR, MATRIX, VECTOR, VECTOR, MATRIX, VECTOR),
    *(OUT_MATRIX, OUT_VECTOR, OUT_VECTOR, OUT_MATRIX, OUT_VECTOR),
)
def relative_frame(
    J, Jdot_v, p, R, twist, J_r, Jdot_v_r, p_r, R_r, twist_r, J_rel, Jdot_v_rel, p_rel, R_rel, twist_rel
):
    """Fill the kinematics of a frame as seen from a root frame r that moves, in the axes of r.

    With d = p - p_r and the root's angular velocity w, all turned by R_rᵀ:

        velocity        v - v_r - w x d,                                     omega - w
        acceleration    a - a_r - wdot x d - w x (w x d) - 2 w x (v - v_r - w x d),    omegadot - wdot - w x omega
    """
    d = np.empty(3)
    for i in range(3):
        d[i] = p[i] - p_r[i]
    n = J.shape[1]
    rows = np.empty((6, n + 2))  # columns: Jacobian, velocity, acceleration without that of the joints
    for j in range(n):
        u, w = J_r[:, j], J_r[3:, j]
        rows[0, j] = J[0, j] - u[0] - (w[1] * d[2] - w[2] * d[1])
        rows[1, j] = J[1, j] - u[1] - (w[2] * d[0] - w[0] * d[2])
        rows[2, j] = J[2, j] - u[2] - (w[0] * d[1] - w[1] * d[0])
        for i in range(3, 6):
            rows[i, j] = J[i, j] - J_r[i, j]
    w, omega, alpha = twist_r[3:], twist[3:], Jdot_v_r[3:]
    for i in range(3):
        a, c = (i + 1) % 3, (i + 2) % 3
        rows[i, n] = twist[i] - twist_r[i] - (w[a] * d[c] - w[c] * d[a])
        rows[3 + i, n] = omega[i] - w[i]
    for i in range(3):
        a, c = (i + 1) % 3, (i + 2) % 3
        across_a = w[c] * d[i] - w[i] * d[c]  # (w x d) along a, then along c
        across_c = w[i] * d[a] - w[a] * d[i]
        turning = alpha[a] * d[c] - alpha[c] * d[a] + w[a] * across_c - w[c] * across_a
        rows[i, n + 1] = Jdot_v[i] - Jdot_v_r[i] - turning - 2.0 * (w[a] * rows[c, n] - w[c] * rows[a, n])
        rows[3 + i, n + 1] = Jdot_v[3 + i] - alpha[i] - (w[a] * omega[c] - w[c] * omega[a])
    for i in range(3):
        total = 0.0
        for k in range(3):
            total += R_r[k, i] * d[k]
        p_rel[i] = total
        for j in range(3):
            total = 0.0
            for k in range(3):
                total += R_r[k, i] * R[k, j]
            R_rel[i, j] = total
        for half in range(0, 6, 3):
            for j in range(n + 2):
                total = 0.0
                for k in range(3):
                    total += R_r[k, i] * rows[half + k, j]
                if j < n:
                    J_rel[half + i, j] = total
                elif j == n:
                    twist_rel[half + i] = total
                else:
                    Jdot_v_rel[half + i] = total
