"""A small capsule around points and balls."""

from __future__ import annotations

from contextlib import suppress
from math import cos, inf, pi, sin, sqrt

import numpy as np
from eigenpy import SelfAdjointEigenSolver  # type: ignore[import-untyped]

from ..types import Array
from ..vectors import product, rotated

MIN_RADIUS = 1e-3
"""Radius of a capsule around points on a line [m]; chosen."""
_SLACK = 1e-9
"""Length by which a capsule exceeds what its points need, because distances round [m]; chosen."""
_EXCESS = 0.3
"""Square root of the radius' excess over the least one, at which the search begins [-]; chosen."""


def fit_capsule(points: Array, radii: Array) -> tuple[Array, Array, float]:
    """Return start (3,), end (3,) and radius of a capsule around balls [m].

    A search over axis, position and radius makes the volume small; the ends follow from the balls. It begins at each
    principal axis of the centres, and the smallest capsule is kept.

    Args:
        points: (n, 3) Centres of the balls [m].
        radii: (n,) Their radii, which may be zero [m].
    """
    from scipy.optimize import minimize  # it takes 0.2 s to load

    points, radii = _corners(points, radii)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    scale = max(float(np.abs(points - middle).max() + radii.max()), MIN_RADIUS)
    points, radii = (points - middle) / scale, radii / scale
    axes: Array = SelfAdjointEigenSolver(product(points.T, points)).eigenvectors()
    start, end, radius, least = points[0], points[0], 1.0, inf
    for shift in range(3):
        frame = np.roll(axes, shift, axis=1)
        found = minimize(
            lambda x, frame=frame: _volume(*_capsule(points, radii, frame, x)),
            [0.0, 0.0, 0.0, 0.0, _EXCESS],
            method="Nelder-Mead",
            options={"maxiter": 2000, "xatol": 1e-5, "fatol": 1e-7},
        )
        if found.fun < least:
            start, end, radius = _capsule(points, radii, frame, found.x)
            least = found.fun
    return middle + scale * start, middle + scale * end, max(scale * radius + _SLACK, MIN_RADIUS)


def _corners(points: Array, radii: Array) -> tuple[Array, Array]:
    """Return the balls without points inside the hull of the others."""
    from scipy.spatial import ConvexHull, QhullError

    bare = np.unique(points[radii == 0.0], axis=0)
    with suppress(QhullError):  # it means that the points are flat
        bare = bare[ConvexHull(bare).vertices] if len(bare) > 4 else bare
    balls = radii > 0.0
    return np.vstack((bare, points[balls])), np.concatenate((np.zeros(len(bare)), radii[balls]))


def _capsule(points: Array, radii: Array, frame: Array, x: Array) -> tuple[Array, Array, float]:
    """Return the shortest capsule around balls with a given axis and radius.

    Args:
        points: (n, 3) Centres of the balls.
        radii: (n,) Their radii.
        frame: (3, 3) Columns: two sides and the axis, before it is turned.
        x: (5,) Two turns of the axis [rad], its offset along the two sides, and the square root of the radius' excess
            over the least one.
    """
    turn, tilt, side, other, excess = x.tolist()
    axis = np.array([sin(turn) * cos(tilt), sin(tilt), cos(turn) * cos(tilt)])
    first = np.array([cos(turn), 0.0, -sin(turn)])
    turned = product(frame, np.column_stack((first, np.cross(axis, first), axis)))
    local = product(points, turned)
    across = np.hypot(local[:, 0] - side, local[:, 1] - other)
    radius = float((across + radii).max()) * (1.0 + excess * excess)
    reach = np.sqrt(np.maximum((radius - radii) ** 2 - across * across, 0.0))
    low, high = float((local[:, 2] + reach).min()), float((local[:, 2] - reach).max())
    if low > high:
        low = high = 0.5 * (low + high)
    return rotated(turned, [side, other, low]), rotated(turned, [side, other, high]), radius


def _volume(start: Array, end: Array, radius: float) -> float:
    length = sqrt(float(((end - start) ** 2).sum()))
    return pi * radius * radius * (length + 4.0 / 3.0 * radius)
