"""A preferred posture, for the freedom that the tool leaves."""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from ..exceptions import ConfigurationError
from ..types import Array, frozen_array
from .objective import Objective


class PostureTask:
    """Rows sqrt(weight) (a - stiffness (q* - q) + damping v).

    The weight is small against the tool's: it decides where the tool leaves a choice, and it bounds the joint
    accelerations near singular postures as damped least squares do.

    Attributes:
        target: (nv,) the preferred joint positions [rad]; None only damps.
        stiffness: [1/s²].
        damping: 2 damping_ratio sqrt(stiffness) [1/s].
        weight: relative to other tasks.
    """

    def __init__(
        self,
        target: ArrayLike | None = None,
        stiffness: float = 100.0,
        damping_ratio: float = 1.0,
        weight: float = 1e-4,
    ) -> None:
        """Fix the target and the gains.

        Raises:
            ConfigurationError: where a number is not positive and finite.
            ValueError: where the target is not a vector of finite numbers.
        """
        for name, value in (("stiffness", stiffness), ("damping_ratio", damping_ratio), ("weight", weight)):
            if not 0.0 < value < np.inf:
                raise ConfigurationError(f"{name} of the posture is {value}; it must be positive and finite")
        self.target = None if target is None else frozen_array(target, np.shape(target)[:1], "posture")
        self.stiffness = float(stiffness)
        self.damping = 2.0 * damping_ratio * sqrt(stiffness)
        self.weight = float(weight)
        self._sqrt_weight = sqrt(weight)

    def acceleration(self, q: Array, v: Array, target: Array | None = None) -> Array:
        """Return (nv,) the wanted joint accelerations toward `target`, the task's own where absent [rad/s²]."""
        wanted = v * -self.damping
        target = self.target if target is None else target
        if target is not None:
            spring = target - q
            spring *= self.stiffness
            wanted += spring
        return wanted

    def write_matrix(self, objective: Objective) -> None:
        """Fill this task's rows of the matrix, which do not depend on the state."""
        objective.A[:] = self._sqrt_weight * np.eye(len(objective.b))

    def write(self, objective: Objective, q: Array, v: Array, target: Array | None = None) -> None:
        """Fill this task's targets for the present state."""
        np.multiply(self.acceleration(q, v, target), self._sqrt_weight, out=objective.b)

    def write_velocity(self, out: Array, q: Array, target: Array | None = None) -> None:
        """Fill `out` (nv,) with this task's rows for velocities: the slow mode of its spring and damper."""
        target = self.target if target is None else target
        if target is None:
            out.fill(0.0)
        else:
            np.subtract(target, q, out=out)
            out *= self._sqrt_weight * self.stiffness / self.damping
