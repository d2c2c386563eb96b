"""The task of a frame that yields to forces like springs and dampers."""

from __future__ import annotations

from math import sqrt

import numpy as np
from eigenpy import SelfAdjointEigenSolver  # type: ignore[import-untyped]
from numpy.typing import ArrayLike

from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError, ModelError
from ..kernels import frame as kernels
from ..kernels.algebra import multiply_transposed
from ..types import Array, Pose, Reference
from .gain_values import check_wrench
from .gains import Impedance
from .impedance_law import ImpedanceLaw
from .mobility import mobility_of
from .pose_task import FRICTION_APPROACH, PoseTask
from .task import Objective
from .tool_axes import turn_frame, turn_reference, turn_wrench

_NO_BAND = (0.0, 0.0)
"""Dead band of gains without one [N, N·m]."""
_NO_WRENCH, _NO_MOBILITY = np.zeros(6), np.zeros((6, 6))
_ROUND_OFF = 1e-9
"""Size of a negative eigenvalue of a stiffness, relative to the largest, that counts as round-off; chosen."""


class ImpedanceTask(PoseTask):
    """The task of a frame that yields as an `Impedance`: rows sqrt(weight) (J a + Jdot_v - wanted).

    `ImpedanceLaw` gives the wanted acceleration. Rows, weights and mask are along the axes of the gains: the world's,
    or those of the frame in the reference's orientation. Springs along axes that turn with the frame itself would give
    energy away.

    Attributes:
        desired_force: (6,) Wrench to exert on the environment in place of the gains' own, world axes [N, N·m]; None
            keeps the gains' own.
    """

    def __init__(
        self,
        arm: ArmModel,
        impedance: Impedance,
        frame: str | None = None,
        *,
        weight: ArrayLike = 1.0,
        mask: ArrayLike | None = None,
        stiffness: ArrayLike | None = None,
    ) -> None:
        """Set the gains; `set_target` sets the rest pose of the springs.

        Args:
            arm: Arm whose frame it is.
            impedance: Gains [N/m, N·m/rad].
            frame: Name of the frame; None for the tool frame.
            weight: Scalar or (6,) weights, linear axes first, relative to other tasks.
            mask: (6,) Booleans; False leaves an axis free.
            stiffness: (6, 6) Symmetric, positive semi-definite stiffness in place of the impedance's springs; their
                damping stays.

        Raises:
            GainsError: The gains are those of motion control.
            ConfigurationError: The stiffness cannot be used.
            ArgumentError: A weight cannot be used.
            ModelError: The arm has no such frame.
        """
        self._matrix = None if stiffness is None else _spring_matrix(stiffness)
        self._law = ImpedanceLaw(impedance, self._matrix)
        super().__init__(arm, frame, weight, mask)
        self.desired_force: Array | None = None
        self._twist = np.zeros(6)

    def __repr__(self) -> str:
        impedance = self._law.impedance
        return f"ImpedanceTask({self.frame!r}, {impedance.stiffness.tolist()}, axes of {impedance.frame!r})"

    @property
    def gains(self) -> Impedance:
        """Gains [N/m, N·m/rad]."""
        return self._law.impedance

    @gains.setter
    def gains(self, impedance: Impedance) -> None:
        self._law = ImpedanceLaw(impedance, self._matrix)

    def set_target(self, target: Reference | Pose, desired_force: ArrayLike | None = None) -> None:
        """Set the rest pose of the springs and its motion for the coming periods.

        Args:
            target: Reference, or a pose to rest at.
            desired_force: (6,) Wrench to exert on the environment, world axes [N, N·m]; None keeps the gains' own.

        Raises:
            ArgumentError: The target is neither a reference nor a pose.
            ConfigurationError: The desired force is not six finite numbers.
        """
        super().set_target(target)
        self.desired_force = None if desired_force is None else check_wrench(desired_force, "desired_force")

    def rows(self, state: ArmState) -> Objective:
        """Return the six rows at a state.

        Raises:
            ConfigurationError: The task has no target yet.
            ModelError: The gains have an inertia, and the state's wrench is missing or not finite.
        """
        view, target, gains = self.view(state), self.require_target(), self.gains
        kernels.pose_error(target.pose.translation, target.pose.rotation, view.translation, view.rotation, self._error)
        wrench = self._wrench(state)
        error, desired_force = self._error, self.desired_force
        if gains.frame == "tool":
            axes = target.pose.rotation
            view, target, error = turn_frame(axes, view), turn_reference(axes, target), turn_wrench(axes, error)
            wrench = turn_wrench(axes, wrench)
            desired_force = None if desired_force is None else turn_wrench(axes, desired_force)
        if gains.dead_band != _NO_BAND:
            wrench = _apply_dead_band(wrench, gains.dead_band)
        self._error, self._twist = error, target.twist
        force = gains.desired_force if desired_force is None else desired_force
        shown = _NO_MOBILITY if gains.inertia is not None else mobility_of(state.M, view.J)
        wanted = self._law.acceleration(view, target, error, force, wrench, shown)
        A, b = np.empty(view.J.shape), np.empty(6)
        kernels.frame_rows(view.J, view.Jdot_v, wanted, self.root, A, b)
        return Objective(A, b)

    def torque(self, state: ArmState) -> Array | None:
        """Return (nv,) the torque that cancels the measured wrench, if the gains have an inertia; see `Task`.

        The dead band shortens the wrench that moves the frame. The whole wrench is cancelled, because the rest would
        move the arm with its own, smaller inertia.
        """
        if self.gains.inertia is None:
            return None
        cancelled = np.empty(state.arm.nv)
        multiply_transposed(self.view(state).J, self._wrench(state), cancelled)
        return -cancelled

    def velocity(self, error_rate: float) -> Array:
        """Return (6,) the weighted velocity that the rows ask for; see `Task`."""
        velocity = np.empty(6)
        kernels.frame_velocity(self._error, self._twist, self.root, error_rate, *FRICTION_APPROACH, velocity)
        return velocity

    def _wrench(self, state: ArmState) -> Array:
        if self.gains.inertia is None:
            return _NO_WRENCH
        return check_wrench(state.wrench, "the observed wrench", ModelError)


def _spring_matrix(value: ArrayLike) -> Array:
    matrix = np.asarray(value, dtype=np.float64)
    if matrix.shape != (6, 6) or not np.isfinite(matrix).all() or not np.allclose(matrix, matrix.T):
        raise ConfigurationError(f"stiffness has the shape {matrix.shape}; give a symmetric, finite 6 x 6 matrix")
    values = SelfAdjointEigenSolver(matrix).eigenvalues()
    if values[0] < -_ROUND_OFF * max(values[-1], 1.0):
        raise ConfigurationError(
            f"stiffness has the eigenvalue {values[0]:.3g}, so it would push the tool away; raise it to 0"
        )
    return matrix


def _apply_dead_band(wrench: Array, band: tuple[float, float]) -> Array:
    """Return the wrench shortened by its dead bands, so that it does not jump at the border of a band."""
    out = wrench.copy()
    for part, width in ((out[:3], band[0]), (out[3:], band[1])):
        size = sqrt(part[0] * part[0] + part[1] * part[1] + part[2] * part[2])
        part *= 0.0 if size <= width else 1.0 - width / size
    return out
