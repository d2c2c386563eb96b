"""A preferred posture, for the freedom that the tool leaves."""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from ..exceptions import ConfigurationError
from ..types import Array, frozen_array


class PostureTask:
    """Rows sqrt(weight) (a - stiffness (q* - q) + damping v).

    The weight is small against the tool's: it decides where the tool leaves a choice, and it bounds the joint
    accelerations near singular postures as damped least squares do, for small wishes; `SingularDirections` is for the
    large ones. Its rows are affine in the state, so that a controller evaluates them in one product with the limits'
    bounds.

    Attributes:
        target: (nv,) the preferred joint positions q* [rad]; None only damps.
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
        self.sqrt_weight = sqrt(weight)

    def affine(self, nv: int) -> tuple[Array, Array]:
        """Return matrices (2, nv, 2 nv) and offsets (2, nv) of two blocks of rows that are affine in x = [q; v].

        The first is the velocity toward the posture, `sqrt(weight) stiffness / damping (q* - q)`, the slow mode of
        spring and damper. The second is c of the objective, `sqrt(weight) (damping v - stiffness (q* - q))`.
        """
        identity, zero = np.eye(nv), np.zeros((nv, nv))
        spring = zero if self.target is None else self.sqrt_weight * self.stiffness * identity
        damper = self.sqrt_weight * self.damping * identity
        pull = spring @ (np.zeros(nv) if self.target is None else self.target)
        matrices = np.stack((np.hstack((-spring / self.damping, zero)), np.hstack((spring, damper))))
        return matrices, np.stack((pull / self.damping, -pull))

    def retarget(self, rows: Array, q: Array, target: Array) -> None:
        """Change the values `rows` (2, nv) of `affine` at joint positions `q` to those for another `target` (nv,)."""
        shift = target - (q if self.target is None else self.target)
        shift *= self.sqrt_weight * self.stiffness
        rows[0] += shift / self.damping
        rows[1] -= shift
