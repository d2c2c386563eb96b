"""The task of a frame that follows a reference as a unit mass would."""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import ArrayLike

from ..arm.model import ArmModel
from ..arm.state import ArmState, FrameState
from ..exceptions import ArgumentError, GainsError
from ..kernels import frame as kernels
from ..types import Array
from .gains import MotionGains
from .pose_task import PoseTask
from .posture_task import POSTURE_WEIGHT
from .sampled_motion import check_motion_gains
from .singular_directions import SingularDirections
from .task import Objective

MAX_SPEED = 1.0
"""Largest speed that the springs of a frame ask for [m/s]; chosen."""
MAX_ANGULAR_SPEED = 3.0
"""Largest angular velocity that the springs of a frame ask for [rad/s]; chosen."""
DEFAULT_GAINS = MotionGains(stiffness=[900.0, 900.0, 900.0, 1600.0, 1600.0, 1600.0])
"""Default gains of a frame's motion [1/s²], critically damped; chosen."""


class FrameTask(PoseTask):
    """A second-order decay of a frame's error that does not depend on the arm's inertia.

    The rows are sqrt(weight) (J a + Jdot_v - wanted), linear axes first, along the world's axes. The law of the wanted
    acceleration is `a_ref + damping (v_ref - v) + stiffness e`. It deviates in two cases that an arm could not follow:

    - The springs never ask for an approach faster than `max_speed` or `max_angular_speed`. Spring and damper together
      hold the speed `stiffness e / damping`. This speed is shortened, in translation and in rotation each as a whole.
      A large error then asks for a speed rather than for an acceleration, as in O. Khatib, IEEE J-RA 3(1), 1987.
      Without this bound a large error in rotation uses up the arm's limits, and the frame strays in translation;
      likewise the reverse.
    - Near singular postures `SingularDirections` reduces the acceleration along the directions that the arm is losing.

    Attributes:
        max_speed: Largest speed that the springs ask for [m/s].
        max_angular_speed: Largest angular velocity that the springs ask for [rad/s].
        numbers: Roots of the weights (6,), stiffness over damping (6,), damping (6,), both speeds, and `free` and
            `threshold` of `SingularDirections`, for a kernel that calls that of the law.
    """

    def __init__(
        self,
        arm: ArmModel,
        frame: str | None = None,
        gains: MotionGains = DEFAULT_GAINS,
        *,
        weight: ArrayLike = 1.0,
        mask: ArrayLike | None = None,
        max_speed: float = MAX_SPEED,
        max_angular_speed: float = MAX_ANGULAR_SPEED,
        posture_weight: float = POSTURE_WEIGHT,
    ) -> None:
        """Set frame, gains and weights; `set_target` sets the target.

        Args:
            arm: Arm whose frame it is.
            frame: Name of the frame; None for the tool frame.
            gains: Gains [1/s²].
            weight: Scalar or (6,) weights, linear axes first, relative to other tasks.
            mask: (6,) Booleans; False leaves an axis free.
            max_speed: Largest speed that the springs ask for [m/s].
            max_angular_speed: Largest angular velocity that the springs ask for [rad/s].
            posture_weight: Weight of the `PostureTask` beside this task; see `SingularDirections`.

        Raises:
            GainsError: The gains are those of an impedance.
            ArgumentError: A weight or a speed cannot be used.
            ModelError: The arm has no such frame.
        """
        for name, value in (("max_speed", max_speed), ("max_angular_speed", max_angular_speed)):
            if not 0.0 < value <= inf:
                raise ArgumentError(f"{name} = {value} must be positive")
        self.max_speed, self.max_angular_speed = float(max_speed), float(max_angular_speed)
        self._posture_weight = posture_weight
        self._gains = _motion_gains(gains)
        super().__init__(arm, frame, weight, mask)

    def __repr__(self) -> str:
        gains = self._gains
        return (
            f"{type(self).__name__}({self.frame!r}, {gains.stiffness.tolist()}, damping_ratio={gains.damping_ratio:g})"
        )

    @property
    def gains(self) -> MotionGains:
        """Gains [1/s²]."""
        return self._gains

    @gains.setter
    def gains(self, gains: MotionGains) -> None:
        self._gains = _motion_gains(gains)
        self._update_axes()

    def _update_axes(self) -> None:
        super()._update_axes()
        controlled = self.root > 0.0
        self._damping = self._gains.damping
        # The error of a free axis must not shorten the speed along the others.
        self._rates = self._gains.stiffness / self._damping * controlled
        self._singular = SingularDirections(controlled, posture_weight=self._posture_weight)
        singular = self._singular
        self.numbers = (
            np.array([self.root, self._rates, self._damping]),
            (self.max_speed, self.max_angular_speed, singular.free, singular.threshold),
        )

    def check(self, rate: float) -> None:
        """Refuse gains that a loop sampled at `rate` [Hz] cannot hold.

        Raises:
            ConfigurationError: The loop would diverge.
        """
        controlled = self.root > 0.0
        check_motion_gains(self._gains.stiffness[controlled], self._gains.damping[controlled], rate, repr(self))

    def acceleration(self, state: ArmState) -> Array:
        """Return (6,) the acceleration that the frame should have at a state [m/s², rad/s²]."""
        return self._law(self.view(state))

    def _law(self, view: ArmState | FrameState) -> Array:
        target, wanted = self.require_target(), np.empty(6)
        pose = target.pose
        kernels.pose_error(pose.translation, pose.rotation, view.translation, view.rotation, self._error)
        missing = kernels.motion_law(
            *(self._error, view.twist, view.Jdot_v, target.twist, target.acceleration),
            *(self._rates, self._damping, self.max_speed, self.max_angular_speed, wanted),
        )
        free = self._singular.free
        return wanted if missing <= free * free else self._singular.reduce(view, wanted)

    def rows(self, state: ArmState) -> Objective:
        """Return the six rows at a state.

        Raises:
            ConfigurationError: The task has no target yet.
        """
        view = self.view(state)
        wanted = self._law(view)
        A, b = np.empty(view.J.shape), np.empty(6)
        kernels.frame_rows(view.J, view.Jdot_v, wanted, self.root, A, b)
        return Objective(A, b)


def _motion_gains(gains: MotionGains) -> MotionGains:
    if not isinstance(gains, MotionGains):
        raise GainsError(f"motion control takes MotionGains in 1/s², not {type(gains).__name__}")
    return gains
