"""Two shapes that approach each other: the rate of their distance, and how fast the distance may shrink."""

# mypy: allow-untyped-defs

from __future__ import annotations

from math import sqrt

from .approach import allowed_speed, approach_acceleration
from .compile import MATRIX, NOTHING, NUMBER, OUT_MATRIX, OUT_VECTOR, VECTOR, kernel


@kernel(NOTHING, MATRIX, MATRIX, MATRIX, VECTOR, MATRIX, MATRIX, VECTOR, OUT_VECTOR, OUT_MATRIX)
def capsule_motion(J, moves, poses, rows, starts, ends, v, speeds, middles):
    """Fill the speed of the faster end of each capsule's axis [m/s], and the middle of the axis [m].

    No point of an axis moves faster than its faster end. `poses` holds the homogeneous matrices (4, 4) of joints, one
    below the other, and `rows` (c,) where that of each capsule begins; `starts` and `ends` (c, 3) are the ends in it.
    `moves` (c, nv) is 1 for the joints that move a capsule. J (6, nv) is as in `distance_rows`.
    """
    for i in range(starts.shape[0]):
        row = int(rows[i])
        speeds[i] = 0.0
        for k in range(3):
            middles[i, k] = 0.0
        for point in (starts[i], ends[i]):
            x, y, z = poses[row, 3], poses[row + 1, 3], poses[row + 2, 3]
            for k in range(3):
                x += poses[row, k] * point[k]
                y += poses[row + 1, k] * point[k]
                z += poses[row + 2, k] * point[k]
            a, b, c = 0.0, 0.0, 0.0
            for j in range(J.shape[1]):
                rate = moves[i, j] * v[j]
                a += rate * (J[0, j] + J[4, j] * z - J[5, j] * y)
                b += rate * (J[1, j] + J[5, j] * x - J[3, j] * z)
                c += rate * (J[2, j] + J[3, j] * y - J[4, j] * x)
            speeds[i] = max(speeds[i], sqrt(a * a + b * b + c * c))
            middles[i, 0] += 0.5 * x
            middles[i, 1] += 0.5 * y
            middles[i, 2] += 0.5 * z


@kernel(NOTHING, MATRIX, VECTOR, MATRIX, VECTOR, VECTOR, OUT_VECTOR)
def least_distances(middles, reaches, boxes, firsts, seconds, least):
    """Fill a distance that the surfaces of each pair have at least [m].

    A capsule lies within `reaches` of its middle. The second shape of a pair is a capsule; an index from the number of
    capsules on means a box. A row of `boxes` has 15 numbers: middle, rotation by rows, and half edges.
    """
    count = middles.shape[0]
    for pair in range(firsts.shape[0]):
        i, k = int(firsts[pair]), int(seconds[pair])
        square = 0.0
        for axis in range(3):
            off = 0.0
            if k < count:
                off = middles[i, axis] - middles[k, axis]
            else:
                box = boxes[k - count]
                for j in range(3):
                    off += box[3 + 3 * j + axis] * (middles[i, j] - box[j])
                off = max(abs(off) - box[12 + axis], 0.0)
            square += off * off
        least[pair] = sqrt(square) - reaches[i]
        if k < count:
            least[pair] -= reaches[k]


@kernel(NOTHING, VECTOR, NUMBER, NUMBER, OUT_VECTOR)
def stopping_distances(speeds, braking, gain, distances):
    """Fill the distances to the margin from which speeds are allowed [m]: phi(distance) = speed, as `allowed_speed`."""
    knee = braking / gain
    for i in range(speeds.shape[0]):
        if speeds[i] > knee:
            distances[i] = (speeds[i] * speeds[i] + knee * knee) / (2.0 * braking)
        else:
            distances[i] = speeds[i] / gain


@kernel(NOTHING, MATRIX, MATRIX, MATRIX, MATRIX, VECTOR, OUT_MATRIX, OUT_VECTOR)
def distance_rows(J, moves, p, n, v, G, rate):
    """Fill the rows G (m, nv) of the rates of distances, and the rates G v [m/s].

    J (6, nv) holds the twists of the joints at the world's origin. Joint j moves a point p by J_v + J_w x p, and the
    distance along the unit vector n by

        G_j = moves_j (n · J_v + J_w · (p x n))

    `moves` (m, nv) is 1 for a joint that moves only the shape into which n points. It is -1 for a joint that moves only
    the other shape, and 0 for one that moves both or none.
    """
    for i in range(p.shape[0]):
        x = p[i, 1] * n[i, 2] - p[i, 2] * n[i, 1]
        y = p[i, 2] * n[i, 0] - p[i, 0] * n[i, 2]
        z = p[i, 0] * n[i, 1] - p[i, 1] * n[i, 0]
        total = 0.0
        for j in range(J.shape[1]):
            linear = n[i, 0] * J[0, j] + n[i, 1] * J[1, j] + n[i, 2] * J[2, j]
            G[i, j] = moves[i, j] * (linear + x * J[3, j] + y * J[4, j] + z * J[5, j])
            total += G[i, j] * v[j]
        rate[i] = total


@kernel(NOTHING, VECTOR, VECTOR, NUMBER, NUMBER, NUMBER, OUT_VECTOR)
def spare_speeds(d, rate, braking, gain, retreat, spare):
    """Fill phi(d) + rate, by how much faster the shapes might approach [m/s]."""
    for i in range(d.shape[0]):
        spare[i] = allowed_speed(d[i], braking, gain, retreat) + rate[i]


@kernel(NOTHING, VECTOR, VECTOR, VECTOR, NUMBER, NUMBER, NUMBER, NUMBER, NUMBER, OUT_VECTOR)
def approach_bounds(d, rate, rate_now, braking, gain, retreat, demand, horizon, lower):
    """Fill the lower bounds on what the joint accelerations add to the second derivatives of distances [m/s²].

    d and `rate` are a distance to the margin and its rate after the horizon T, without joint acceleration; see
    `approach_acceleration`. The second derivative itself is `x + (rate - rate_now) / T` for an addition of x; a bound
    demands at most `demand` of it.
    """
    for i in range(d.shape[0]):
        wanted = -approach_acceleration(d[i], -rate[i], braking, gain, retreat, horizon)
        lower[i] = min(wanted, demand - (rate[i] - rate_now[i]) / horizon)
