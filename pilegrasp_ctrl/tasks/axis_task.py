"""The task of an axis of a frame that points in a direction; the turn about the axis stays free."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arm.fitting import check_arm
from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ArgumentError, ConfigurationError, GainsError
from ..kernels import frame as kernels
from ..types import Array
from .frame_task import MAX_ANGULAR_SPEED
from .gains import MotionGains
from .linear_task import positive_number
from .pose_task import FRICTION_APPROACH
from .sampled_motion import check_motion_gains
from .task import Objective


class AxisTask:
    """Aligns an axis that is fixed in a frame with a direction of the world.

    With the axis n in world axes, the rows are P (J a + Jdot_v - wanted) of the frame's angular acceleration, with
    P = 1 - n nᵀ. The wanted acceleration is `stiffness e - damping omega`; e is the shortest rotation vector that turns
    the axis into the direction.

    Attributes:
        arm: Arm whose frame it is.
        frame: Name of the frame.
        axis: (3,) Unit vector in the frame.
        direction: (3,) Unit vector in the world.
    """

    def __init__(
        self,
        arm: ArmModel,
        axis: ArrayLike,
        direction: ArrayLike | None = None,
        frame: str | None = None,
        gains: MotionGains | None = None,
        *,
        weight: float = 1.0,
        max_angular_speed: float = MAX_ANGULAR_SPEED,
    ) -> None:
        """Set axis, direction and gains.

        Args:
            arm: Arm whose frame it is.
            axis: (3,) Axis in the frame, of any length, such as (0, 0, 1).
            direction: (3,) Direction in the world, of any length; `set_target` sets it later.
            frame: Name of the frame; None for the tool frame.
            gains: Gains [1/s²], whose angular part counts; 400 1/s² by default.
            weight: Weight relative to other tasks.
            max_angular_speed: Largest angular velocity that the spring asks for [rad/s].

        Raises:
            ArgumentError: A vector is zero or not finite, or `arm` is not an arm.
            ModelError: The arm has no such frame.
            ConfigurationError: The weight or the speed is not positive.
            GainsError: The gains are those of an impedance.
        """
        check_arm(arm, "AxisTask")
        self.arm = arm
        self.frame = arm.tool_frame if frame is None else arm.check_frame(frame)
        self.axis = _unit(axis, "axis")
        self.direction: Array | None = None if direction is None else _unit(direction, "direction")
        self.gains = MotionGains(400.0) if gains is None else gains
        if not isinstance(self.gains, MotionGains):
            raise GainsError(f"motion control takes MotionGains in 1/s², not {type(gains).__name__}")
        self.weight = positive_number(weight, "weight", self)
        self.max_angular_speed = positive_number(max_angular_speed, "max_angular_speed", self)
        self._error, self._plane = np.zeros(3), np.eye(3)

    def __repr__(self) -> str:
        return f"AxisTask({self.axis.tolist()}, {self.frame!r})"

    def set_target(self, direction: ArrayLike) -> None:
        """Set the direction (3,) in the world, of any length.

        Raises:
            ArgumentError: It is zero or not finite.
        """
        self.direction = _unit(direction, "direction")

    def check(self, rate: float) -> None:
        """Refuse gains that a loop sampled at `rate` [Hz] cannot hold.

        Raises:
            ConfigurationError: The loop would diverge.
        """
        check_motion_gains(self.gains.stiffness[3:], self.gains.damping[3:], rate, repr(self))

    def rows(self, state: ArmState) -> Objective:
        """Return the three rows at a state; their rank is two.

        Raises:
            ConfigurationError: The task has no direction yet.
        """
        if self.direction is None:
            raise ConfigurationError("the AxisTask has no direction; call set_target(direction) before step")
        view = state if self.frame == state.arm.tool_frame else state.frame(self.frame)
        A, b = np.empty((3, state.arm.nv)), np.empty(3)
        kernels.axis_rows(
            *(view.rotation, view.J, view.Jdot_v, view.twist, self.axis, self.direction),
            *(self.gains.stiffness[3:], self.gains.damping[3:], self.max_angular_speed, np.sqrt(self.weight)),
            *(self._error, self._plane, A, b),
        )
        return Objective(A, b)

    def velocity(self, error_rate: float) -> Array:
        """Return (3,) the weighted angular velocity that the rows ask for; see `Task`."""
        velocity = np.zeros(6)
        velocity[3:] = error_rate * self._error
        kernels.shorten(velocity, *FRICTION_APPROACH)
        return np.sqrt(self.weight) * velocity[3:]


def _unit(vector: ArrayLike, name: str) -> Array:
    try:
        array = np.array(vector, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.zeros(0)
    if array.shape != (3,) or not np.isfinite(array).all() or not array.any():
        raise ArgumentError(f"{name} = {vector!r:.80} must be three finite numbers, and not all zero")
    array /= np.sqrt(array[0] * array[0] + array[1] * array[1] + array[2] * array[2])
    array.setflags(write=False)
    return array
