"""The quadratic program of one period: its bounds from those of the limits, and the check of an answer."""

# mypy: allow-untyped-defs

from __future__ import annotations

from math import inf

from .compile import MATRIX, NOTHING, NUMBER, OUT_MATRIX, OUT_VECTOR, VECTOR, kernel


@kernel(NOTHING, VECTOR, VECTOR, OUT_VECTOR, OUT_VECTOR)
def narrow(more_lower, more_upper, lower, upper):
    """Narrow the interval lower .. upper to its common part with another one.

    Where they have none, the first interval wins: the result is the end of it that is nearest to the other one. The
    lower bound therefore never exceeds the upper one.
    """
    for i in range(lower.shape[0]):
        low, high = lower[i], upper[i]
        lower[i] = min(max(more_lower[i], low), high)
        upper[i] = max(min(more_upper[i], high), low)


@kernel(NUMBER, VECTOR, VECTOR)
def nearest_bound(lower, upper):
    """Return the nearest bound: a positive one demands an acceleration, a negative one leaves room. NaN if one is."""
    nearest = -inf
    for i in range(lower.shape[0]):
        for bound in (lower[i], -upper[i]):
            # A NaN replaces every number, and none replaces it.
            if bound > nearest or bound != bound:
                nearest = bound
    return nearest


@kernel(NUMBER, VECTOR, MATRIX, VECTOR, VECTOR)
def smallest_margin(x, G, lower, upper):
    """Return the smallest distance of [x; G x] to a bound: negative for an exceeded one, NaN if one is NaN."""
    n = x.shape[0]
    margin = inf
    for i in range(lower.shape[0]):
        value = 0.0
        if i < n:
            value = x[i]
        else:
            for j in range(n):
                value += G[i - n, j] * x[j]
        for distance in (value - lower[i], upper[i] - value):
            # A NaN replaces every number, and none replaces it.
            if distance < margin or distance != distance:
                margin = distance
    return margin


@kernel(NUMBER, VECTOR, MATRIX, VECTOR, VECTOR, OUT_MATRIX)
def write_slack(x, G, lower, upper, slack):
    """Fill the distances r - lower, upper - r of r = [x; G x]; return the smallest one, NaN if one is NaN."""
    n = x.shape[0]
    for i in range(lower.shape[0]):
        value = 0.0
        if i < n:
            value = x[i]
        else:
            for j in range(n):
                value += G[i - n, j] * x[j]
        slack[0, i], slack[1, i] = value - lower[i], upper[i] - value
    return smallest_margin(x, G, lower, upper)


@kernel(NOTHING, VECTOR, MATRIX, VECTOR, OUT_VECTOR)
def joint_torque(a, M, h, torque):
    """Fill the torque M a + h of joint accelerations a [N·m]."""
    for i in range(h.shape[0]):
        total = h[i]
        for j in range(h.shape[0]):
            total += M[i, j] * a[j]
        torque[i] = total


@kernel(NOTHING, MATRIX, VECTOR, VECTOR, OUT_VECTOR, OUT_VECTOR)
def torque_bounds(S, limit, h, lower, upper):
    """Fill the bounds -limit - S h and limit - S h on S M a, so that |S (M a + h)| <= limit [N·m]."""
    for i in range(limit.shape[0]):
        held = 0.0
        for j in range(h.shape[0]):
            held += S[i, j] * h[j]
        lower[i], upper[i] = -limit[i] - held, limit[i] - held


@kernel(NOTHING, MATRIX, MATRIX, MATRIX, NUMBER, OUT_MATRIX)
def weighted_metric(M, A, LA, c, H):
    """Fill H = M + c Aᵀ (L A), for the rows A of the tasks and L A (m, n) with a symmetric L."""
    for i in range(M.shape[0]):
        for j in range(i + 1):
            total = 0.0
            for k in range(A.shape[0]):
                total += A[k, i] * LA[k, j]
            H[i, j] = M[i, j] + c * total
            H[j, i] = H[i, j]
