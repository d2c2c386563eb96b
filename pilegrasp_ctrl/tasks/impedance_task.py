"""The tool yields to forces like springs and dampers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arm_state import ArmState
from ..control.gains import Impedance
from ..control.linear_algebra import inverse_square_root, solve_positive_definite
from ..types import Array, Reference
from .frame_task import FrameTask

_SLOWEST_MODE = 1e-3


class ImpedanceTask(FrameTask):
    """The acceleration at which the tool obeys an impedance.

    Without `inertia`, with Lambda = (J M⁻¹ Jᵀ)⁻¹ the inertia that the arm shows at the tool,

        Lambda (x'' - a_ref) = K e + D e' + F_des + F_env,    e' = v_ref - v,

    which needs no measured wrench: the environment adds F_env by itself. The springs' part of D damps each mode of
    (Lambda, K) at the same ratio: D = 2 ratio (Lambda # K), with the geometric mean of the two matrices, which is
    the double diagonalisation of Albu-Schäffer, Ott, Frese and Hirzinger, "Cartesian impedance control of
    redundant robots: recent results with the DLR-light-weight-arms", ICRA 2003. With `inertia`, that diagonal inertia
    stands in place of Lambda, and the measured wrench is cancelled and put to act on it.
    """

    def __init__(self, impedance: Impedance, weight: ArrayLike = 1.0, mask: ArrayLike | None = None) -> None:
        """Take an impedance in N/m; `weight` and `mask` as in `FrameTask`.

        Raises:
            TypeError: where the gains are those of motion control.
        """
        if not isinstance(impedance, Impedance):
            raise TypeError(f"impedance control takes an Impedance in N/m and N·m/rad, not {type(impedance).__name__}")
        super().__init__(weight, mask)
        self.impedance = impedance
        sprung = np.flatnonzero(impedance.stiffness)
        root = np.sqrt(impedance.stiffness[sprung])
        self._block = np.ix_(sprung, sprung)
        self._outer = np.outer(root, root)
        self._floor = _SLOWEST_MODE**2 * np.eye(len(sprung))
        self._viscous = np.diag(impedance.damping)
        if impedance.inertia is not None:
            critical = 2.0 * np.sqrt(impedance.stiffness * impedance.inertia)
            self._shaped_damping = impedance.damping_ratio * critical + impedance.damping

    def acceleration(
        self, state: ArmState, reference: Reference, error: Array, desired_force: Array, wrench: Array
    ) -> Array:
        """Return (6,) the wanted tool acceleration [m/s², rad/s²].

        Args:
            state: the arm.
            reference: where the springs rest.
            error: `pose_error(state, reference)`.
            desired_force: (6,) what the hand shall exert on the environment [N, N·m].
            wrench: (6,) what the environment does to the hand, at the tool's origin [N, N·m]; used where the
                impedance has an inertia.
        """
        impedance = self.impedance
        rate = reference.twist - state.twist
        force = impedance.stiffness * error
        force += desired_force
        if impedance.inertia is not None:
            force += self._shaped_damping * rate
            force += wrench
            return reference.acceleration + force / impedance.inertia
        mobility = state.J.dot(solve_positive_definite(state.M, state.J.T))
        force += self.damping(mobility).dot(rate)
        return reference.acceleration + mobility.dot(force)

    def damping(self, mobility: Array) -> Array:
        """Return D (6, 6) [N·s/m, N·m·s/rad] for the tool's mobility Lambda⁻¹ (6, 6).

        On the axes that have a spring, Lambda # K = K^½ (K^½ Lambda⁻¹ K^½)^-½ K^½. The bracket's eigenvalues are the
        squares of the modes' natural frequencies [rad²/s²]. At a singular posture one is zero; it is kept off that,
        and the acceleration stays finite because the mobility multiplies the force afterwards.
        """
        damping = self._viscous.copy()
        if not self._outer.size:
            return damping
        stiff_mobility = mobility[self._block] * self._outer
        stiff_mobility += self._floor
        damping[self._block] += 2.0 * self.impedance.damping_ratio * self._outer * inverse_square_root(stiff_mobility)
        return damping
