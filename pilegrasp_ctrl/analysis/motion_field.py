"""Mean motion on a grid around the hand, and the funnel: the region from which objects move into the hand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..types import Array
from ..vectors import product
from .push_motion import PushMotion

CELL = 0.02
"""Side of a cell [m], chosen: less than the radius of a tennis ball, so that neighbours are in different cells."""

X_EDGES = np.round(np.arange(-0.16, 0.3601, CELL), 6)
"""Cell edges along x in the hand's frame, from the leading edge [m]; chosen."""

Y_EDGES = np.round(np.arange(-0.23, 0.2301, CELL), 6)
"""Cell edges along y in the hand's frame [m]; chosen. The line y = 0 runs through cell centres."""

MIN_TIME = 0.1
"""Least total time of objects in a cell, or weighted by the kernel, for the cell to have a velocity [s]; chosen."""

LINE_STEP = 0.005
"""Distance along x between two points of a stream line [m]; chosen."""

MIN_INFLOW = 0.05
"""Least share of the hand's speed at which objects must approach for a stream line to continue [-]; chosen. Slower
objects are pushed along and do not reach the hand."""


@dataclass(frozen=True, eq=False)
class MotionField:
    """Sums over the cells of the grid `X_EDGES` x `Y_EDGES`.

    Attributes:
        attempts: Number of attempts in the sums.
        radius: Radius of the objects [m], mean over the attempts.
        half_width: Half the width of the hand's leading edge [m], mean over the attempts.
        hand_speed: Speed of the hand in the push [m/s], mean over the attempts.
        count: (nx, ny) number of frames with an object's centre in the cell.
        time: (nx, ny) total time of object centres in the cell [s].
        relative: (nx, ny, 2) sum of the displacements relative to the hand [m].
        absolute: (nx, ny, 2) sum of the displacements in the scene, along the axes of the hand's frame [m].
    """

    attempts: int
    radius: float
    half_width: float
    hand_speed: float
    count: Array
    time: Array
    relative: Array
    absolute: Array

    @classmethod
    def of(cls, push: PushMotion) -> MotionField:
        """Return the field of one push."""
        x, y = push.midpoints.reshape(-1, 2).T
        duration = np.repeat(np.diff(push.time), len(push.objects))

        def summed(weight: Array | None = None) -> Array:
            return np.histogram2d(x, y, (X_EDGES, Y_EDGES), weights=weight)[0]

        def displaced(velocity: Array) -> Array:
            steps = velocity.reshape(-1, 2) * duration[:, None]
            return np.stack([summed(steps[:, 0]), summed(steps[:, 1])], axis=-1)

        return cls(
            attempts=1,
            radius=push.radius,
            half_width=push.half_width,
            hand_speed=push.hand_speed,
            count=summed(),
            time=summed(duration),
            relative=displaced(push.relative_velocity),
            absolute=displaced(push.absolute_velocity),
        )

    def __add__(self, other: MotionField) -> MotionField:
        attempts = self.attempts + other.attempts

        def mean(first: float, second: float) -> float:
            return (self.attempts * first + other.attempts * second) / attempts

        return MotionField(
            attempts=attempts,
            radius=mean(self.radius, other.radius),
            half_width=mean(self.half_width, other.half_width),
            hand_speed=mean(self.hand_speed, other.hand_speed),
            count=self.count + other.count,
            time=self.time + other.time,
            relative=self.relative + other.relative,
            absolute=self.absolute + other.absolute,
        )

    def mean_relative(self) -> Array:
        """Return the mean velocities relative to the hand (nx, ny, 2) [m/s]; nan in cells without objects."""
        return _mean_velocity(self.relative, self.time)

    def mean_absolute(self) -> Array:
        """Return the mean velocities in the scene (nx, ny, 2) [m/s]; nan in cells without objects."""
        return _mean_velocity(self.absolute, self.time)

    @cached_property
    def _kernels(self) -> tuple[Array, Array]:
        """Gaussian weights along x and y. Their deviation is an object's radius, because an object has this size."""
        centers = (0.5 * (edges[1:] + edges[:-1]) for edges in (X_EDGES, Y_EDGES))
        x, y = (_gaussian((c[:, None] - c) / self.radius) for c in centers)
        return x, y

    @cached_property
    def smooth_relative(self) -> Array:
        """(nx, ny, 2) kernel-weighted mean velocities relative to the hand [m/s]; nan in cells without objects near."""
        kx, ky = self._kernels
        time = product(product(kx, self.time), ky)
        total = np.stack([product(product(kx, self.relative[..., axis]), ky) for axis in range(2)], axis=-1)
        return _mean_velocity(total, time)


@dataclass(frozen=True, slots=True, eq=False)
class Funnel:
    """Two stream lines of the mean relative motion, followed upstream from the ends of the hand's leading edge.

    Stream lines do not cross, so objects between them flow into the hand, and the others flow past it.

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
        """Follow the lines up to `farthest` [m], or until objects no longer approach or no object was there."""
        y = np.array([-field.half_width, field.half_width])
        points = [(0.0, *y)]
        for x in np.arange(LINE_STEP, farthest + 0.5 * LINE_STEP, LINE_STEP):
            slopes = [_slope(field, points[-1][0], side) for side in y]
            if None in slopes:
                break
            y = y + LINE_STEP * np.array(slopes, dtype=float)
            if y[0] >= y[1]:
                break
            points.append((float(x), *y))
        return cls(*np.array(points).T)

    def width_at(self, distance: float) -> float | None:
        """Return the width at a distance ahead [m], or None beyond the end of the funnel."""
        if distance > self.x[-1] + 1e-9:
            return None
        return float(np.interp(distance, self.x, self.left - self.right))


def _gaussian(deviations: Array) -> Array:
    """Return exp(-x²/2) of each entry (m, n); numpy's own exp rounds differently on processors with AVX-512."""
    return np.array([[math.exp(-0.5 * x * x) for x in row] for row in deviations.tolist()])


def _mean_velocity(displacement: Array, time: Array) -> Array:
    """Return total displacements (nx, ny, 2) over total times (nx, ny) [m/s]; nan below `MIN_TIME`."""
    with np.errstate(invalid="ignore"):
        return np.where((time >= MIN_TIME)[..., None], displacement / time[..., None], np.nan)


def _slope(field: MotionField, x: float, y: float) -> float | None:
    """Return dy/dx of the stream line through a point, or None if nothing flows toward the hand there."""
    u = _interpolated(field.smooth_relative, x, y)
    if not np.isfinite(u).all() or u[0] > -MIN_INFLOW * field.hand_speed:
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
