"""Mean motion on a grid around the hand; fields of several attempts add up."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .push_motion import PushMotion

Array = NDArray[np.float64]

CELL = 0.02
"""Side of a cell [m]: less than the radius of a tennis ball, so that neighbours fall into different cells."""

X_EDGES = np.round(np.arange(-0.16, 0.3601, CELL), 6)
Y_EDGES = np.round(np.arange(-0.23, 0.2301, CELL), 6)
"""Of the grid in the hand's frame [m]; a cell's centre lies on y = 0."""

SEEN = 0.1
"""A cell counts where objects have been in it, or within the kernel's reach, for this long in all [s]."""


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
