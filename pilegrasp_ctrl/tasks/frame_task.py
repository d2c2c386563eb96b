"""A wanted acceleration of the tool, as rows; what the laws of motion and of impedance have in common."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..arm.state import ArmState
from ..types import Array, Reference
from .objective import Objective


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
