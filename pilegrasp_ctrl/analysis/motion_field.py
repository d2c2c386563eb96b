"""Mean motion on a grid around the hand, and the funnel: the region from which it carries objects into the hand."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..types import Array
from .push_motion import PushMotion

CELL = 0.02
"""Side of a cell [m]: less than the radius of a tennis ball, so that neighbours fall into different cells."""

X_EDGES = np.round(np.arange(-0.16, 0.3601, CELL), 6)
Y_EDGES = np.round(np.arange(-0.23, 0.2301, CELL), 6)
"""Of the grid in the hand's frame [m]; a cell's centre lies on y = 0."""

SEEN = 0.1
"""A cell counts where objects have been in it, or within the kernel's reach, for this long in all [s]."""


STEP = 0.005
"""From one point of a stream line to the next [m]."""

INFLOW = 0.05
"""Where objects come nearer by less than this share of the hand's speed, they are carried along: no way into it."""


@dataclass(frozen=True, eq=False)
class MotionField:
    """Sums over the cells of the grid `X_EDGES` x `Y_EDGES`.

    Attributes:
        attempts: how many went in.
        radius: of the objects [m]; the mean over the attempts.
        half_width: half the width of the hand's leading edge [m]; the mean.
        hand_speed: that of a push, in the mean over attempts [m/s].
        count: (nx, ny) frames in which an object's centre was in the cell.
        time: (nx, ny) how long it was there [s].
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
        """Return the mean velocities relative to the hand (nx, ny, 2) [m/s]; nan where no object came."""
        return self._mean(self.relative)

    def mean_absolute(self) -> Array:
        """Return the mean velocities in the scene (nx, ny, 2) [m/s]; nan where no object came."""
        return self._mean(self.absolute)

    def _mean(self, total: Array) -> Array:
        with np.errstate(invalid="ignore"):
            return np.where((self.time >= SEEN)[..., None], total / self.time[..., None], np.nan)

    @cached_property
    def _kernels(self) -> tuple[Array, Array]:
        """Gaussians whose deviation is an object's radius: an object is not at a point, but that large."""
        centers = (0.5 * (edges[1:] + edges[:-1]) for edges in (X_EDGES, Y_EDGES))
        x, y = (np.exp(-0.5 * ((c[:, None] - c) / self.radius) ** 2) for c in centers)
        return x, y

    @cached_property
    def smooth_relative(self) -> Array:
        """(nx, ny, 2) kernel-weighted mean velocities relative to the hand [m/s]; nan where nothing is near."""
        kx, ky = self._kernels
        time = kx @ self.time @ ky
        total = np.stack([kx @ self.relative[..., axis] @ ky for axis in range(2)], axis=-1)
        with np.errstate(invalid="ignore"):
            return np.where((time >= SEEN)[..., None], total / time[..., None], np.nan)


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
