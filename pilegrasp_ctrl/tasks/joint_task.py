"""The task of joints that go to a posture, and of joints that yield as springs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, sqrt

import numpy as np
from numpy.typing import ArrayLike

from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ArgumentError, ConfigurationError
from ..kernels import joints as kernels
from ..types import Array
from .linear_task import LinearTask, positive_number, select_joints
from .mobility import mobility_of
from .posture_task import STIFFNESS
from .sampled_motion import spectral_radius
from .task import Objective

MAX_JOINT_SPEED = 0.5
"""Default speed at which joints go to a far posture [rad/s]; chosen."""
_ROUND_OFF = 1e-9
"""Excess of a spectral radius over 1 that counts as round-off; chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class JointImpedance:
    """Springs and dampers at the joints, in units of torque. Zero stiffness leaves an arm that a hand can guide.

    Attributes:
        stiffness: Stiffness, one number or one for each joint [N·m/rad].
        damping: Damping beside that of the springs, one number or one for each joint [N·m·s/rad].
        damping_ratio: Damping ratio of the springs on the inertia of each joint that moves alone.
    """

    stiffness: ArrayLike
    damping: ArrayLike = 0.0
    damping_ratio: float = 1.0


class JointTask(LinearTask):
    """The task of joints at target positions.

    With a stiffness in 1/s², the joints accelerate by `stiffness (q* - q) - damping v`, whatever their inertia. They go
    to a far target at `max_speed`. With a `JointImpedance`, the *torque* of their acceleration is `K (q* - q) - D v`. A
    push then moves them like springs and dampers, and gravity stays compensated.
    """

    def __init__(
        self,
        arm: ArmModel,
        target: ArrayLike | None = None,
        stiffness: ArrayLike | JointImpedance = STIFFNESS,
        damping_ratio: float = 1.0,
        *,
        joints: Sequence[str] | None = None,
        weight: float = 1.0,
        max_speed: ArrayLike = MAX_JOINT_SPEED,
    ) -> None:
        """Set target and gains.

        Args:
            arm: Arm whose joints they are.
            target: (m,) Target positions [rad]; None only damps.
            stiffness: Scalar or (m,) stiffness [1/s²], or a `JointImpedance` [N·m/rad].
            damping_ratio: Damping ratio of a stiffness in 1/s²; 1 is critical damping.
            joints: Names of the m joints; all joints by default.
            weight: Weight relative to other tasks.
            max_speed: Scalar or (m,) largest speed that a stiffness in 1/s² asks for [rad/s].

        Raises:
            ConfigurationError: A number is out of range, or a shape is wrong.
            ArgumentError: `arm` is not an arm, or a joint is unknown.
        """
        C = select_joints(arm, joints, "JointTask")
        self._impedance = stiffness if isinstance(stiffness, JointImpedance) else None
        ratio = positive_number(damping_ratio, "damping_ratio", self)
        if isinstance(stiffness, JointImpedance):
            super().__init__(arm, C, target, stiffness.stiffness, stiffness.damping, weight, inf)
            self._ratio = float(stiffness.damping_ratio)
            if not 0.0 <= self._ratio < inf:
                raise ConfigurationError(f"damping_ratio = {self._ratio} of the JointImpedance must not be negative")
        else:
            super().__init__(arm, C, target, stiffness, 0.0, weight, max_speed)
            spring = self._gain("stiffness", stiffness)
            self._set_springs(self.stiffness, 2.0 * ratio * np.sqrt(spring))

    def __repr__(self) -> str:
        unit = "1/s²" if self._impedance is None else "N·m/rad"
        return f"JointTask({self.target.tolist()}, stiffness={self.stiffness.tolist()} {unit}, weight={self.weight:g})"

    @property
    def is_linear(self) -> bool:
        """Whether the rows are those of `linear_rows`: not those of an impedance."""
        return self._impedance is None

    def check(self, rate: float) -> None:
        """Refuse gains that a loop sampled at `rate` [Hz] cannot hold; those of an impedance depend on the posture.

        Raises:
            ConfigurationError: The loop would diverge.
        """
        if self._impedance is None:
            super().check(rate)
            return
        arm = self.arm
        q = np.where(np.isfinite(arm.q_upper - arm.q_lower), 0.5 * (arm.q_lower + arm.q_upper), 0.0)
        M = arm.update(q, np.zeros(arm.nv)).M
        inertia = np.einsum("ij,jk,ik->i", self.C, M, self.C)
        damping = self.damping + 2.0 * self._ratio * np.sqrt(self.stiffness * inertia)
        mobility = mobility_of(M, self.C)
        if spectral_radius(mobility, np.diag(self.stiffness), np.diag(damping), rate) > 1.0 + _ROUND_OFF:
            raise ConfigurationError(
                f"{self!r} diverges at {rate:g} Hz with the joints of {arm.name} in mid-range; take lower gains, or a "
                "higher rate"
            )

    def rows(self, state: ArmState) -> Objective:
        """Return the rows at a state."""
        if self._impedance is None:
            return super().rows(state)
        A, b = np.empty(self.C.shape), np.empty(len(self.C))
        gains, factor = (self.stiffness, self._ratio, self.damping), np.empty((len(self.C), len(self.C)))
        kernels.impedance_rows(self.C, state.M, state.q, state.v, self.target, *gains, self._root, factor, A, b)
        self._wanted = np.zeros(len(self.C))
        return Objective(A, b)


class CouplingTask(LinearTask):
    """The task of a linear relation among joints: Σ coefficient q = value, such as two joints that turn alike."""

    def __init__(
        self,
        arm: ArmModel,
        coefficients: Mapping[str, float],
        value: float = 0.0,
        stiffness: float = STIFFNESS,
        damping_ratio: float = 1.0,
        *,
        weight: float = 1.0,
        max_speed: float = MAX_JOINT_SPEED,
    ) -> None:
        """Set the relation and its gains.

        Args:
            arm: Arm whose joints they are.
            coefficients: Coefficient of each joint, by its name; joints that are not named do not count.
            value: Value that the sum should have [rad].
            stiffness: Stiffness [1/s²].
            damping_ratio: Damping ratio; 1 is critical damping.
            weight: Weight relative to other tasks.
            max_speed: Largest speed of the sum that the spring asks for [rad/s].

        Raises:
            ConfigurationError: A number is out of range.
            ArgumentError: `arm` is not an arm, a joint is unknown, or all coefficients are zero.
        """
        if not isinstance(coefficients, Mapping):
            raise ArgumentError(f"coefficients = {coefficients!r:.80} must map names of joints to numbers")
        rows = select_joints(arm, tuple(coefficients), "CouplingTask")
        try:
            C = np.array([float(c) for c in coefficients.values()])[:, None] * rows
            C = C.sum(axis=0)[None]
        except (TypeError, ValueError):
            C = np.zeros((1, arm.nv))
        if not np.isfinite(C).all() or not C.any():
            raise ArgumentError(f"coefficients = {dict(coefficients)!r:.80} must be finite numbers, and not all zero")
        stiffness = positive_number(stiffness, "stiffness", self)
        damping = 2.0 * positive_number(damping_ratio, "damping_ratio", self) * sqrt(stiffness)
        super().__init__(arm, C, value, stiffness, damping, weight, max_speed)
        self._coefficients = dict(coefficients)

    def __repr__(self) -> str:
        return f"CouplingTask({self._coefficients}, value={self.target[0]:g})"

    @property
    def coefficients(self) -> Array:
        """(nv,) Coefficient of each joint."""
        return self.C[0]
