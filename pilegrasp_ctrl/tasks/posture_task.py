"""The task of a preferred posture, which uses the freedom that the tool leaves."""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from ..exceptions import ConfigurationError
from ..types import Array, frozen_array

POSTURE_WEIGHT = 1e-4
"""Default weight of the posture against the tool's weight of 1; chosen so that it does not disturb the tool."""


class PostureTask:
    """The task of a preferred posture: rows sqrt(weight) (a - stiffness (q* - q) + damping v).

    The weight is small against the tool's, so this task decides only what the tool leaves free. For small accelerations
    it also bounds the joint accelerations near singular postures, as damped least squares do; `SingularDirections` does
    this for large ones. The rows are affine in the state, so a controller evaluates them in one product with the
    limits' bounds.

    Attributes:
        target: (nv,) Preferred joint positions q* [rad]; None only damps.
        stiffness: Stiffness [1/s²].
        damping: Damping, 2 damping_ratio sqrt(stiffness) [1/s].
        weight: Weight relative to other tasks.
        sqrt_weight: Square root of the weight.
    """

    def __init__(
        self,
        target: ArrayLike | None = None,
        stiffness: float = 100.0,
        damping_ratio: float = 1.0,
        weight: float = POSTURE_WEIGHT,
    ) -> None:
        """Set the target and the gains.

        Args:
            target: (nv,) Preferred joint positions [rad]; None only damps.
            stiffness: Stiffness [1/s²].
            damping_ratio: Damping ratio; 1 is critical damping.
            weight: Weight relative to other tasks.

        Raises:
            ConfigurationError: A number is not positive and finite.
            ArgumentError: The target is not a vector of finite numbers.
        """
        for name, value in (("stiffness", stiffness), ("damping_ratio", damping_ratio), ("weight", weight)):
            if not 0.0 < value < np.inf:
                raise ConfigurationError(f"{name} of the posture is {value}; it must be positive and finite")
        self.target = None if target is None else frozen_array(target, np.shape(target)[:1], "posture")
        self.stiffness = float(stiffness)
        self.damping = 2.0 * damping_ratio * sqrt(stiffness)
        self.weight = float(weight)
        self.sqrt_weight = sqrt(weight)

    def __repr__(self) -> str:
        target = None if self.target is None else self.target.tolist()
        return f"PostureTask({target}, stiffness={self.stiffness:g}, weight={self.weight:g})"

    def affine(self, nv: int) -> tuple[Array, Array]:
        """Return matrices (2, nv, 2 nv) and offsets (2, nv) of two blocks of rows that are affine in [q; v].

        The first block is the velocity toward the posture, `sqrt(weight) stiffness / damping (q* - q)`: the slow mode
        of spring and damper. The second is c of the objective, `sqrt(weight) (damping v - stiffness (q* - q))`.
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
