"""The tool yields to forces like springs and dampers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arm_state import ArmState
from ..control.gains import Impedance
from ..types import Array, Reference
from .frame_task import FrameTask

_SLOWEST_MODE = 1e-3


class ImpedanceTask(FrameTask):
    """The acceleration at which the tool obeys an impedance.

    Without `inertia`, with Lambda = (J M⁻¹ Jᵀ)⁻¹ the inertia that the arm shows at the tool,

        Lambda (x'' - a_ref) = K e + D e' + F_des + F_env,    e' = v_ref - v,

    which needs no measured wrench: the environment adds F_env by itself. The springs' part of D damps each mode of
    (Lambda, K) at the same ratio: D = 2 ratio (Lambda # K), the geometric mean of the two matrices, as in Albu-Schäffer,
    Ott, Frese and Hirzinger, "Cartesian impedance control of redundant robots", ICRA 2003. With `inertia`, that
    diagonal inertia stands in place of Lambda, and the measured wrench is cancelled and put to act on it.
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
        self._sprung = np.flatnonzero(impedance.stiffness)
        self._root = np.sqrt(impedance.stiffness[self._sprung])

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
        gains = self.impedance
        rate = reference.twist - state.twist
        force = gains.stiffness * error + gains.damping * rate + desired_force
        if gains.inertia is not None:
            force += 2.0 * gains.damping_ratio * np.sqrt(gains.stiffness * gains.inertia) * rate
            return reference.acceleration + (force + wrench) / gains.inertia
        mobility = state.J.dot(np.linalg.solve(state.M, state.J.T))
        force += self._damping_force(mobility, rate)
        return reference.acceleration + mobility.dot(force)

    def _damping_force(self, mobility: Array, rate: Array) -> Array:
        """Return D e' for D = 2 ratio K^½ (K^½ Lambda⁻¹ K^½)^-½ K^½, on the axes that have a spring.

        The eigenvalues of the bracket are the squares of the modes' natural frequencies; at a singular posture one is
        zero, so they are kept off it: the mobility multiplies the force afterwards and leaves a finite acceleration.
        """
        sprung, root = self._sprung, self._root
        force = np.zeros(6)
        squares, modes = np.linalg.eigh(root[:, None] * mobility[np.ix_(sprung, sprung)] * root)
        frequencies = np.sqrt(np.maximum(squares, _SLOWEST_MODE**2))
        modal = modes.T.dot(root * rate[sprung]) / frequencies
        force[sprung] = 2.0 * self.impedance.damping_ratio * root * modes.dot(modal)
        return force
