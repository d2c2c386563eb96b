"""The bounds on joint accelerations that keep speeds and positions of the joints within their limits."""

# mypy: allow-untyped-defs

from __future__ import annotations

from math import inf

import numpy as np

from .approach import approach_acceleration
from .compile import MATRIX, NOTHING, NUMBER, OUT_MATRIX, OUT_VECTOR, VECTOR, kernel


@kernel(NOTHING, MATRIX, VECTOR, VECTOR, OUT_MATRIX)
def spare_torque(S, limit, h, spare):
    """Fill how far the torque of each joint may rise (row 0) and fall (row 1) from h alone: |S tau| <= limit [N·m].

    The entries of a joint are negative where the other joints' torques alone exceed a limit.
    """
    for j in range(h.shape[0]):
        spare[0, j], spare[1, j] = inf, inf
    for i in range(S.shape[0]):
        held = 0.0
        for j in range(h.shape[0]):
            held += S[i, j] * h[j]
        for j in range(h.shape[0]):
            if S[i, j] != 0.0:
                rise, fall = (limit[i] - held) / abs(S[i, j]), (limit[i] + held) / abs(S[i, j])
                if S[i, j] < 0.0:
                    rise, fall = fall, rise
                spare[0, j] = min(spare[0, j], rise)
                spare[1, j] = min(spare[1, j], fall)


@kernel(NOTHING, MATRIX, MATRIX, VECTOR, VECTOR, NUMBER, VECTOR, OUT_MATRIX, OUT_VECTOR)
def braking_deceleration(spare, M, friction, gravity, share, least, deceleration, slope):
    """Fill the deceleration of each joint that moves down (row 0) and up (row 1), the others at constant speed.

    It is share (spare - friction) / M_ii, and at least `least` [rad/s²]. `slope` gets share gravity / M_ii, by which it
    falls at most on the way, for the largest torque of gravity [rad/s² per rad].
    """
    for side in range(2):
        for i in range(least.shape[0]):
            deceleration[side, i] = max(share * (spare[side, i] - friction[i]) / M[i, i], least[i])
            slope[i] = share * gravity[i] / M[i, i]


@kernel(NUMBER, NUMBER, NUMBER, NUMBER, NUMBER)
def mean_deceleration(now, least, slope, distance):
    """Return the mean deceleration over `distance`, where it falls with `slope` from `now` to `least`."""
    if distance <= 0.0:
        return now
    if slope * distance <= now - least:
        return now - 0.5 * slope * distance
    return least + 0.5 * (now - least) * (now - least) / (slope * distance)


@kernel(NUMBER, *(NUMBER,) * 10)
def position_bound(distance, v, now, least, slope, gain, retreat, horizon, demand, retreat_demand):
    """Return the largest acceleration toward a limit at `distance`, for a joint that moves toward it with v.

    It is that of `approach_acceleration`, with the `mean_deceleration` on the way. It asks for at most `demand now`. A
    joint that is found beyond its limit returns with at most `retreat_demand least`, after it has stopped.
    """
    if distance == inf:
        return inf
    mean, largest = mean_deceleration(now, least, slope, distance), demand * now
    if distance < 0.0:
        largest = min(largest, retreat_demand * least + max(v, 0.0) / horizon)
    return max(approach_acceleration(distance - horizon * v, v, mean, gain, retreat, horizon), -largest)


@kernel(NOTHING, *(VECTOR,) * 4, MATRIX, *(VECTOR,) * 3, *(NUMBER,) * 4, OUT_VECTOR, OUT_VECTOR)
def position_bounds(
    q, v, q_lower, q_upper, deceleration, least, slope, retreat, gain, horizon, demand, retreat_demand, lower, upper
):
    """Fill the bounds on the accelerations that keep the joints able to stop within q_lower and q_upper.

    `deceleration` and `slope` are those of `braking_deceleration`. Where the two sides contradict each other, a joint
    above its range obeys the upper bound, any other the lower one.
    """
    for i in range(q.shape[0]):
        down = position_bound(
            q[i] - q_lower[i], -v[i], deceleration[0, i], least[i], slope[i],
            gain, retreat[i], horizon, demand, retreat_demand,
        )  # fmt: skip
        up = position_bound(
            q_upper[i] - q[i], v[i], deceleration[1, i], least[i], slope[i],
            gain, retreat[i], horizon, demand, retreat_demand,
        )  # fmt: skip
        if -down > up:
            if q[i] > q_upper[i]:
                down = -up
            else:
                up = -down
        lower[i], upper[i] = -down, up


@kernel(
    *(NOTHING, VECTOR, VECTOR, MATRIX, VECTOR, MATRIX, VECTOR),
    *(VECTOR, VECTOR, VECTOR, VECTOR, NUMBER, VECTOR, VECTOR, NUMBER, NUMBER, NUMBER, NUMBER, OUT_VECTOR, OUT_VECTOR),
)
def position_limit(
    q, v, M, h, S, limit,
    q_lower, q_upper, friction, gravity, share, least, retreat, gain, horizon, demand, retreat_demand, lower, upper,
):  # fmt: skip
    """Fill the `position_bounds` of a state, with the `braking_deceleration` that the limits of S tau leave."""
    n = q.shape[0]
    spare, deceleration, slope = np.empty((2, n)), np.empty((2, n)), np.empty(n)
    spare_torque(S, limit, h, spare)
    braking_deceleration(spare, M, friction, gravity, share, least, deceleration, slope)
    position_bounds(
        q, v, q_lower, q_upper, deceleration, least, slope, retreat, gain, horizon, demand, retreat_demand, lower, upper
    )


@kernel(NOTHING, VECTOR, VECTOR, VECTOR, NUMBER, NUMBER, OUT_VECTOR, OUT_VECTOR)
def velocity_bounds(v, speed, least, horizon, demand, lower, upper):
    """Fill the bounds (-speed - v) / horizon and (speed - v) / horizon, which ask for at most `demand least`."""
    for i in range(v.shape[0]):
        lower[i] = min((-speed[i] - v[i]) / horizon, demand * least[i])
        upper[i] = max((speed[i] - v[i]) / horizon, -demand * least[i])
