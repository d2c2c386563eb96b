"""What a tool may be asked for where the arm is about to lose a direction."""

from __future__ import annotations

from math import hypot

import numpy as np
from eigenpy import LLT, ComputationInfo, SelfAdjointEigenSolver  # type: ignore[import-untyped]
from numpy.typing import ArrayLike

from ..arm.state import ArmState
from ..types import Array

_REGULAR = ComputationInfo.Success
# `PostureTask`'s default: what is left of a wish must outweigh it, or an arm would never leave a singular posture.
_POSTURE_WEIGHT = 1e-4


class SingularDirections:
    """Bends a wanted acceleration in the tool's directions in which the joints hardly move it any more.

    With J = Σ sigma_i u_i v_iᵀ, a wish y_i along u_i costs the joints y_i / sigma_i. A constant damping w bounds that
    to y_i / (2 sqrt(w)), which is fifty times the wish with the posture's 1e-4. Worse, a target that stays out of reach
    pulls a bent elbow straight from both sides, as a spring of frequency sqrt(sigma' y / w), sigma' = d sigma / d q:
    beyond any control rate. Here the damping grows with the wish, and only in directions below `threshold`:

        lambda_i² = (1 - sigma_i² / threshold²)² max(|y_i| - free, 0) / rate²
        y_i  ->  (1 - s_i) y_i - s_i damping xdot_i,    s_i = lambda_i² / (sigma_i² + w + lambda_i²)

    so that along v_i the joints accelerate by little more than rate² sigma_i. As sigma_i is proportional to the
    distance from the singular posture, that is a spring whose frequency stays below `rate` sqrt(sigma') whatever the
    error, and `damping` is its damper. Other directions, and wishes below `free`, are left exactly as they are.

    Damping by the singular value: Y. Nakamura, H. Hanafusa, J. Dynamic Systems, Measurement, and Control 108, 1986; in
    the endangered directions alone: S. Chiaverini, B. Siciliano, O. Egeland, IEEE Trans. Control Systems Technology
    2(2), 1994. That it grows with the wish is this project's own.

    Attributes:
        threshold: singular value of J below which a direction is endangered [m/rad or 1].
        rate: [rad/s]; to be well below the control rate.
        damping: [1/s].
        free: wish that is always left alone [m/s², rad/s²].
    """

    def __init__(
        self,
        axes: ArrayLike = True,
        threshold: float = 0.1,
        rate: float = 50.0,
        damping: float = 30.0,
        free: float = 1.0,
    ) -> None:
        """Fix the numbers; `axes` (6,) is true where the tool is controlled."""
        self.threshold, self.rate, self.damping, self.free = threshold, rate, damping, free
        controlled = np.broadcast_to(np.asarray(axes, dtype=bool), (6,))
        self._axes = None if controlled.all() else np.flatnonzero(controlled)
        self._limit = threshold**2 * np.eye(int(controlled.sum()))

    def bend(self, state: ArmState, wanted: Array) -> Array:
        """Return what to ask of the tool in place of `wanted` (6,) [m/s², rad/s²], which is not kept."""
        wish, axes = wanted - state.Jdot_v, self._axes
        # Two exact tests for a wish that stays as it is, because the rest is costly. The second factor exists where all
        # squared singular values exceed the limit.
        if hypot(*wish.tolist()) <= self.free:
            return wanted
        J = state.J if axes is None else state.J[axes]
        gram = J.dot(J.T)
        if LLT(gram - self._limit).info() == _REGULAR:
            return wanted
        solver = SelfAdjointEigenSolver(gram)
        squares, U = solver.eigenvalues(), solver.eigenvectors()
        twist = state.twist
        if axes is not None:
            wish, twist = wish[axes], twist[axes]
        y = wish.dot(U)
        depth = np.maximum(1.0 - squares / self.threshold**2, 0.0) ** 2
        damped = depth * np.maximum(np.abs(y) - self.free, 0.0) / self.rate**2
        share = damped / (np.maximum(squares, 0.0) + _POSTURE_WEIGHT + damped)
        lost = U.dot(share * (y + self.damping * twist.dot(U)))
        if axes is None:
            return wanted - lost
        wanted[axes] -= lost
        return wanted
