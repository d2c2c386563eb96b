"""A bound on the wanted tool acceleration along directions that the arm is about to lose."""

from __future__ import annotations

import numpy as np
from eigenpy import SelfAdjointEigenSolver  # type: ignore[import-untyped]
from numpy.typing import ArrayLike

from ..arm.state import ArmState, FrameState
from ..kernels.algebra import cholesky, gram_of_rows, length_square
from ..kernels.singular import singular_loss
from ..types import Array
from .posture_task import POSTURE_WEIGHT


class SingularDirections:
    """Reduces a wanted tool acceleration along the directions in which the joints hardly move the tool.

    With J = Σ sigma_i u_i v_iᵀ, an acceleration y_i along u_i costs the joints y_i / sigma_i. A constant damping w, the
    posture's weight, bounds that to y_i / (2 sqrt(w)): fifty times y_i with w = 1e-4. Worse, a target out of reach
    pulls a bent elbow straight like a spring of frequency sqrt(sigma' y / w). This exceeds any control rate; sigma' is
    the derivative of sigma by q. In this class the damping grows with the wanted acceleration, and only in directions
    below `threshold`:

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

    def reduce(self, view: ArmState | FrameState, wanted: Array) -> Array:
        """Return the acceleration to ask for in place of `wanted` (6,) [m/s², rad/s²]; `wanted` may be overwritten.

        `view` has Jacobian, Jdot v and twist of the frame.
        """
        missing, axes, J, twist = wanted - view.Jdot_v, self._axes, view.J, view.twist
        if axes is not None:
            missing, J, twist = missing[axes], J[axes], twist[axes]
        # Two exact tests find an acceleration that stays as it is, and save the costly rest. In the second, a Cholesky
        # factor exists if all squared singular values exceed the limit.
        if length_square(missing) <= self.free * self.free:
            return wanted
        gram, factor = np.empty((2, len(missing), len(missing)))
        gram_of_rows(J, -self.threshold * self.threshold, gram)
        if cholesky(gram, factor):
            return wanted
        gram_of_rows(J, 0.0, gram)
        solver = SelfAdjointEigenSolver(gram)
        lost = np.empty(len(missing))
        constants = self.threshold, self.rate, self.damping, self.free, self.posture_weight
        singular_loss(solver.eigenvalues(), solver.eigenvectors(), missing, twist, *constants, lost)
        if axes is None:
            return wanted - lost
        wanted[axes] -= lost
        return wanted
