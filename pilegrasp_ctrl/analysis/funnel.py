"""The funnel: from where the mean motion relative to the hand ends in the hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .motion_field import X_EDGES, Y_EDGES, MotionField

Array = NDArray[np.float64]

STEP = 0.005
"""From one point of a stream line to the next [m]."""

INFLOW = 0.05
"""Where objects come nearer by less than this share of the hand's speed, they are carried along: no way into it."""


@dataclass(frozen=True, slots=True, eq=False)
class Funnel:
    """Two stream lines of the mean relative motion, followed upstream from the ends of the hand's leading edge.

    Stream lines do not cross, so whatever is between them flows into the hand, and whatever is not flows past it.

    Attributes:
        x: (k,) distance ahead of the leading edge, rising from 0 [m].
        right: (k,) y of the funnel's right side [m].
        left: (k,) y of its left side [m].
    """

    x: Array
    right: Array
    left: Array

    @classmethod
    def of(cls, field: MotionField, farthest: float = 0.25) -> Funnel:
        """Follow the lines up to `farthest` [m], or until objects no longer come nearer or none was seen."""
        y = np.array([-field.half_width, field.half_width])
        points = [(0.0, *y)]
        for x in np.arange(STEP, farthest + 0.5 * STEP, STEP):
            slopes = [_slope(field, points[-1][0], side) for side in y]
            if None in slopes:
                break
            y = y + STEP * np.array(slopes, dtype=float)
            if y[0] >= y[1]:
                break
            points.append((float(x), *y))
        return cls(*np.array(points).T)

    def width_at(self, distance: float) -> float | None:
        """Return the width at a distance ahead [m], or None where the funnel does not reach so far."""
        if distance > self.x[-1] + 1e-9:
            return None
        return float(np.interp(distance, self.x, self.left - self.right))


def _slope(field: MotionField, x: float, y: float) -> float | None:
    """Return dy/dx of the stream line through a point, or None where nothing flows toward the hand."""
    u = _interpolated(field.smooth_relative, x, y)
    if not np.isfinite(u).all() or u[0] > -INFLOW * field.hand_speed:
        return None
    return float(u[1] / u[0])


def _interpolated(values: Array, x: float, y: float) -> Array:
    """Return values (nx, ny, 2) on the cells' centres, interpolated in both directions; nan outside."""
    result = np.zeros(2)
    places = []
    for edges, at in ((X_EDGES, x), (Y_EDGES, y)):
        step = edges[1] - edges[0]
        place = (at - edges[0]) / step - 0.5
        low = int(np.floor(place))
        if low < 0 or low + 1 > edges.size - 2:
            return np.full(2, np.nan)
        places.append(((low, 1.0 - (place - low)), (low + 1, place - low)))
    for i, along in places[0]:
        for j, across in places[1]:
            result = result + along * across * values[i, j]
    return result
