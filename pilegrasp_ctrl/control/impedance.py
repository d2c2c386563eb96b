"""Impedance control: the tool yields to contact like the springs and dampers of its gains."""

from __future__ import annotations

from collections.abc import Collection
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError, ModelError
from ..tasks.frame_task import pose_error
from ..tasks.gain_values import check_wrench
from ..tasks.gains import Impedance
from ..tasks.impedance_task import ImpedanceTask
from ..tasks.posture_task import PostureTask
from ..types import Array, ControllerOutput, Observation, Reference
from .friction_compensation import FrictionCompensation, make_compensation
from .inertia_weighted_dynamics import InertiaWeightedDynamics
from .inverse_dynamics import LIMITS
from .sampled_data import check_stability
from .tool_axes import turn_reference, turn_state, turn_wrench

_NO_BAND = (0.0, 0.0)
"""Dead band of gains without one [N, N·m]."""
_ROUND_OFF = 1e-9
"""Size of a negative eigenvalue of a stiffness, relative to the largest, that counts as round-off; chosen."""


class ImpedanceController:
    """Torques that make the tool yield as an `Impedance`, within all limits.

    After Hogan, "Impedance control: an approach to manipulation", J. Dynamic Systems, Measurement, and Control 107,
    1985. `ImpedanceTask` states the law, and `InertiaWeightedDynamics` how the joints share it. Steady contact gives
    the force K e + desired force, up to joint friction. `docs/impedance.md` has the details.

    Away from the limits, `step` is a pure function of observation and reference. If a limit binds, the torque of the
    environment in the last period counts too.
    """

    def __init__(
        self,
        arm: ArmModel,
        impedance: Impedance,
        posture: PostureTask | ArrayLike | None = None,
        *,
        weight: ArrayLike = 1.0,
        mask: ArrayLike | None = None,
        limits: Collection[str] = LIMITS,
        friction: FrictionCompensation | bool = True,
        solver: str = "daqp",
        rate: float = 500.0,
        stiffness: ArrayLike | None = None,
        wrench_lag: float | None = None,
    ) -> None:
        """Set up the controller.

        Weight and mask are along the axes of the impedance's frame. The friction feed-forward follows the reference's
        motion only: acting on the error, it would add to the force of a steady contact.

        Args:
            arm: Arm to control.
            impedance: Gains [N/m, N·m/rad].
            posture: (nv,) Preferred joint positions [rad], or a posture task. If it is given and
                every tool axis is controlled, the gains are checked there.
            weight: Scalar or (6,) weights of the tool's axes against each other.
            mask: (6,) Booleans; False leaves an axis free.
            limits: Limits to enforce, of "torque", "velocity" and "position".
            friction: Whether to feed the arm's joint friction forward, or the feed-forward itself.
            solver: Name of the solver: "daqp", "osqp", "proxqp" or "quadprog".
            rate: Rate at which you call `step` [Hz].
            stiffness: (6, 6) Stiffness in place of the impedance's springs, whose damping stays; symmetric and positive
                semi-definite, in the axes of the gains.
            wrench_lag: Delay of the measured wrench as a first-order lag [s]; with it, an inertia that is too small for
                this lag is refused.

        Raises:
            GainsError: The impedance is not an `Impedance`.
            ArgumentError: A weight or the posture is not usable.
            ConfigurationError: Another argument is not usable, or the sampled loop would not be stable; see
                `sampled_data`.
        """
        self.arm = arm
        self._task = ImpedanceTask(impedance, weight, mask, None if stiffness is None else _spring_matrix(stiffness))
        if impedance.force_gain > 0.0:
            raise ConfigurationError(
                "force_gain needs a memory: use ContactImpedanceController, or leave force_gain out"
            )
        posture = posture if isinstance(posture, PostureTask) else PostureTask(posture)
        self._dynamics = InertiaWeightedDynamics(arm, self._task, posture, limits, solver, rate)
        if posture.target is not None and (self._task.sqrt_weight == 1.0).all():
            check_stability(arm, impedance, posture.target, rate, wrench_lag)
        self._friction = make_compensation(arm, friction, error_rate=0.0)

    def __repr__(self) -> str:
        return f"ImpedanceController({self.arm!r}, {self._task!r}, solver={self._dynamics.solver.name!r})"

    def step(
        self,
        observation: Observation,
        reference: Reference,
        posture: Array | None = None,
        state: ArmState | None = None,
        desired_force: Array | None = None,
    ) -> ControllerOutput:
        """Return the torques for one control period.

        Args:
            observation: Measurement of the arm. Move its wrench to the tool's origin (`move_wrench`); it is used only
                if the impedance has an inertia.
            reference: Rest pose of the springs and its motion.
            posture: (nv,) Preferred posture for this period [rad].
            state: `arm.update(observation.q, observation.v)`, if you have it already.
            desired_force: (6,) Desired force for this period, in world axes [N, N·m]; the impedance's own by default.

        Raises:
            ModelError: The observation has a wrong shape or a value that is not finite.
            ConfigurationError: The posture or the desired force has a wrong shape or a value that is not finite.
        """
        state = self.arm.update(observation.q, observation.v) if state is None else state
        gains = self._task.impedance
        error = pose_error(state, reference)
        shaped = gains.inertia is not None
        wrench = observation.wrench
        if shaped:
            wrench = check_wrench(wrench, "the observed wrench", ModelError)
        if desired_force is not None:
            desired_force = check_wrench(desired_force, "desired_force")
        if gains.frame == "tool":
            # Springs along axes that turn with the tool would give energy away. These turn with the reference instead.
            axes = reference.pose.rotation
            state, reference, error = turn_state(axes, state), turn_reference(axes, reference), turn_wrench(axes, error)
            wrench = turn_wrench(axes, wrench)
            desired_force = None if desired_force is None else turn_wrench(axes, desired_force)
        force = gains.desired_force if desired_force is None else desired_force
        dynamics = self._dynamics
        # The dead band shortens the wrench that moves the tool. The whole wrench is cancelled, because the rest would
        # move the arm with its own, smaller inertia.
        felt = _apply_dead_band(wrench, gains.dead_band) if shaped and gains.dead_band != _NO_BAND else wrench
        wanted = self._task.acceleration(state, reference, error, force, felt, dynamics.mobility(state))
        dynamics.assemble(state, wanted, posture)
        friction = None if self._friction is None else self._friction.torque(dynamics, reference, error)
        return dynamics.solve(state, friction, -state.J.T.dot(wrench) if shaped else None, observation.time)


def _spring_matrix(value: ArrayLike) -> Array:
    matrix = np.asarray(value, dtype=np.float64)
    if matrix.shape != (6, 6) or not np.isfinite(matrix).all() or not np.allclose(matrix, matrix.T):
        raise ConfigurationError(f"stiffness has the shape {matrix.shape}; give a symmetric, finite 6 x 6 matrix")
    values = np.linalg.eigvalsh(matrix)
    if values[0] < -_ROUND_OFF * max(values[-1], 1.0):
        raise ConfigurationError(
            f"stiffness has the eigenvalue {values[0]:.3g}, so it would push the tool away; raise it to 0"
        )
    return matrix


def _apply_dead_band(wrench: Array, band: tuple[float, float]) -> Array:
    """Return the wrench shortened by its dead bands, so that it does not jump at the border of a band."""
    out = wrench.copy()
    for part, width in ((out[:3], band[0]), (out[3:], band[1])):
        size = sqrt(part.dot(part))
        part *= 0.0 if size <= width else 1.0 - width / size
    return out
