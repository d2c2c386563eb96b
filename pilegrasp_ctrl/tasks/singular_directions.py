"""A bound on the wanted tool acceleration along directions that the arm is about to lose."""

from __future__ import annotations

from math import hypot

import numpy as np
from eigenpy import LLT, ComputationInfo, SelfAdjointEigenSolver  # type: ignore[import-untyped]
from numpy.typing import ArrayLike

from ..arm.state import ArmState
from ..types import Array
from .posture_task import POSTURE_WEIGHT

_REGULAR = ComputationInfo.Success
"""Outcome of a Cholesky factorisation whose matrix is positive definite."""


class SingularDirections:
    """Reduces a wanted tool acceleration along the directions in which the joints hardly move the tool.

    With J = Σ sigma_i u_i v_iᵀ, an acceleration y_i along u_i costs the joints y_i / sigma_i. A constant damping w, the
    posture's weight, bounds that to y_i / (2 sqrt(w)): fifty times y_i with w = 1e-4. Worse, a target that stays out of
    reach pulls a bent elbow straight from both sides, as a spring of frequency sqrt(sigma' y / w), beyond any
    control rate; sigma' is the derivative of sigma by q. In this class the damping grows with the wanted acceleration,
    and only in directions below `threshold`:

        lambda_i² = (1 - sigma_i² / threshold²)² max(|y_i| - free, 0) / rate²
        y_i  ->  (1 - s_i) y_i - s_i damping xdot_i,    s_i = lambda_i² / (sigma_i² + w + lambda_i²)

    Along v_i the joints then accelerate by little more than rate² sigma_i, and sigma_i is proportional to the distance
    from the singular posture. The result is a spring whose frequency stays below `rate` sqrt(sigma') for any error;
    `damping` is its damper. Other directions, and accelerations below `free`, stay exactly as they are. The remaining
    y_i must outweigh w; otherwise an arm would never leave a singular posture.

    Damping by the singular value: Y. Nakamura, H. Hanafusa, J. Dynamic Systems, Measurement, and Control 108, 1986; in
    the endangered directions alone: S. Chiaverini, B. Siciliano, O. Egeland, IEEE Trans. Control Systems Technology
    2(2), 1994. The growth with the wanted acceleration is an addition
    of this project.

    Attributes:
        threshold: Singular value of J below which a direction is endangered [m/rad or 1].
        rate: Frequency bound [rad/s]; choose it well below the control rate.
        damping: Damping along an endangered direction [1/s].
        free: Acceleration that is never reduced [m/s², rad/s²].
        posture_weight: Weight w of the posture task.
    """

    def __init__(
        self,
        axes: ArrayLike = True,
        threshold: float = 0.1,
        rate: float = 50.0,
        damping: float = 30.0,
        free: float = 1.0,
        posture_weight: float = POSTURE_WEIGHT,
    ) -> None:
        """Set the attributes, which the class describes; `axes` (6,) is True for each axis under control."""
        self.threshold, self.rate, self.damping, self.free = threshold, rate, damping, free
        self.posture_weight = posture_weight
        controlled = np.broadcast_to(np.asarray(axes, dtype=bool), (6,))
        self._axes = None if controlled.all() else np.flatnonzero(controlled)
        self._limit = threshold**2 * np.eye(int(controlled.sum()))

    def reduce(self, state: ArmState, wanted: Array) -> Array:
        """Return the acceleration to ask for in place of `wanted` (6,) [m/s², rad/s²]; `wanted` may be overwritten."""
        missing, axes = wanted - state.Jdot_v, self._axes
        # Two exact tests find an acceleration that stays as it is, and save the costly rest. In the second, a Cholesky
        # factor exists if all squared singular values exceed the limit.
        if hypot(*missing.tolist()) <= self.free:
            return wanted
        J = state.J if axes is None else state.J[axes]
        gram = J.dot(J.T)
        if LLT(gram - self._limit).info() == _REGULAR:
            return wanted
        solver = SelfAdjointEigenSolver(gram)
        squares, U = solver.eigenvalues(), solver.eigenvectors()
        twist = state.twist
        if axes is not None:
            missing, twist = missing[axes], twist[axes]
        y = missing.dot(U)
        depth = np.maximum(1.0 - squares / self.threshold**2, 0.0) ** 2
        damped = depth * np.maximum(np.abs(y) - self.free, 0.0) / self.rate**2
        share = damped / (np.maximum(squares, 0.0) + self.posture_weight + damped)
        lost = U.dot(share * (y + self.damping * twist.dot(U)))
        if axes is None:
            return wanted - lost
        wanted[axes] -= lost
        return wanted
