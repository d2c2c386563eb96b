"""Capsules on an arm and obstacles around it, in Pinocchio's geometry."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, sqrt
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from ..arm.capsule import Capsule
from ..arm.frames import frame_id, se3
from ..kernels.collision import capsule_motion, distance_rows, least_distances
from ..types import Array
from .obstacles import Obstacle, Plane

GUARD_SPACING = 0.05
"""Largest distance of neighbouring guard balls along a capsule [m]; chosen.

The closest point of a capsule that turns along a surface jumps to another place. The guard balls have the capsule's
radius and are always watched. No point that a jump reaches is therefore farther than this from a watched one."""

_DEEP = 100.0
"""Half the depth of the box that stands for a plane where far pairs are sorted out [m]; chosen, beyond any arm."""


class Pair(NamedTuple):
    """A capsule, and a capsule or obstacle that it must not touch.

    Attributes:
        first: Index of the capsule.
        second: Index of the other capsule; the indices of obstacles follow those of capsules.
        name: Name in `active_limits`, such as "collision[link7 | box]".
    """

    first: int
    second: int
    name: str


class Geometry:
    """The shapes of a list of pairs at one posture, with Pinocchio's buffers; it serves one thread.

    A distance has an index. Those of the pairs come first, then those of their guard balls.

    Attributes:
        guards: Indices of the distances of the guard balls of each pair.
    """

    def __init__(
        self, model: pin.Model, capsules: Sequence[Capsule], obstacles: Sequence[Obstacle], pairs: Sequence[Pair]
    ) -> None:
        """Build the shapes; every frame of a capsule must be one of the model."""
        self._model, self._data = model, model.createData()
        self._pairs, self._capsules, self._obstacles = pairs, capsules, obstacles
        frames = [model.frames[frame_id(model, capsule.frame, model.name)] for capsule in capsules]
        self._carriers = [frame.parentJoint for frame in frames]
        self._places = [frame.placement for frame in frames]
        supports = np.zeros((len(capsules) + len(obstacles), model.nv))
        for index, joint in enumerate(self._carriers):
            supports[index, [model.joints[j].idx_v for j in model.supports[joint] if j > 0]] = 1.0
        self._supports = supports[: len(capsules)]
        count = len(capsules)
        self._firsts, self._seconds = [pair.first for pair in pairs], [min(pair.second, count) for pair in pairs]
        self._indices = np.array([(pair.first, pair.second) for pair in pairs], dtype=np.float64).reshape(-1, 2).T
        self._joints = sorted(set(self._carriers))
        self._rows = np.array([4.0 * self._joints.index(joint) for joint in self._carriers])
        self._poses, self._middles = np.zeros((4 * len(self._joints), 4)), np.zeros((count, 3))
        self._starts, self._ends = (
            np.array([place.act(np.array(point)) for place, point in zip(self._places, points, strict=True)])
            for points in ([capsule.start for capsule in capsules], [capsule.end for capsule in capsules])
        )
        self._reaches = np.array([0.5 * _length(capsule) + capsule.radius for capsule in capsules])
        self._boxes = np.array([_box_numbers(obstacle) for obstacle in obstacles]).reshape(-1, 15)
        self._speeds = np.zeros(count + 1)
        self._shapes, self._balls = self._whole_shapes(), self._whole_shapes()
        for pair in pairs:
            self._shapes.addCollisionPair(pin.CollisionPair(pair.first, pair.second))
        self.guards, of_pair = self._add_guards()
        self._moves = np.array([supports[pairs[index].first] - supports[pairs[index].second] for index in of_pair])
        self._placed, self._placed_balls = self._shapes.createData(), self._balls.createData()
        self._results = [*self._placed.distanceResults, *self._placed_balls.distanceResults]

    def _whole_shapes(self) -> pin.GeometryModel:
        """Return the capsules, then the obstacles."""
        shapes = pin.GeometryModel()
        for capsule, joint, place in zip(self._capsules, self._carriers, self._places, strict=True):
            _add(shapes, joint, place * _placement(capsule), _solid(capsule))
        for obstacle in self._obstacles:
            placement = pin.SE3.Identity() if isinstance(obstacle, Plane) else se3(obstacle.pose)
            _add(shapes, 0, placement, _solid(obstacle))
        return shapes

    def _add_guards(self) -> tuple[list[list[int]], list[int]]:
        """Add the guard balls; return the distances of each pair, and the pair of each distance."""
        balls = []
        for capsule, joint, place in zip(self._capsules, self._carriers, self._places, strict=True):
            gaps = ceil(_length(capsule) / GUARD_SPACING)
            shares = [gap / gaps for gap in range(gaps + 1)] if gaps else [0.0]
            centers = [(1.0 - share) * capsule.start + share * capsule.end for share in shares]
            solid = pin.coal.Sphere(capsule.radius)
            balls.append([_add(self._balls, joint, place * pin.SE3(np.eye(3), center), solid) for center in centers])
        guards: list[list[int]] = []
        of_pair = list(range(len(self._pairs)))
        for index, (first, second, _) in enumerate(self._pairs):
            mine, theirs = balls[first], balls[second] if second < len(balls) else []
            if second >= len(balls) and isinstance(self._obstacles[second - len(balls)], Plane):
                mine = [mine[0], mine[-1]][: len(mine)]  # an end is always the closest to a plane
            watched = [(ball, second) for ball in mine] + [(first, ball) for ball in theirs]
            guards.append(list(range(len(of_pair), len(of_pair) + len(watched))))
            of_pair += [index] * len(watched)
            for one, other in watched:
                self._balls.addCollisionPair(pin.CollisionPair(one, other))
        return guards, of_pair

    def place(self, q: Array) -> None:
        """Place all shapes at a posture."""
        self._J = pin.computeJointJacobians(self._model, self._data, q).reshape(6, self._model.nv)
        pin.updateGeometryPlacements(self._model, self._data, self._shapes, self._placed)
        pin.updateGeometryPlacements(self._model, self._data, self._balls, self._placed_balls)

    def distances(self) -> Array:
        """Return the distances of the pairs (pairs,), negative for shapes that overlap [m]."""
        pin.computeDistances(self._shapes, self._placed)
        return np.array([result.min_distance for result in self._results[: len(self._pairs)]])

    def distance(self, index: int) -> float:
        """Return one distance [m]."""
        pairs = len(self._pairs)
        if index < pairs:
            pin.computeDistance(self._shapes, self._placed, index)
        else:
            pin.computeDistance(self._balls, self._placed_balls, index - pairs)
        found: float = self._results[index].min_distance
        return found

    def closing(self, v: Array) -> tuple[Array, Array]:
        """Return how fast the surfaces of each pair (pairs,) approach at most [m/s], and their least distance [m].

        Both follow from balls around the capsules, and cost less than the distances. The distance of shapes that
        overlap counts as zero.
        """
        for row, joint in enumerate(self._joints):
            self._poses[4 * row : 4 * row + 4] = self._data.oMi[joint].homogeneous
        capsule_motion(
            *(self._J, self._supports, self._poses, self._rows, self._starts, self._ends, v),
            *(self._speeds[:-1], self._middles),
        )
        least = np.empty(len(self._pairs))
        least_distances(self._middles, self._reaches, self._boxes, self._indices[0], self._indices[1], least)
        return self._speeds[self._firsts] + self._speeds[self._seconds], least

    def rows(self, indices: Sequence[int], v: Array, rate: Array) -> Array:
        """Return the rows (m, nv) of the rates of distances that were computed last; fill the rates (m,) [m/s].

        Args:
            indices: Indices of the distances.
            v: (nv,) Joint velocities [rad/s].
            rate: (m,) Array to fill.
        """
        G = np.empty((len(indices), len(v)))
        if indices:
            results = [self._results[index] for index in indices]
            points = np.array([result.getNearestPoint1() for result in results])
            normals = -np.array([result.normal for result in results])
            distance_rows(self._J, self._moves[indices], points, normals, v, G, rate)
        return G


def _add(shapes: pin.GeometryModel, joint: int, placement: pin.SE3, solid: Any) -> int:
    index: int = shapes.addGeometryObject(pin.GeometryObject(str(shapes.ngeoms), joint, placement, solid))
    return index


def _solid(shape: Capsule | Obstacle) -> Any:
    if isinstance(shape, Capsule):
        length = _length(shape)
        return pin.coal.Capsule(shape.radius, length) if length > 0.0 else pin.coal.Sphere(shape.radius)
    if isinstance(shape, Plane):
        return pin.coal.Halfspace(np.array(shape.normal), shape.offset)
    return pin.coal.Box(*shape.size.tolist())


def _box_numbers(obstacle: Obstacle) -> list[float]:
    """Return middle, rotation and half the edges of a box, as `least_distances` takes them; a plane is a large box."""
    if isinstance(obstacle, Plane):
        middle = (obstacle.offset - _DEEP) * obstacle.normal
        return [*middle.tolist(), *_turned_to(obstacle.normal).ravel().tolist(), np.inf, np.inf, _DEEP]
    pose = obstacle.pose
    return [*pose.translation.tolist(), *pose.rotation.ravel().tolist(), *(0.5 * obstacle.size).tolist()]


def _length(capsule: Capsule) -> float:
    x, y, z = (capsule.end - capsule.start).tolist()
    return sqrt(x * x + y * y + z * z)


def _placement(capsule: Capsule) -> pin.SE3:
    """Return the pose of a capsule's middle in its frame; its axis is z."""
    length = _length(capsule)
    middle = 0.5 * (capsule.start + capsule.end)
    if length == 0.0:
        return pin.SE3(np.eye(3), middle)
    axis = (capsule.end - capsule.start) / length
    return pin.SE3(_turned_to(axis), middle)


def _turned_to(axis: Array) -> Array:
    """Return a rotation (3, 3) whose third column is the unit vector `axis`."""
    x, y, z = axis.tolist()
    # The side across the smallest component is safe to normalise.
    side = np.zeros(3)
    side[min(range(3), key=lambda i: abs((x, y, z)[i]))] = 1.0
    first = np.cross(side, axis)
    a, b, c = first.tolist()
    first /= sqrt(a * a + b * b + c * c)
    return np.column_stack((first, np.cross(axis, first), axis))
