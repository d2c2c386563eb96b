"""The hand's motion in every primitive: a straight line at a constant speed, turning steadily if asked to."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, sqrt

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..types import Array, Pose, Reference, frozen_array
from .speed_profile import SpeedProfile


@dataclass(frozen=True, slots=True, eq=False, init=False)
class StraightLine:
    """A straight line from rest to rest; the orientation turns about a fixed axis in step with the way.

    Attributes:
        start: `transform_tool_to_world` at time 0.
        end: and at `duration`.
        displacement: (3,) [m].
        rotation: (3,) rotation vector to turn by, world axes [rad].
        length: of the line [m].
        duration: [s].
        profile: of the path parameter, which runs from 0 to 1.
    """

    start: Pose
    displacement: Array
    rotation: Array
    length: float
    profile: SpeedProfile
    end: Pose = field(repr=False)
    _turns: bool = field(repr=False)
    _path: Array = field(repr=False)

    def __init__(
        self,
        start: Pose,
        displacement: ArrayLike,
        speed: float,
        *,
        acceleration: float = 0.5,
        rotation: ArrayLike = (0.0, 0.0, 0.0),
        angular_speed: float = 0.5,
        angular_acceleration: float = 2.5,
    ) -> None:
        """Plan the motion; whichever of translation and rotation takes longer sets the pace of both.

        Args:
            start: where the tool is, `transform_tool_to_world`.
            displacement: (3,) [m]; zero turns in place.
            speed: of the translation [m/s].
            acceleration: peak acceleration of the translation [m/s²].
            rotation: (3,) rotation vector to turn by along the way, world axes [rad].
            angular_speed: largest speed of the rotation [rad/s].
            angular_acceleration: peak acceleration of the rotation [rad/s²].

        Raises:
            ValueError: where a vector has a wrong shape, a value is not finite, or a speed or acceleration is not
                positive.
        """
        displacement = frozen_array(displacement, (3,), "displacement")
        rotation = frozen_array(rotation, (3,), "rotation")
        for name, value in (
            ("speed", speed),
            ("acceleration", acceleration),
            ("angular_speed", angular_speed),
            ("angular_acceleration", angular_acceleration),
        ):
            if not 0.0 < value < inf:
                raise ValueError(f"{name} = {value} must be positive and finite")
        length, angle = sqrt(displacement @ displacement), sqrt(rotation @ rotation)
        moves = length > 0.0 or angle > 0.0
        rate = min(_over(speed, length), _over(angular_speed, angle))
        rise = min(_over(acceleration, length), _over(angular_acceleration, angle))
        set_ = object.__setattr__
        set_(self, "start", start)
        set_(self, "displacement", displacement)
        set_(self, "rotation", rotation)
        set_(self, "length", length)
        set_(self, "profile", SpeedProfile(1.0, rate, rise) if moves else SpeedProfile(0.0, 1.0, 1.0))
        set_(self, "_turns", angle > 0.0)
        set_(self, "_path", np.concatenate((displacement, rotation)))
        set_(self, "end", Pose(start.translation + displacement, self._rotation(1.0)))

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]."""
        return self.profile.duration

    def at(self, time: float) -> Reference:
        """Return the reference at `time` [s]; at rest at either end outside the motion."""
        s, rate, rise = self.profile.at(time)
        pose = Pose.trusted(self.start.translation + s * self.displacement, self._rotation(s))
        return Reference.trusted(pose, rate * self._path, rise * self._path)

    def _rotation(self, s: float) -> Array:
        return pin.exp3(s * self.rotation).dot(self.start.rotation) if self._turns else self.start.rotation


def _over(value: float, size: float) -> float:
    return value / size if size > 0.0 else inf
