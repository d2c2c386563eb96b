"""From where to where the fingertips of an arm and a hand reach on a table, and in which posture they do it best."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ...arm.capsule import Capsule
from ...arm.controllability import spread_postures
from ...arm.frames import frame_id
from ...arm.model import ArmModel
from ...planning.strategy import START_BACK, START_HEIGHT, tool_rotation
from ...types import Array, Pose

STEP = 0.02
"""Distance between the places on the table that are tried [m]; chosen."""

JOINT_MARGIN = 0.15
"""Least distance from a position limit that counts as reached [rad]; chosen: a push under force bends no joint into its
limit."""

STRETCH_MARGIN = 0.06
"""Least singular value of the tool's Jacobian that counts as reached [m, rad]; chosen: below it an arm is stretched."""

LONG_ENOUGH = 0.46
"""Way from touch-down to the end of the push beyond which more does not count [m]; chosen, a pile of 18 spheres needs
0.4."""

WIDE_ENOUGH = 0.4
"""Distance from the limits beyond which more does not count [rad]; chosen."""

MARGIN_WORTH = 0.5
"""Length that is as good as a radian of distance from the limits [m/rad]; chosen."""

ITERATIONS = 80
"""Largest number of iterations to a pose [-]; chosen."""

TOLERANCE = 1e-4
"""Largest distance [m] and angle [rad] from a pose that is reached; chosen."""

DAMPING = 1e-3
"""Damping of the search at a stretched arm [m², rad²]; chosen."""

FURTHEST_TURN = 0.4
"""Largest motion of a joint between two places that are `STEP` apart [rad]; chosen. A larger one is another posture."""


@dataclass(frozen=True, eq=False)
class Reach:
    """The stretch of table that the fingertips reach.

    Attributes:
        near: Least distance from the arm's axis [m].
        far: Greatest distance [m].
        margin: Least distance from a position limit on the way [rad].
        start: (nv,) Posture at the start of an attempt whose touch-down is the nearest one [rad].
        postures: Postures from `near` to `far` [rad].
    """

    near: float
    far: float
    margin: float
    start: Array
    postures: tuple[Array, ...]

    @property
    def length(self) -> float:
        """Distance from the nearest to the farthest place [m]."""
        return self.far - self.near


class ReachSearch:
    """Searches postures of an arm that stands upright with its base below the table's top."""

    def __init__(
        self,
        arm: ArmModel,
        theta: float,
        base_below_table: float,
        capsules: list[Capsule],
        beside_table: tuple[str, ...],
    ) -> None:
        """Take an arm whose controlled frame is the hand's tool frame, and whose base is at its model's origin.

        Args:
            arm: Arm with the hand's tool frame.
            theta: Slope of the hand's fingers [rad].
            base_below_table: Height of the table top above the base [m].
            capsules: Shapes of the arm's links.
            beside_table: Bodies that may be below the table's top.
        """
        self._arm, self._model = arm, arm.pinocchio_model
        self._data, self._frame = self._model.createData(), frame_id(self._model, arm.tool_frame, arm.name)
        self._rotation, self._table = tool_rotation(0.0, theta), base_below_table
        self._lower = np.where(np.isfinite(arm.q_lower), arm.q_lower, -math.pi)
        self._upper = np.where(np.isfinite(arm.q_upper), arm.q_upper, math.pi)
        self._shapes = []
        for capsule in capsules:
            frame = self._model.frames[frame_id(self._model, capsule.frame, arm.name)]
            if _body_of(self._model, frame.parentJoint) not in beside_table and frame.parentJoint > 0:
                ends = [frame.placement.act(point) for point in (capsule.start, capsule.end)]
                self._shapes.append((frame.parentJoint, ends, capsule.radius))

    def best(self, guesses: tuple[Array, ...] = ()) -> Reach | None:
        """Return the reach that is best by length and by distance from the limits; None if no place is reached."""
        found: list[Reach] = []
        seen: list[Array] = []
        middle = 0.65 * self.farthest()
        for guess in (*guesses, *spread_postures(self._lower, self._upper)):
            for distance in (middle, 0.8 * middle):
                q = self._solve(self._place(distance), np.array(guess), 1.0)
                if q is None or any(np.abs(q - other).max() < 0.3 for other in seen):
                    continue
                seen.append(q)
                reach = self._follow(q, distance)
                if reach is not None:
                    found.append(reach)
                break
        return max(found, key=worth, default=None)

    def farthest(self) -> float:
        """Return a bound of the distance of the fingertips from the arm's axis [m]: that of a stretched arm."""
        model = self._model
        chain = list(model.supports[model.frames[self._frame].parentJoint])[2:]
        length = sum(float(np.linalg.norm(model.jointPlacements[joint].translation)) for joint in chain)
        return length + float(np.linalg.norm(model.frames[self._frame].placement.translation))

    def margin(self, q: Array) -> float:
        """Return the distance of a posture from its nearest position limit [rad]."""
        return float(np.minimum(q - self._arm.q_lower, self._arm.q_upper - q).min())

    def _follow(self, q: Array, distance: float) -> Reach | None:
        """Return the reach around a posture at a place on the table."""
        if not self._is_good(q):
            return None
        ways: list[list[Array]] = []
        for step in (-STEP, STEP):
            way: list[Array] = []
            here = q
            while (next_q := self._neighbour(here, distance + step * (len(way) + 1))) is not None:
                way.append(next_q)
                here = next_q
            ways.append(way)
        inward, outward = ways
        # The nearest touch-down is one over which the hand can also begin.
        chain = [*reversed(inward), q, *outward]
        for index, posture in enumerate(chain[: len(inward) + 1]):
            near = distance - STEP * (len(inward) - index)
            start = self._solve(Pose(np.array([near - START_BACK, 0.0, START_HEIGHT]), self._rotation), posture, 0.0)
            if start is not None and self._is_good(start) and np.abs(start - posture).max() < 1.5:
                kept = chain[index:]
                margin = min(map(self.margin, [start, *kept]))
                return Reach(near, distance + STEP * len(outward), margin, start, tuple(kept))
        return None

    def _neighbour(self, q: Array, distance: float) -> Array | None:
        found = self._solve(self._place(distance), q, 0.1)
        return found if found is not None and np.abs(found - q).max() < FURTHEST_TURN and self._is_good(found) else None

    def _is_good(self, q: Array) -> bool:
        J = self._jacobian(q)
        if self.margin(q) < JOINT_MARGIN or float(np.linalg.svd(J, compute_uv=False)[-1]) < STRETCH_MARGIN:
            return False
        return all(
            min(self._data.oMi[joint].act(end)[2] for end in ends) - radius > self._table
            for joint, ends, radius in self._shapes
        )

    def _place(self, distance: float) -> Pose:
        return Pose(np.array([distance, 0.0, 0.0]), self._rotation)

    def _jacobian(self, q: Array) -> Array:
        pin.computeJointJacobians(self._model, self._data, q)
        pin.updateFramePlacements(self._model, self._data)
        J: Array = pin.getFrameJacobian(self._model, self._data, self._frame, pin.ReferenceFrame.LOCAL)
        return J

    def _solve(self, pose: Pose, q: Array, to_middle: float) -> Array | None:
        """Return the posture near `q` for a pose in the table's frame, drawn to the middle of the ranges; or None."""
        target = pin.SE3(np.array(pose.rotation), np.array(pose.translation) + np.array([0.0, 0.0, self._table]))
        middle = 0.5 * (self._lower + self._upper)
        lower, upper = self._lower + 0.5 * JOINT_MARGIN, self._upper - 0.5 * JOINT_MARGIN
        for iteration in range(ITERATIONS):
            J = self._jacobian(q)
            error = pin.log6(self._data.oMf[self._frame].inverse() * target).vector
            if np.abs(error).max() < TOLERANCE:
                return q
            inverse = J.T @ np.linalg.inv(J @ J.T + DAMPING * DAMPING * np.eye(6))
            step = inverse @ error
            if iteration < ITERATIONS // 2:
                step += to_middle * 0.1 * (np.eye(len(q)) - inverse @ J) @ (middle - q)
            q = np.clip(q + step * min(1.0, 0.5 / max(float(np.abs(step).max()), 1e-9)), lower, upper)
        return None


def worth(reach: Reach) -> float:
    """Return how good a reach is, by its length and its distance from the limits [m]."""
    return min(reach.length, LONG_ENOUGH) + MARGIN_WORTH * min(reach.margin, WIDE_ENOUGH)


def _body_of(model: pin.Model, joint: int) -> str:
    links = [frame.name for frame in model.frames if frame.parentJoint == joint and frame.type == pin.FrameType.BODY]
    return links[0] if links else model.names[joint]
