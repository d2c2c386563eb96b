"""Tasks of the tool: rows in the joint accelerations, and the law by which the tool follows a reference."""

from __future__ import annotations

from math import hypot
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..arm.state import ArmState
from ..exceptions import ArgumentError, GainsError
from ..types import Array, Reference
from .gains import MotionGains
from .posture_task import POSTURE_WEIGHT
from .singular_directions import SingularDirections

_MAX_APPROACH_SPEED = 1.0
"""Largest speed that the springs ask for [m/s]; chosen."""
_MAX_APPROACH_ANGULAR_SPEED = 3.0
"""Largest angular velocity that the springs ask for [rad/s]; chosen."""


class Objective(NamedTuple):
    """The cost |A a + c|² of the joint accelerations a; a task's weight enters its rows as a square root.

    A task gives rows rather than H = Aᵀ A. All tasks then share one product, and a weight stays visible.

    Attributes:
        A: (m, nv) Rows.
        c: (m,) Value of the rows at a = 0.
    """

    A: Array
    c: Array


class FrameTask:
    """The task of a wanted tool acceleration: rows sqrt(weight) (J a + Jdot_v - wanted), linear first.

    Rows and weights are along the axes of the state's Jacobian.

    Attributes:
        sqrt_weight: (6,) Square roots of the weights; zero leaves an axis free.
    """

    def __init__(self, weight: ArrayLike = 1.0, mask: ArrayLike | None = None) -> None:
        """Set the weights.

        Args:
            weight: Scalar or (6,) weights, relative to other tasks.
            mask: (6,) Booleans; False leaves an axis free.

        Raises:
            ArgumentError: A weight is negative or not finite, or no axis is left.
        """
        weights = np.array(np.broadcast_to(np.asarray(weight, dtype=np.float64), (6,)))
        if mask is not None:
            weights *= np.asarray(mask, dtype=bool)
        if not np.isfinite(weights).all() or (weights < 0.0).any() or not weights.any():
            raise ArgumentError(f"weight = {weights.tolist()} must be finite, not negative, and not zero on every axis")
        self.sqrt_weight: Array = np.sqrt(weights)
        self.sqrt_weight.setflags(write=False)
        self._column = None if (self.sqrt_weight == 1.0).all() else self.sqrt_weight[:, None]

    def __repr__(self) -> str:
        return f"{type(self).__name__}(weight={np.round(self.sqrt_weight**2, 9).tolist()})"

    def write(self, objective: Objective, state: ArmState, acceleration: Array) -> None:
        """Fill this task's six rows of `objective` for the wanted tool `acceleration` (6,) [m/s², rad/s²]."""
        A, c = objective
        np.subtract(state.Jdot_v, acceleration, out=c)
        if self._column is None:
            A[:] = state.J
        else:
            np.multiply(state.J, self._column, out=A)
            np.multiply(c, self.sqrt_weight, out=c)


class FrameMotionTask(FrameTask):
    """A second-order decay of the tool's error that does not depend on the arm's inertia.

    The law is `a_ref + damping (v_ref - v) + stiffness e`. It deviates in two cases that an arm could not follow:

    - The springs never ask for an approach faster than 1 m/s or 3 rad/s. Spring and damper together hold the speed
      `stiffness e / damping`. This speed is shortened, in translation and in rotation each as a whole. A large error
      then asks for a speed rather than for an acceleration, as in O. Khatib, IEEE J-RA 3(1), 1987. Without this bound
      a large error in rotation uses up the arm's limits, and the tool strays in translation; likewise the reverse.
    - Near singular postures `SingularDirections` reduces the acceleration along the directions that the arm is losing.

    Attributes:
        gains: Gains [1/s²].
        rates: (6,) Stiffness over damping, zero on free axes [1/s].
    """

    def __init__(
        self,
        gains: MotionGains,
        weight: ArrayLike = 1.0,
        mask: ArrayLike | None = None,
        *,
        posture_weight: float = POSTURE_WEIGHT,
    ) -> None:
        """Set the gains.

        Args:
            gains: Gains [1/s²].
            weight: Weights as in `FrameTask`.
            mask: Controlled axes as in `FrameTask`.
            posture_weight: Weight of the `PostureTask` beside this task.

        Raises:
            GainsError: The gains are those of an impedance.
            ArgumentError: The weights cannot be used; see `FrameTask`.
        """
        if not isinstance(gains, MotionGains):
            raise GainsError(f"motion control takes MotionGains in 1/s², not {type(gains).__name__}")
        super().__init__(weight, mask)
        self.gains = gains
        self._damping = gains.damping
        # The error of a free axis must not shorten the speed along the others.
        self.rates = gains.stiffness / gains.damping * (self.sqrt_weight > 0.0)
        self._slowest = min(_MAX_APPROACH_SPEED, _MAX_APPROACH_ANGULAR_SPEED)
        self._singular = SingularDirections(self.sqrt_weight > 0.0, posture_weight=posture_weight)

    def __repr__(self) -> str:
        return f"FrameMotionTask(stiffness={self.gains.stiffness.tolist()}, damping_ratio={self.gains.damping_ratio:g})"

    def acceleration(self, state: ArmState, reference: Reference, error: Array) -> Array:
        """Return (6,) the wanted tool acceleration [m/s², rad/s²].

        Args:
            state: State of the arm.
            reference: Reference of the tool.
            error: (6,) Error of the pose, `pose_error(state, reference)` [m, rad].
        """
        wanted = self.rates * error
        # A vector that is short as a whole is short in both parts. This holds in nearly every period.
        if hypot(*wanted.tolist()) > self._slowest:
            shorten(wanted[:3], _MAX_APPROACH_SPEED)
            shorten(wanted[3:], _MAX_APPROACH_ANGULAR_SPEED)
        wanted += reference.twist
        wanted -= state.twist
        wanted *= self._damping
        wanted += reference.acceleration
        return self._singular.reduce(state, wanted)

    def thresholds(self) -> tuple[float, float, float]:
        """Return the bounds within which the law does not deviate.

        The first is the length of `rates e`. The second is the squared length of the wanted acceleration minus Jdot v.
        The third is the squared smallest singular value of J above which that acceleration may be longer.
        """
        return self._slowest, self._singular.free**2, self._singular.threshold**2


def shorten(vector: Array, length: float) -> None:
    """Scale `vector` in place so that it is not longer than `length`."""
    size = hypot(*vector.tolist())
    if size > length:
        vector *= length / size


def pose_error(state: ArmState, reference: Reference) -> Array:
    """Return (6,) the error of the tool's pose [m, rad], world axes.

    The rotational part is the rotation vector of R_ref Rᵀ. Its derivative is the difference of the angular velocities,
    to first order in the error. It is the shortest rotation, at most half a turn. If the reference is half a turn
    ahead, the sense is arbitrary. Farther ahead, the vector changes its sense at once. The tool does not stay at that
    border, because a controller turns it away on either side.
    """
    error = np.empty(6)
    pose = reference.pose
    np.subtract(pose.translation, state.translation, out=error[:3])
    error[3:] = pin.log3(pose.rotation.dot(state.rotation.T))
    return error
