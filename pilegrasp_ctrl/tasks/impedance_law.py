"""The acceleration with which a frame yields to forces like springs and dampers."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from eigenpy import SelfAdjointEigenSolver  # type: ignore[import-untyped]

from ..arm.state import ArmState, FrameState
from ..exceptions import GainsError
from ..kernels import impedance as kernels
from ..kernels.algebra import multiply
from ..types import Array, Reference
from ..vectors import product
from .gains import Impedance

_MIN_FREQUENCY = 1e-3
"""Frequency whose square is added to every mode's; keeps damping finite at a singular posture [rad/s]; chosen."""


class ImpedanceLaw:
    """The acceleration that an impedance asks for.

    Without `inertia`, with Lambda = (J M⁻¹ Jᵀ)⁻¹ the inertia that the arm shows at the frame,

        Lambda (x'' - a_ref) = K e + D e' + F_des + F_env,    e' = v_ref - v,

    which needs no measured wrench, because the environment itself adds F_env. The springs' part of D damps each mode of
    (Lambda, K) at the same ratio: D = 2 ratio (Lambda # K). Here # is the geometric mean of two matrices. This is the
    double diagonalisation of Albu-Schäffer, Ott, Frese and Hirzinger, "Cartesian impedance control of redundant
    robots: recent results with the DLR-light-weight-arms", ICRA 2003. With `inertia`, that diagonal inertia replaces
    Lambda; the measured wrench is cancelled and acts on this inertia instead.

    Attributes:
        impedance: Gains [N/m, N·m/rad].
        stiffness: (6, 6) Stiffness K [N/m, N·m/rad].
    """

    def __init__(self, impedance: Impedance, stiffness: Array | None = None) -> None:
        """Set the gains.

        Args:
            impedance: Gains [N/m, N·m/rad].
            stiffness: (6, 6) Symmetric, positive semi-definite matrix in place of the impedance's springs; their
                damping stays.

        Raises:
            GainsError: The gains are those of motion control.
        """
        if not isinstance(impedance, Impedance):
            raise GainsError(f"impedance control takes an Impedance in N/m and N·m/rad, not {type(impedance).__name__}")
        self.impedance = impedance
        self.stiffness: Array = np.diag(impedance.stiffness) if stiffness is None else stiffness
        sprung = np.flatnonzero(impedance.stiffness) if impedance.damping_ratio > 0.0 else np.arange(0)
        self._factor = np.ascontiguousarray(np.diag(np.sqrt(impedance.stiffness))[:, sprung])
        self._floor = _MIN_FREQUENCY**2 * np.eye(len(sprung))
        self._anisotropic = not _isotropic(self.stiffness)
        self._dampers = np.concatenate(([impedance.damping_ratio], impedance.damping))
        self._shaped_root = None if impedance.inertia is None else self._inverse_root(np.diag(1.0 / impedance.inertia))

    def acceleration(
        self,
        view: ArmState | FrameState,
        reference: Reference,
        error: Array,
        desired_force: Array,
        wrench: Array,
        mobility: Array,
    ) -> Array:
        """Return (6,) the wanted acceleration [m/s², rad/s²]; everything is in the axes of the gains.

        Args:
            view: Kinematics of the frame.
            reference: Rest pose of the springs and its motion.
            error: (6,) Error of the pose, `pose_error(view, reference)` [m, rad].
            desired_force: (6,) Wrench that the hand should exert on the environment [N, N·m].
            wrench: (6,) Wrench of the environment on the hand, at the frame's origin [N, N·m]; used only if the
                impedance has an inertia.
            mobility: (6, 6) Mobility J M⁻¹ Jᵀ [1/kg, 1/(kg m), 1/(kg m²)]; used only if it has none.
        """
        impedance, rate, force = self.impedance, reference.twist - view.twist, np.empty(6)
        multiply(self.stiffness, error, force)
        if self._anisotropic:
            force[3:] = _moment(force[3:], error[3:])
        force += desired_force
        root = self._inverse_root(mobility) if self._shaped_root is None else self._shaped_root
        kernels.damping_force(self._factor, root, self._dampers, rate, force)
        if impedance.inertia is not None:
            acceleration: Array = reference.acceleration + (force + wrench) / impedance.inertia
            return acceleration
        wanted = np.empty(6)
        multiply(mobility, force, wanted)
        wanted += reference.acceleration
        return wanted

    def damping(self, mobility: Array) -> Array:
        """Return D (6, 6) [N·s/m, N·m·s/rad] for the frame's mobility Lambda⁻¹ (6, 6).

        With K = B Bᵀ, Lambda # K = B (Bᵀ Lambda⁻¹ B)^-½ Bᵀ for any factor B. The bracket's eigenvalues are the squares
        of the modes' natural frequencies [rad²/s²]. At a singular posture one of them would be zero; a small floor
        prevents that. The acceleration stays finite, because the mobility multiplies the force afterwards.
        """
        springs = product(product(self._factor, self._inverse_root(mobility)), self._factor.T)
        return np.diag(self.impedance.damping) + 2.0 * self.impedance.damping_ratio * springs

    def _inverse_root(self, mobility: Array) -> Array:
        """Return (Bᵀ Lambda⁻¹ B)^-½ of the axes with a spring."""
        squares = np.empty(self._floor.shape)
        if not len(squares):
            return squares
        kernels.congruence(self._factor, mobility, squares)
        squares += self._floor
        root: Array = SelfAdjointEigenSolver(squares).operatorInverseSqrt()
        return root


def _isotropic(stiffness: Array) -> bool:
    """Return whether K e is the gradient of ½ eᵀ K e for any rotation: no coupling, one rotational stiffness."""
    rotation = stiffness[3:, 3:]
    return not np.any(stiffness[:3, 3:]) and np.array_equal(rotation, rotation[0, 0] * np.eye(3))


def _moment(gradient: Array, rotation: Array) -> Array:
    """Return (3,) the moment of a spring whose potential has `gradient` (3,) in the rotation vector `rotation` (3,).

    Without it, springs that differ from axis to axis would give energy away on a closed path of large rotations
    (F. Caccavale, C. Natale, B. Siciliano and L. Villani, "Six-DOF impedance control based on angle/axis
    representations", IEEE T-RA 15(2), 1999). The two agree to first order in the rotation.
    """
    moment = np.empty(3)
    multiply(pin.Jlog3(pin.exp3(rotation)).T, gradient, moment)
    return moment
