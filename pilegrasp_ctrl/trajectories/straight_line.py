"""Straight motions of the tool: one line, lines in sequence, and a jump."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..kernels.algebra import product
from ..types import Array, Pose, Reference, frozen_array
from ..vectors import in_order, norm
from .speed_profile import (
    MAX_ACCELERATION,
    MAX_ANGULAR_ACCELERATION,
    MAX_ANGULAR_SPEED,
    RESTING,
    SpeedProfile,
    require_positive,
)


@dataclass(frozen=True, slots=True, eq=False, init=False)
class StraightLine:
    """A straight line from rest to rest. The tool turns about a fixed axis in proportion to the distance travelled.

    Attributes:
        start: Start pose, `transform_tool_to_world`.
        end: End pose, `transform_tool_to_world`.
        displacement: (3,) Displacement of the tool [m].
        rotation: (3,) Rotation vector of the tool, in world axes [rad].
        length: Length of the line [m].
        duration: Time from rest to rest [s].
        profile: Speed profile of the path parameter, which runs from 0 to 1.
    """

    start: Pose
    displacement: Array
    rotation: Array
    length: float
    profile: SpeedProfile
    end: Pose = field(repr=False)
    _turns: bool = field(repr=False)
    _path: Array = field(repr=False)
    _cruise: tuple[Array, Array] = field(repr=False)
    _before: Reference = field(repr=False)
    _after: Reference = field(repr=False)

    def __init__(
        self,
        start: Pose,
        displacement: ArrayLike,
        speed: float,
        *,
        acceleration: float = MAX_ACCELERATION,
        rotation: ArrayLike = (0.0, 0.0, 0.0),
        angular_speed: float = MAX_ANGULAR_SPEED,
        angular_acceleration: float = MAX_ANGULAR_ACCELERATION,
    ) -> None:
        """Plan the motion. The slower of translation and rotation sets the duration of both.

        Args:
            start: Start pose, `transform_tool_to_world`.
            displacement: (3,) Displacement of the tool [m]; zero to turn in place.
            speed: Speed of the translation [m/s].
            acceleration: Peak acceleration of the translation [m/s²].
            rotation: (3,) Rotation vector of the tool, in world axes [rad].
            angular_speed: Largest speed of the rotation [rad/s].
            angular_acceleration: Peak acceleration of the rotation [rad/s²].

        Raises:
            ArgumentError: A vector has a wrong shape, a value is not finite, or a speed or acceleration is not
                positive.
        """
        displacement = frozen_array(displacement, (3,), "displacement")
        rotation = frozen_array(rotation, (3,), "rotation")
        require_positive(
            speed=speed,
            acceleration=acceleration,
            angular_speed=angular_speed,
            angular_acceleration=angular_acceleration,
        )
        length, angle = norm(displacement), norm(rotation)
        moves = length > 0.0 or angle > 0.0
        path_speed = min(_ratio(speed, length), _ratio(angular_speed, angle))
        path_acceleration = min(_ratio(acceleration, length), _ratio(angular_acceleration, angle))
        set_ = object.__setattr__
        set_(self, "start", start)
        set_(self, "displacement", displacement)
        set_(self, "rotation", rotation)
        set_(self, "length", length)
        set_(self, "profile", SpeedProfile(1.0, path_speed, path_acceleration) if moves else RESTING)
        set_(self, "_turns", angle > 0.0)
        set_(self, "_path", np.concatenate((displacement, rotation)))
        set_(self, "end", Pose(start.translation + displacement, self._rotation(1.0)))
        # What is the same in many periods is made once.
        set_(self, "_cruise", self._motion(self.profile.peak_speed, 0.0))
        set_(self, "_before", Reference.trusted(self._pose(0.0), *self._motion(0.0, 0.0)))
        set_(self, "_after", Reference.trusted(self._pose(self.profile.length), *self._motion(0.0, 0.0)))

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]."""
        return self.profile.duration

    def at(self, time: float) -> Reference:
        """Return the reference at `time` [s]; at rest before the start and after the end."""
        if time <= 0.0:
            return self._before
        if self.profile.duration - time <= 0.0:
            return self._after
        s, speed, acceleration = self.profile.at(time)
        if acceleration == 0.0 and speed == self.profile.peak_speed:
            return Reference.trusted(self._pose(s), *self._cruise)
        return Reference.trusted(self._pose(s), speed * self._path, acceleration * self._path)

    def _pose(self, s: float) -> Pose:
        return Pose.trusted(self.start.translation + s * self.displacement, self._rotation(s))

    def _motion(self, speed: float, acceleration: float) -> tuple[Array, Array]:
        """Return read-only twist (6,) and acceleration (6,)."""
        twist, change = speed * self._path, acceleration * self._path
        for array in (twist, change):
            array.setflags(write=False)
        return twist, change

    def _rotation(self, s: float) -> Array:
        return _turned(self.start.rotation, s * self.rotation) if self._turns else self.start.rotation


@dataclass(frozen=True, slots=True)
class LineChain:
    """Straight lines in sequence, at rest in between.

    Attributes:
        lines: Lines, at least one; each starts at the end of the one before.
        duration: Time from rest to rest [s].
    """

    lines: tuple[StraightLine, ...]
    duration: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "duration", in_order(line.duration for line in self.lines))

    @property
    def end(self) -> Pose:
        """End pose, `transform_tool_to_world`."""
        return self.lines[-1].end

    def at(self, time: float) -> Reference:
        """Return the reference at `time` [s]; at rest before the start and after the end."""
        for line in self.lines[:-1]:
            if time < line.duration:
                return line.at(time)
            time -= line.duration
        return self.lines[-1].at(time)


@dataclass(frozen=True, slots=True, eq=False, init=False)
class Step:
    """A jump at time 0 from one resting pose to another, for step responses. Twist and acceleration are zero.

    Attributes:
        start: Pose before time 0, `transform_tool_to_world`.
        end: Pose from time 0 on, `transform_tool_to_world`.
        displacement: (3,) Displacement of the tool [m].
        rotation: (3,) Rotation vector of the tool, in world axes [rad].
        duration: Zero, because a jump takes no time [s].
    """

    start: Pose
    displacement: Array
    rotation: Array
    end: Pose = field(repr=False)

    def __init__(self, start: Pose, displacement: ArrayLike, rotation: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """Compute the end pose.

        Raises:
            ArgumentError: A vector has a wrong shape or a value is not finite.
        """
        set_ = object.__setattr__
        set_(self, "start", start)
        set_(self, "displacement", frozen_array(displacement, (3,), "displacement"))
        set_(self, "rotation", frozen_array(rotation, (3,), "rotation"))
        set_(self, "end", Pose(start.translation + self.displacement, _turned(start.rotation, self.rotation)))

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]."""
        return 0.0

    def at(self, time: float) -> Reference:
        """Return the reference at `time` [s]."""
        return Reference(self.start if time < 0.0 else self.end)


def _turned(rotation: Array, vector: Array) -> Array:
    """Return a rotation (3, 3) after a turn by the rotation vector (3,)."""
    turned = np.empty((3, 3))
    product(pin.exp3(np.array(vector)), rotation, turned)
    return turned


def _ratio(value: float, size: float) -> float:
    return value / size if size > 0.0 else inf
