"""A circular arc from rest to rest; the tool keeps its orientation or turns with the arc."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, isfinite, sin

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..exceptions import ArgumentError
from ..kernels.algebra import product
from ..types import Array, Pose, Reference, frozen_array
from ..vectors import inner, norm
from .speed_profile import (
    MAX_ACCELERATION,
    MAX_ANGULAR_ACCELERATION,
    MAX_ANGULAR_SPEED,
    RESTING,
    SpeedProfile,
    require_positive,
)

MIN_RADIUS = 1e-6
"""Smallest radius of an arc [m]; chosen. A tool nearer to the axis counts as on it."""


@dataclass(frozen=True, slots=True, eq=False, init=False)
class Arc:
    """A circular arc from rest to rest, about an axis that is fixed in the world.

    Attributes:
        start: Start pose, `transform_tool_to_world`.
        end: End pose, `transform_tool_to_world`.
        center: (3,) Point of the axis that the tool circles [m].
        axis: (3,) Unit vector; a positive angle is right-handed about it.
        angle: Angle of the arc [rad]; negative is left-handed.
        turning: Whether the tool turns with the arc.
        radius: Radius of the arc [m].
        length: Length of the arc [m].
        duration: Time from rest to rest [s].
        profile: Speed profile of the path parameter, which runs from 0 to 1.
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
    _offset: Array = field(repr=False)
    _across: Array = field(repr=False)

    def __init__(
        self,
        start: Pose,
        center: ArrayLike,
        axis: ArrayLike,
        angle: float,
        speed: float,
        *,
        turning: bool = False,
        acceleration: float = MAX_ACCELERATION,
        angular_speed: float = MAX_ANGULAR_SPEED,
        angular_acceleration: float = MAX_ANGULAR_ACCELERATION,
    ) -> None:
        """Plan the motion.

        Args:
            start: Start pose, `transform_tool_to_world`.
            center: (3,) Point anywhere on the axis [m]; the circle lies in the plane through the tool.
            axis: (3,) Direction of the axis, of any length except zero.
            angle: Angle of the arc, right-handed about the axis [rad].
            speed: Speed along the arc [m/s].
            turning: Whether the tool turns with the arc; otherwise it keeps its orientation.
            acceleration: Peak acceleration along the arc [m/s²]. The centripetal acceleration speed² / radius adds
                to it.
            angular_speed: Largest angular speed of a tool that turns [rad/s]; the slower of the two speeds counts.
            angular_acceleration: Peak angular acceleration of a tool that turns [rad/s²].

        Raises:
            ArgumentError: A vector or number is not usable, the axis is zero, or the tool lies on the axis.
        """
        center, axis = frozen_array(center, (3,), "center"), frozen_array(axis, (3,), "axis")
        require_positive(
            speed=speed,
            acceleration=acceleration,
            angular_speed=angular_speed,
            angular_acceleration=angular_acceleration,
        )
        if not isfinite(angle):
            raise ArgumentError(f"angle = {angle} must be finite")
        size = norm(axis)
        if size == 0.0:
            raise ArgumentError("the axis of the arc is zero; give a direction, such as (0, 0, 1)")
        axis = frozen_array(axis / size, (3,), "axis")
        center = frozen_array(center + inner(axis, start.translation - center) * axis, (3,), "center")
        offset = start.translation - center
        radius = norm(offset)
        if radius < MIN_RADIUS:
            raise ArgumentError(
                "the tool lies on the axis of the arc; use a StraightLine without displacement to turn in place"
            )
        turn = abs(angle)
        path_speed, path_acceleration = speed / radius, acceleration / radius
        if turning:
            path_speed, path_acceleration = min(path_speed, angular_speed), min(path_acceleration, angular_acceleration)
        set_ = object.__setattr__
        set_(self, "start", start)
        set_(self, "center", center)
        set_(self, "axis", axis)
        set_(self, "angle", float(angle))
        set_(self, "turning", bool(turning))
        set_(self, "radius", radius)
        set_(self, "length", radius * turn)
        set_(self, "profile", SpeedProfile(1.0, path_speed / turn, path_acceleration / turn) if turn else RESTING)
        set_(self, "_offset", offset)
        set_(self, "_across", np.cross(axis, offset))
        set_(self, "end", self._pose(self.angle, self._at_angle(self.angle)))

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]."""
        return self.profile.duration

    def at(self, time: float) -> Reference:
        """Return the reference at `time` [s]; at rest before the start and after the end."""
        s, path_speed, path_acceleration = self.profile.at(time)
        speed, acceleration, angle = path_speed * self.angle, path_acceleration * self.angle, s * self.angle
        offset = self._at_angle(angle)
        forward = cos(angle) * self._across - sin(angle) * self._offset
        twist, change = np.zeros(6), np.zeros(6)
        twist[:3] = speed * forward
        change[:3] = acceleration * forward - speed * speed * offset
        if self.turning:
            twist[3:], change[3:] = speed * self.axis, acceleration * self.axis
        return Reference.trusted(self._pose(angle, offset), twist, change)

    def _at_angle(self, angle: float) -> Array:
        """Return the vector (3,) from the centre to the tool at an angle [rad]; its derivative is `forward`."""
        return cos(angle) * self._offset + sin(angle) * self._across

    def _pose(self, angle: float, offset: Array) -> Pose:
        rotation = self.start.rotation
        if self.turning:
            rotation = np.empty((3, 3))
            product(pin.exp3(angle * self.axis), self.start.rotation, rotation)
        return Pose.trusted(self.center + offset, rotation)
