"""What is asked of the tool, as rows in the joint accelerations; and the law by which it follows a reference."""

from __future__ import annotations

from math import hypot
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..arm.state import ArmState
from ..types import Array, Reference
from .gains import MotionGains
from .singular_directions import SingularDirections

_APPROACH_SPEED = 1.0
_APPROACH_TURN = 3.0


class Objective(NamedTuple):
    """The cost |A a + c|² of the joint accelerations a; a task's weight enters its rows as a square root.

    Rows rather than H = Aᵀ A: all tasks then share one product, and a weight stays visible.

    Attributes:
        A: (m, nv) rows.
        c: (m,) what the rows are at a = 0.
    """

    A: Array
    c: Array


class FrameTask:
    """Rows sqrt(weight) (J a + Jdot_v - wanted acceleration), world axes, linear axes first.

    Attributes:
        sqrt_weight: (6,) square roots of the weights; zero leaves an axis free.
    """

    def __init__(self, weight: ArrayLike = 1.0, mask: ArrayLike | None = None) -> None:
        """Fix the weights.

        Args:
            weight: a scalar or (6,), relative to other tasks.
            mask: (6,) of truth values; a false axis is left free.

        Raises:
            ValueError: where a weight is negative or not finite, or no axis is left.
        """
        weights = np.array(np.broadcast_to(np.asarray(weight, dtype=np.float64), (6,)))
        if mask is not None:
            weights *= np.asarray(mask, dtype=bool)
        if not np.isfinite(weights).all() or (weights < 0.0).any() or not weights.any():
            raise ValueError(f"weight = {weights.tolist()} must be finite, not negative, and not zero on every axis")
        self.sqrt_weight: Array = np.sqrt(weights)
        self.sqrt_weight.setflags(write=False)
        self._column = None if (self.sqrt_weight == 1.0).all() else self.sqrt_weight[:, None]

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
    """A second-order, inertia-independent decay of the tool's error.

    The law is `a_ref + damping (v_ref - v) + stiffness e`, bent where it asks for what an arm cannot do:

    - The springs never ask for an approach faster than 1 m/s or 3 rad/s. Spring and damper together hold the speed
      `stiffness e / damping`, and it is that which is shortened, in translation and rotation each as a whole. Large
      errors then ask for a speed rather than for an acceleration, as in O. Khatib, IEEE J-RA 3(1), 1987; without it a
      large error of one kind wins the limits of the arm for itself, and the tool strays in the other.
    - Near singular postures `SingularDirections` takes back what is asked for in the directions that get lost.

    Attributes:
        gains: [1/s²].
        rates: (6,) stiffness over damping, zero on free axes [1/s].
    """

    def __init__(self, gains: MotionGains, weight: ArrayLike = 1.0, mask: ArrayLike | None = None) -> None:
        """Take gains in 1/s²; `weight` and `mask` as in `FrameTask`.

        Raises:
            TypeError: where the gains are those of an impedance.
        """
        if not isinstance(gains, MotionGains):
            raise TypeError(f"motion control takes MotionGains in 1/s², not {type(gains).__name__}")
        super().__init__(weight, mask)
        self.gains = gains
        self._damping = gains.damping
        # The error of a free axis must not shorten what is asked for along the others.
        self.rates = gains.stiffness / gains.damping * (self.sqrt_weight > 0.0)
        self._slowest = min(_APPROACH_SPEED, _APPROACH_TURN)
        self._singular = SingularDirections(self.sqrt_weight > 0.0)

    def acceleration(self, state: ArmState, reference: Reference, error: Array) -> Array:
        """Return (6,) the wanted tool acceleration [m/s², rad/s²].

        Args:
            state: the arm.
            reference: where the tool should be.
            error: `pose_error(state, reference)`.
        """
        wanted = self.rates * error
        # What is short as a whole is short in both parts: nearly every period.
        if hypot(*wanted.tolist()) > self._slowest:
            shorten(wanted[:3], _APPROACH_SPEED)
            shorten(wanted[3:], _APPROACH_TURN)
        wanted += reference.twist
        wanted -= state.twist
        wanted *= self._damping
        wanted += reference.acceleration
        return self._singular.bend(state, wanted)

    def thresholds(self) -> tuple[float, float, float]:
        """Return up to where the law is the plain one.

        The length of `rates e`, the square of the length of the wanted acceleration less Jdot v, and the square of the
        least singular value of J above which that may be longer.
        """
        return self._slowest, self._singular.free**2, self._singular.threshold**2


def shorten(vector: Array, length: float) -> None:
    """Scale `vector` in place so that it is not longer than `length`."""
    size = hypot(*vector.tolist())
    if size > length:
        vector *= length / size


def pose_error(state: ArmState, reference: Reference) -> Array:
    """Return (6,) how far the tool is from its reference [m, rad], world axes.

    The orientation's part is the rotation vector of R_ref Rᵀ, whose derivative is the difference of the angular
    velocities to first order in the error. It is the shortest turn, at most half a turn long. A reference that is half
    a turn ahead may be reached in either sense, and one is taken; where it gets ahead by more, the vector changes its
    sense at once. The tool itself is never brought there: a controller turns away from that border on either side.
    """
    error = np.empty(6)
    pose = reference.pose
    np.subtract(pose.translation, state.translation, out=error[:3])
    error[3:] = pin.log3(pose.rotation.dot(state.rotation.T))
    return error
