"""Limit that keeps the arm off obstacles and off itself."""

from __future__ import annotations

from collections.abc import Iterable
from threading import local
from typing import Any

import numpy as np

from ..arm.capsule import Capsule
from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError
from ..kernels.collision import approach_bounds, spare_speeds, stopping_distances
from ..types import Array
from .collision_geometry import Geometry, Pair
from .collision_pairs import apart, carrier, named
from .limit import Bounds
from .motion_limits import HORIZON_PERIODS
from .obstacles import Box, Obstacle, Plane

MARGIN = 0.01
"""Distance kept between surfaces [m]; chosen."""
DECELERATION = 2.0
"""Deceleration with which an approach can still stop before the margin [m/s²]; chosen, see `CollisionLimit`."""
GAIN = 20.0
"""Largest speed of approach over distance, close to the margin [1/s]; chosen, as 1 / 0.05 s."""
RETREAT = 0.1
"""Speed at which shapes separate that begin within the margin [m/s]; chosen."""
_DEMAND = 1.25
"""Largest demand of a row over the deceleration; chosen.

At the border of the states from which the arm can stop, a row demands at most the deceleration, and beyond slightly
more."""
_SUDDEN = 100.0
"""Acceleration of a surface that no controller asks for [m/s²]; chosen. A pair that it could not bring to its bound
within the horizon has no row in this period."""
_SAME = 1e-6
"""Difference of distances below which a guard ball is the closest point [m]; chosen."""
_FIXED = 1e-6
"""Largest entry of a row that the joints cannot change, such as that of the base and the floor [m]; chosen."""


class CollisionLimit:
    """Keeps a margin between the capsules of an arm and obstacles, and among the capsules.

    With the distance d of two surfaces beyond the margin, and its rate, the approach stays slow enough to stop:

        -rate <= phi(d),    phi = gain d near the margin, sqrt(2 deceleration d - ...) farther away

    at the end of a horizon of two control periods, for distances and normals at the posture that the arm reaches by
    then at its present speed. So the motion of normals and closest points counts. `kernels/collision.py` has the
    formulas. Shapes that begin within the margin, or overlap, separate slowly.

    Each pair has a row for its closest points. Guard balls along a capsule have rows too, because the closest point of
    a capsule that turns along a surface jumps. Pairs that are too far to matter in this period have none.

    Attributes:
        capsules: Capsules of the arm.
        obstacles: Obstacles.
        pairs: Names of the pairs that are watched.
        rate: Control rate [Hz].
        margin: Distance kept between surfaces [m].
        deceleration: Deceleration of an approach [m/s²].
        hard: Whether the limit holds even where the torques leave no room; by default it is soft.
    """

    def __init__(
        self,
        arm: ArmModel,
        capsules: Iterable[Capsule],
        obstacles: Iterable[Obstacle] = (),
        rate: float = 500.0,
        *,
        margin: float = MARGIN,
        self_collision: bool | Iterable[tuple[str, str]] = True,
        deceleration: float = DECELERATION,
        gain: float = GAIN,
        retreat: float = RETREAT,
        hard: bool = False,
    ) -> None:
        """Set the limit.

        Args:
            arm: Arm that carries the capsules.
            capsules: Capsules, such as `capsules_of("wam7")`.
            obstacles: Planes and boxes.
            rate: Control rate [Hz].
            margin: Distance kept between surfaces [m].
            self_collision: Whether to keep the capsules off one another, or pairs of frames whose capsules to keep off
                one another. True leaves out links that a joint joins, and pairs that most postures bring within the
                margin.
            deceleration: Deceleration that the arm can hold against an approach [m/s²]. A larger one allows a faster
                approach, but torques that cannot hold it let the arm enter the margin.
            gain: Largest speed of approach over distance, close to the margin [1/s].
            retreat: Speed at which shapes separate that begin within the margin [m/s].
            hard: Whether the limit holds even where the torque limits leave no room. The controller then falls back
                where both contradict each other.

        Raises:
            ConfigurationError: A shape has a wrong type, a number is out of range, or there is nothing to watch.
            ModelError: The arm has no such frame.
        """
        self.capsules, self.obstacles = _all(capsules, (Capsule,)), _all(obstacles, (Plane, Box))
        for capsule in self.capsules:
            arm.check_frame(capsule.frame)
        self.rate, self.margin = _number(rate, "rate", "Hz"), _number(margin, "margin", "m", zero=True)
        self.deceleration = _number(deceleration, "deceleration", "m/s²")
        self.gain, self.retreat = _number(gain, "gain", "1/s"), _number(retreat, "retreat", "m/s")
        self.hard = bool(hard)
        self._horizon = HORIZON_PERIODS / self.rate
        self._reserve = _SUDDEN * self._horizon
        if self.gain * self._horizon > 1.0:
            raise ConfigurationError(
                f"gain = {self.gain:g} 1/s is too large for {self.rate:g} Hz; it can be at most {0.5 * self.rate:g} 1/s"
            )
        self._model = arm.pinocchio_model
        self._pairs = tuple(self._pairs_to_watch(arm, self_collision))
        if not self._pairs:
            raise ConfigurationError(
                "the collision limit has nothing to watch: give capsules that move, and obstacles or self_collision"
            )
        self.pairs = tuple(dict.fromkeys(pair.name for pair in self._pairs))
        self._buffers = _Buffers()
        of_guards = (pair for pair, guards in enumerate(self._geometry().guards) for _ in guards)
        self._names = tuple(self._pairs[pair].name for pair in (*range(len(self._pairs)), *of_guards))

    def __repr__(self) -> str:
        return f"CollisionLimit({len(self.capsules)} capsules, {len(self.obstacles)} obstacles, margin={self.margin:g})"

    def rows(self, state: ArmState) -> Bounds:
        """Return the rows of the pairs that may matter in this period, with lower bounds [m/s²].

        Raises:
            ConfigurationError: The state has another number of joints than the limit's arm.
        """
        geometry, v = self._geometry(), state.v
        if len(v) != self._model.nv:
            raise ConfigurationError(
                f"{self!r} is for {self._model.nv} joints, not for {len(v)}; make it with this arm"
            )
        geometry.place(state.q + self._horizon * v)
        indices, distances = self._near(geometry, v)
        if not indices:
            return Bounds(np.empty((0, len(v))), np.empty(0), np.empty(0), ())
        distance, (rate, spare) = np.array(distances) - self.margin, np.empty((2, len(indices)))
        geometry.rows(indices, v, rate)
        spare_speeds(distance, rate, self.deceleration, self.gain, self.retreat, spare)
        kept = np.flatnonzero(spare < self._reserve)
        indices = [indices[row] for row in kept.tolist()]
        rate_now, lower = np.empty((2, len(kept)))
        # The rows are those of the present posture, so that they are combinations of the rows of the tasks.
        geometry.place(state.q)
        for index in indices:
            geometry.distance(index)
        G = geometry.rows(indices, v, rate_now)
        numbers = self.deceleration, self.gain, self.retreat, _DEMAND * self.deceleration, self._horizon
        approach_bounds(distance[kept], rate[kept], rate_now, *numbers, lower)
        movable = np.abs(G).max(axis=1, initial=0.0) > _FIXED
        names = tuple(self._names[index] for index, moves in zip(indices, movable.tolist(), strict=True) if moves)
        return Bounds(G[movable], lower[movable], np.full(len(names), np.inf), names)

    def _near(self, geometry: Geometry, v: Array) -> tuple[list[int], list[float]]:
        """Return indices and values of the distances that may matter at the posture of the geometry."""
        speeds, lower = geometry.closing(v)
        near = np.empty(len(speeds))
        stopping_distances(speeds + self._reserve, self.deceleration, self.gain, near)
        near += self.margin
        indices, distances = [], []
        for pair in np.flatnonzero(lower < near).tolist():
            closest, least, most = geometry.distance(pair), np.inf, near.item(pair)
            if closest >= most:
                continue
            for guard in geometry.guards[pair]:
                distance = geometry.distance(guard)
                least = min(least, distance)
                if distance < most:
                    indices.append(guard)
                    distances.append(distance)
            if closest < least - _SAME:
                indices.append(pair)
                distances.append(closest)
        return indices, distances

    def distances(self, state: ArmState) -> dict[str, float]:
        """Return the distance of each pair at a state, by its name; negative for shapes that overlap [m]."""
        geometry = self._geometry()
        geometry.place(state.q)
        found: dict[str, float] = {}
        for pair, distance in zip(self._pairs, geometry.distances().tolist(), strict=True):
            found[pair.name] = min(found.get(pair.name, np.inf), distance)
        return found

    def _geometry(self) -> Geometry:
        if self._buffers.geometry is None:
            self._buffers.geometry = Geometry(self._model, self.capsules, self.obstacles, self._pairs)
        return self._buffers.geometry

    def _pairs_to_watch(self, arm: ArmModel, self_collision: bool | Iterable[tuple[str, str]]) -> list[Pair]:
        pairs = [
            Pair(first, len(self.capsules) + other, f"collision[{capsule.frame} | {obstacle.name}]")
            for first, capsule in enumerate(self.capsules)
            if carrier(self._model, capsule.frame) > 0
            for other, obstacle in enumerate(self.obstacles)
        ]
        if self_collision is True:
            return pairs + apart(arm, self.capsules, self.margin)
        return pairs + (named(self.capsules, self_collision) if self_collision else [])


class _Buffers(local):
    """The geometry of the present thread; a copy or a pickle starts without one."""

    geometry: Geometry | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return _Buffers, ()


def _all(values: Any, kinds: tuple[type, ...]) -> tuple[Any, ...]:
    """Return the values as a tuple.

    Raises:
        ConfigurationError: One has another type.
    """
    wanted = " or ".join(kind.__name__ for kind in kinds)
    if isinstance(values, kinds) or not isinstance(values, Iterable):
        raise ConfigurationError(f"a collision limit takes a list of {wanted}, not one {type(values).__name__}")
    found = tuple(values)
    for value in found:
        if not isinstance(value, kinds):
            raise ConfigurationError(f"a collision limit takes a list of {wanted}, not of {type(value).__name__}")
    return found


def _number(value: Any, name: str, unit: str, zero: bool = False) -> float:
    good = isinstance(value, int | float | np.integer | np.floating) and 0.0 <= value < np.inf
    if not good or (value == 0.0 and not zero):
        raise ConfigurationError(f"{name} = {value!r:.80} must be a {'finite' if zero else 'positive'} number [{unit}]")
    return float(value)
