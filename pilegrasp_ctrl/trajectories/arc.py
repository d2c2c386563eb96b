"""A circular arc from rest to rest, the tool's orientation kept or turning with it."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, isfinite

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..types import Array, Pose, Reference, frozen_array
from .speed_profile import SpeedProfile

_SMALLEST_RADIUS = 1e-6


@dataclass(frozen=True, slots=True, eq=False, init=False)
class Arc:
    """A circular arc from rest to rest, about an axis that stands still in the world.

    Attributes:
        start: `transform_tool_to_world` at time 0.
        end: and at `duration`.
        center: (3,) the point of the axis around which the tool circles [m].
        axis: (3,) unit vector; the tool goes round it as a right-hand screw turns.
        angle: [rad]; negative goes round the other way.
        turning: whether the tool turns with the arc.
        radius: [m].
        length: of the arc [m].
        duration: [s].
        profile: of the path parameter, which runs from 0 to 1.
    """

    start: Pose
    center: Array
    axis: Array
    angle: float
    turning: bool
    radius: float
    length: float
    profile: SpeedProfile
    end: Pose = field(repr=False)
    _arm: Array = field(repr=False)

    def __init__(
        self,
        start: Pose,
        center: ArrayLike,
        axis: ArrayLike,
        angle: float,
        speed: float,
        *,
        turning: bool = False,
        acceleration: float = 0.5,
        angular_speed: float = 0.5,
        angular_acceleration: float = 2.5,
    ) -> None:
        """Plan the motion.

        Args:
            start: where the tool is, `transform_tool_to_world`.
            center: (3,) any point of the axis [m]; the circle lies in the plane through the tool.
            axis: (3,) direction of the axis, of any length but zero.
            angle: how far to go round, right-handed [rad].
            speed: along the arc [m/s].
            turning: whether the tool turns with the arc; otherwise it keeps its orientation.
            acceleration: peak acceleration along the arc [m/s²]; speed² / radius towards the centre adds to it.
            angular_speed: largest speed of a tool that turns [rad/s]; whichever is slower sets the pace.
            angular_acceleration: peak acceleration of a tool that turns [rad/s²].

        Raises:
            ValueError: where a vector has a wrong shape, a value is not finite, a speed or acceleration is not
                positive, the axis is zero, or the tool lies on the axis.
        """
        center, axis = frozen_array(center, (3,), "center"), frozen_array(axis, (3,), "axis")
        for name, value in (
            ("speed", speed),
            ("acceleration", acceleration),
            ("angular_speed", angular_speed),
            ("angular_acceleration", angular_acceleration),
        ):
            if not 0.0 < value < inf:
                raise ValueError(f"{name} = {value} must be positive and finite")
        if not isfinite(angle):
            raise ValueError(f"angle = {angle} must be finite")
        size = float(np.linalg.norm(axis))
        if size == 0.0:
            raise ValueError("axis must not be zero")
        axis = frozen_array(axis / size, (3,), "axis")
        center = frozen_array(center + axis * (axis @ (start.translation - center)), (3,), "center")
        arm = start.translation - center
        radius = float(np.linalg.norm(arm))
        if radius < _SMALLEST_RADIUS:
            raise ValueError("the tool lies on the axis of the arc; a StraightLine without displacement turns in place")
        turn = abs(angle)
        rate, rise = speed / radius, acceleration / radius
        if turning:
            rate, rise = min(rate, angular_speed), min(rise, angular_acceleration)
        set_ = object.__setattr__
        set_(self, "start", start)
        set_(self, "center", center)
        set_(self, "axis", axis)
        set_(self, "angle", float(angle))
        set_(self, "turning", bool(turning))
        set_(self, "radius", radius)
        set_(self, "length", radius * turn)
        set_(self, "profile", SpeedProfile(1.0, rate / turn, rise / turn) if turn else SpeedProfile(0.0, 1.0, 1.0))
        set_(self, "_arm", arm)
        set_(self, "end", self._pose(pin.exp3(self.angle * axis)))

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]."""
        return self.profile.duration

    def at(self, time: float) -> Reference:
        """Return the reference at `time` [s]; at rest at either end outside the motion."""
        s, rate, rise = self.profile.at(time)
        rotation = pin.exp3(s * self.angle * self.axis)
        arm = rotation @ self._arm
        turn, spin = rate * self.angle * self.axis, rise * self.angle * self.axis
        velocity = np.cross(turn, arm)
        twist = np.concatenate((velocity, turn if self.turning else np.zeros(3)))
        acceleration = np.concatenate(
            (np.cross(spin, arm) + np.cross(turn, velocity), spin if self.turning else np.zeros(3))
        )
        return Reference(self._pose(rotation), twist, acceleration)

    def _pose(self, rotation: Array) -> Pose:
        turned = rotation @ self.start.rotation if self.turning else self.start.rotation
        return Pose(self.center + rotation @ self._arm, turned)
