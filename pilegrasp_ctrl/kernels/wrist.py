"""The wrist sensor's reading, and the forces that a primitive monitors in it."""

# mypy: allow-untyped-defs

from __future__ import annotations

from math import sqrt

import numpy as np

from .algebra import product
from .compile import COUNT, MATRIX, NOTHING, NUMBER, OUT_VECTOR, VECTOR, kernel

ROUNDING = float(3 << 51)
"""1.5 times 2^52 [-]. Numbers next to it are whole, so adding and subtracting it rounds a number below 2^51 to the
nearest whole one, and a half to the even one."""


@kernel(COUNT, VECTOR, NUMBER, MATRIX, VECTOR, VECTOR, OUT_VECTOR)
def whole_steps(load, samples, to_steps, faults, limit, steps):
    """Fill round(to_steps load / samples + faults), each channel within -limit and limit.

    Return the first channel that reaches its limit, -1 if none does. What is not a number stays so.
    """
    saturated = -1
    for i in range(steps.shape[0]):
        total = 0.0
        for j in range(load.shape[0]):
            total += to_steps[i, j] * (load[j] / samples)
        step = (total + faults[i] + ROUNDING) - ROUNDING
        if abs(step) >= limit[i]:
            step = limit[i] if step > 0.0 else -limit[i]
            if saturated < 0:
                saturated = i
        steps[i] = step
    return saturated


@kernel(NOTHING, VECTOR, MATRIX, MATRIX, VECTOR, MATRIX, VECTOR, OUT_VECTOR)
def world_wrench(steps, from_steps, lift, up, R, zero, wrench):
    """Fill R (from_steps steps + lift Rᵀ up - zero), for the linear and for the angular part: a reading in world axes.

    `lift Rᵀ up` takes out the weight of a tool, for the vertical `up` (3,) and the sensor's rotation R.
    """
    for half in range(0, 6, 3):
        for k in range(3):
            wrench[half + k] = 0.0
        for i in range(half, half + 3):
            local = -zero[i]
            for j in range(6):
                local += from_steps[i, j] * steps[j]
            for j in range(3):
                local += lift[i, j] * (R[0, j] * up[0] + R[1, j] * up[1] + R[2, j] * up[2])
            for k in range(3):
                wrench[half + k] += R[k, i - half] * local


@kernel(NOTHING, VECTOR, NUMBER, OUT_VECTOR)
def low_pass(last, blend, value):
    """Replace `value` by last + blend (value - last): a low-pass of first order."""
    for i in range(value.shape[0]):
        value[i] = last[i] + blend * (value[i] - last[i])


@kernel(
    *(NOTHING, VECTOR, MATRIX, MATRIX, VECTOR, MATRIX, MATRIX, VECTOR, VECTOR, NUMBER, OUT_VECTOR),
)
def reading(steps, from_steps, lift, up, axes, R_site, zero, last, blend, wrench):
    """Fill the `world_wrench` of a sensor with the rotation `axes R_site`, after the `low_pass`."""
    R = np.empty((3, 3))
    product(axes, R_site, R)
    world_wrench(steps, from_steps, lift, up, R, zero, wrench)
    low_pass(last, blend, wrench)


@kernel(NUMBER, VECTOR, VECTOR, VECTOR)
def change_along(wrench, start, direction):
    """Return the change of the force (the first three entries of a wrench) since `start`, along `direction` (3,)."""
    total = 0.0
    for i in range(3):
        total += direction[i] * (wrench[i] - start[i])
    return total


@kernel(NUMBER, VECTOR, VECTOR)
def change_size(wrench, start):
    """Return the magnitude of the change of the force (the first three entries of a wrench) since `start`."""
    total = 0.0
    for i in range(3):
        total += (wrench[i] - start[i]) * (wrench[i] - start[i])
    return sqrt(total)
