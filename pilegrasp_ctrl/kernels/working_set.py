"""The working set of a dual active-set method: bounds that count as equations, added and dropped one by one.

The point y is nearest to `goal` on the active bounds. Row `index[j]`, taken with the sign `side` of its bound, has the
force (multiplier) `force[j]`. No bound ever pulls: no force is negative. The steps are those of Goldfarb and Idnani, "A
numerically stable dual method for solving strictly convex quadratic programs", Mathematical Programming 27, 1983, for a
cost that is a sphere. The active rows are the columns of Q R, of which Q and R⁻¹ are kept, `count` columns of each.
"""

# mypy: allow-untyped-defs

from __future__ import annotations

from math import inf, sqrt

import numpy as np

from .compile import COUNT, INDICES, MATRIX, NOTHING, NUMBER, OUT_MATRIX, OUT_VECTOR, VECTOR, kernel

PARALLEL = 1e-8
"""Length outside the span of the other rows below which a row of length 1 counts as dependent [-]; chosen."""

ROUND_OFF = 1e-11
"""Largest excess of a bound that counts as met, relative to the largest entry of y [-]; chosen."""

ACTIVE_SET = (OUT_VECTOR, INDICES, COUNT, OUT_MATRIX, OUT_MATRIX, OUT_VECTOR, OUT_VECTOR)
"""Types of side (k,), index (n,), count, Q (n, n), R⁻¹ (n, n), force (n,) and y (n,)."""


@kernel(NUMBER, VECTOR, NUMBER, MATRIX, MATRIX, COUNT, OUT_VECTOR, OUT_VECTOR)
def split(row, sign, Q, inverse, count, across, relief):
    """Fill across = r - Q Qᵀ r and relief = R⁻¹ Qᵀ r for r = sign row, and return |across|²."""
    n = row.shape[0]
    for i in range(n):
        across[i] = sign * row[i]
    for j in range(count):
        relief[j] = 0.0
    # The second pass removes the round-off of the first.
    for repetition in range(2):
        along = np.empty(count)
        for j in range(count):
            total = 0.0
            for i in range(n):
                total += Q[i, j] * across[i]
            along[j] = total
        for i in range(n):
            for j in range(count):
                across[i] -= Q[i, j] * along[j]
        if repetition == 0:
            for i in range(count):
                for j in range(i, count):
                    relief[i] += inverse[i, j] * along[j]
    square = 0.0
    for i in range(n):
        square += across[i] * across[i]
    return square


@kernel(NOTHING, VECTOR, VECTOR, NUMBER, COUNT, OUT_MATRIX, OUT_MATRIX)
def extend(across, relief, square, count, Q, inverse):
    """Write column `count` of Q and of R⁻¹ for one more row, which was split."""
    length = sqrt(square)
    for i in range(across.shape[0]):
        Q[i, count] = across[i] / length
    for i in range(count):
        inverse[i, count] = -relief[i] / length
        inverse[count, i] = 0.0
    inverse[count, count] = 1.0 / length


@kernel(COUNT, MATRIX, OUT_VECTOR, INDICES, COUNT, NUMBER, OUT_MATRIX, OUT_MATRIX)
def factorise(rows, side, index, count, shortest, Q, inverse):
    """Factorise the active rows in their order, and return the new count.

    Rows with a length outside the span of the earlier ones that is not above `shortest` are left out.
    """
    n = rows.shape[1]
    across, relief = np.empty(n), np.empty(n)
    kept = 0
    for j in range(count):
        row = index[j]
        square = 0.0
        if kept < n:
            square = split(rows[row], side[row], Q, inverse, kept, across, relief)
        if square > shortest * shortest:
            extend(across, relief, square, kept, Q, inverse)
            index[kept] = row
            kept += 1
        else:
            side[row] = 0.0
    return kept


@kernel(COUNT, VECTOR, MATRIX, VECTOR, VECTOR, *ACTIVE_SET)
def settle(goal, rows, lower, upper, side, index, count, Q, inverse, force, y):
    """Fill y and the forces from the active rows alone, independent of the steps that led to them; return their count.

    y = goal + Q R⁻ᵀ (bounds - rows goal) and force = R⁻¹ R⁻ᵀ (bounds - rows goal), each row with its sign.
    """
    n = goal.shape[0]
    for j in range(1, count):
        row, place = index[j], j
        while place > 0 and index[place - 1] > row:
            index[place] = index[place - 1]
            place -= 1
        index[place] = row
    count = factorise(rows, side, index, count, 0.0, Q, inverse)
    gap, step = np.empty(count), np.empty(count)
    for i in range(n):
        y[i] = goal[i]
    for j in range(count):
        force[j] = 0.0
    # The second iteration removes the round-off of the first.
    for _ in range(2):
        for j in range(count):
            row = index[j]
            value = 0.0
            for i in range(n):
                value += rows[row, i] * y[i]
            gap[j] = lower[row] - value if side[row] > 0.0 else value - upper[row]
        for j in range(count):
            total = 0.0
            for i in range(j + 1):
                total += inverse[i, j] * gap[i]
            step[j] = total
        for i in range(n):
            for j in range(count):
                y[i] += Q[i, j] * step[j]
        for i in range(count):
            for j in range(i, count):
                force[i] += inverse[i, j] * step[j]
    return count


@kernel(COUNT, OUT_VECTOR, INDICES, COUNT, OUT_VECTOR, COUNT)
def drop(side, index, count, force, place):
    """Drop the active row at a place of the index, and return the new count."""
    side[index[place]] = 0.0
    for j in range(place, count - 1):
        index[j], force[j] = index[j + 1], force[j + 1]
    return count - 1


@kernel(COUNT, MATRIX, COUNT, NUMBER, NUMBER, *ACTIVE_SET)
def add(rows, row, sign, gap, side, index, count, Q, inverse, force, y):
    """Move y to a point on one more bound, which it exceeds by `gap`, and drop the bounds that would begin to pull.

    Return the new count, or -1 if there is no such point; then no point is within all bounds. Each active bound loses
    `relief` of its force per unit of the new bound's force.
    """
    n = rows.shape[1]
    across, relief = np.empty(n), np.empty(n)
    own = 0.0
    while True:
        square = split(rows[row], sign, Q, inverse, count, across, relief)
        independent = square > PARALLEL * PARALLEL
        full = gap / square if independent else inf
        first, partial = -1, inf
        for j in range(count):
            if relief[j] > 0.0 and force[j] / relief[j] < partial:
                first, partial = j, force[j] / relief[j]
        step = full if full < partial else partial
        if step == inf:
            return -1
        own += step
        for j in range(count):
            force[j] -= step * relief[j]
        if independent:
            for i in range(n):
                y[i] += step * across[i]
            gap -= step * square
        if full <= partial:
            break
        count = drop(side, index, count, force, first)
        count = factorise(rows, side, index, count, 0.0, Q, inverse)
    extend(across, relief, square, count, Q, inverse)
    side[row], index[count], force[count] = sign, row, own
    return count + 1


@kernel(COUNT, VECTOR, MATRIX, VECTOR, VECTOR, VECTOR, OUT_VECTOR)
def nearest_point(goal, rows, lower, upper, guess, y):
    """Fill the y nearest to goal with lower <= rows y <= upper, and return the number of bounds that were added.

    Return -1 if no y is within the bounds. The guess of the active bounds is positive at lower ones, negative at upper
    ones, and otherwise zero; rows have unit length. First, bounds that pull are dropped. Then the most exceeded bound
    is added until none is exceeded. The right guess needs no step. The answer is in closed form for the final active
    set, so it does not depend on the guess.
    """
    k, n = rows.shape
    side, index, force = np.zeros(k), np.empty(k, np.int64), np.empty(n)
    Q, inverse = np.empty((n, n)), np.empty((n, n))
    count = 0
    for row in range(k):
        if guess[row] > 0.0 and lower[row] > -inf:
            side[row] = 1.0
        elif guess[row] < 0.0 and upper[row] < inf:
            side[row] = -1.0
        if side[row] != 0.0:
            index[count] = row
            count += 1
    count = factorise(rows, side, index, count, PARALLEL, Q, inverse)
    pulling = True
    while pulling:
        count = settle(goal, rows, lower, upper, side, index, count, Q, inverse, force, y)
        pulling = False
        for j in range(count - 1, -1, -1):
            if force[j] < 0.0:
                count = drop(side, index, count, force, j)
                pulling = True
    settled, steps = True, 0
    # The method needs about as many steps as there are rows; only round-off could cause more.
    for _ in range(10 * k + 1):
        worst, most, largest = -1, 0.0, 0.0
        for i in range(n):
            if abs(y[i]) > largest:
                largest = abs(y[i])
        below = False
        for row in range(k):
            if side[row] == 0.0:
                value = 0.0
                for i in range(n):
                    value += rows[row, i] * y[i]
                excess = lower[row] - value
                if value - upper[row] > excess:
                    excess = value - upper[row]
                if worst < 0 or excess > most:
                    worst, most, below = row, excess, value < lower[row]
        if worst >= 0 and most > ROUND_OFF * (1.0 + largest):
            sign = 1.0 if below else -1.0
            count = add(rows, worst, sign, most, side, index, count, Q, inverse, force, y)
            if count < 0:
                return -1
            settled = False
            steps += 1
        elif settled:
            return steps
        else:
            count = settle(goal, rows, lower, upper, side, index, count, Q, inverse, force, y)
            settled = True
    return -1
