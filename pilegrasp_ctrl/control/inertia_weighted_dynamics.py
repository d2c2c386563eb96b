"""Inverse dynamics for a hand in contact: joints count by their inertia, and limits allow for contact forces."""

from __future__ import annotations

from collections.abc import Collection
from time import perf_counter
from typing import NamedTuple

import numpy as np
from eigenpy import LLT  # type: ignore[import-untyped]

from ..arm.friction import coulomb_torque
from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..qp.program import QuadraticProgram
from ..tasks.frame_task import FrameTask
from ..tasks.posture_task import PostureTask
from ..types import Array, Command, ControllerOutput
from .inverse_dynamics import EXPECTED_FRICTION_SCALE, FRICTION_RESERVE, LIMITS, InverseDynamics

_TOOL_PRIORITY = 100.0
"""Cost of the tool's part of a deviation, over that of the freedom that the tool leaves; chosen.

With it the other joints compensate an elbow at its limit. They do not compensate a saturated wrist, whose inertia is a
thousandth of a shoulder's.
"""
_MIN_ELAPSED = 0.5
"""Smallest elapsed time, in control periods, with which the last call counts as one period ago; chosen."""
_MAX_ELAPSED = 1.5
"""Largest elapsed time, in control periods, with which the last call counts as one period ago; chosen."""


class _Period(NamedTuple):
    """Time, state and command of the last period."""

    time: float
    state: ArmState
    acceleration: Array
    friction: Array | None


class InertiaWeightedDynamics(InverseDynamics):
    """The limits of `InverseDynamics` under a cost that measures joints by their inertia.

        minimise    (a - a*)ᵀ (M + c Jᵀ Lambda J) (a - a*),      a* = a_posture + M⁻¹ Jᵀ W^½ F,
                    F = (W^½ Lambda⁻¹ W^½ + w)⁻¹ W^½ (wanted - Jdot_v - J a_posture)

    a* minimises the cost of `InverseDynamics` with the posture's part measured by the inertia. As w goes to zero, its
    torque is Khatib's dynamically consistent `Jᵀ F + M a_posture + h` (IEEE J-RA 3(1), 1987). A spring then acts as
    `Jᵀ` force: a push at the tool and the springs' answer cancel in every joint, not only at the tool. Equal weights
    for all joints would answer a push that turns a light wrist with the heavy joints of the shoulder. Added to
    the mobility Lambda⁻¹, w is the mobility of a mass of 1 / w = 10 t. It changes a force by less than a thousandth,
    and it keeps the acceleration finite at a singular posture.

    If no limit binds, a* is the answer. If one does, the metric M alone would be Gauss's principle of least constraint:
    the arm accelerates as if the limit belonged to its mechanics, and the tool yields. With c = 100 the
    solution first uses the freedom that the tool leaves, but does not accelerate heavy joints hard for a light one.

    Bounds on the accelerations are meant for those that actually follow. If a hand presses on something, the wanted
    accelerations do not follow. A bound that binds is therefore relaxed by the acceleration that the environment took
    away in the last period. The last period is remembered for that.
    """

    _memory = ("_last",)

    def __init__(
        self,
        arm: ArmModel,
        task: FrameTask,
        posture: PostureTask,
        limits: Collection[str] = LIMITS,
        solver: str = "daqp",
        rate: float = 500.0,
    ) -> None:
        """Allocate the program; arguments and errors are those of `InverseDynamics`."""
        super().__init__(arm, task, posture, limits, solver, rate)
        self._rate = rate
        self._weighted = not (task.sqrt_weight == 1.0).all()
        self._floor = posture.weight * np.eye(6)
        self._slack = np.zeros((2, 2 * arm.nv))
        self._above_lower, self._below_upper = self._slack
        self._reserve = np.concatenate((np.full(arm.nv, FRICTION_RESERVE), np.zeros(arm.nv)))
        # numpy multiplies by an array faster than by a number, which it has to wrap first.
        self._pull_rate = np.full(arm.nv, posture.stiffness / posture.damping)
        self._posture_damping = np.full(arm.nv, posture.damping)
        self._last: _Period | None = None
        self._mobility_state: ArmState | None = None

    def mobility(self, state: ArmState) -> Array:
        """Return (6, 6) Lambda⁻¹ = J M⁻¹ Jᵀ of a state [1/kg, 1/(kg m), 1/(kg m²)]; `assemble` reuses it."""
        self._mobility_state = state
        self._compliance = LLT(state.M).solve(state.J.T)
        self._mobility: Array = state.J.dot(self._compliance)
        return self._mobility

    def assemble(self, state: ArmState, wanted: Array, posture: Array | None = None) -> None:
        """Write the cost and the bounds on a; arguments and errors are those of `InverseDynamics.assemble`."""
        super().assemble(state, wanted, posture)
        mobility = self._mobility if self._mobility_state is state else self.mobility(state)
        target = self._posture.target if posture is None else posture
        # Toward the posture: the slow mode of spring and damper as a velocity, and both as an acceleration.
        self._pull = None if target is None else self._pull_rate * (target - state.q)
        a = -state.v if self._pull is None else self._pull - state.v
        a *= self._posture_damping
        if self._weighted:
            root = self._task.sqrt_weight
            mobility = root[:, None] * mobility * root
        self._factor = LLT(mobility + self._floor)
        missing = wanted - state.Jdot_v
        missing -= state.J.dot(a)
        a += self._compliance.dot(self._force(missing))
        self._best, self._torque = a, state.M.dot(a)

    def _force(self, missing: Array) -> Array:
        """Return W^½ F (6,) for the missing acceleration or velocity (6,) of the tool."""
        if not self._weighted:
            force: Array = self._factor.solve(missing)
            return force
        root = self._task.sqrt_weight
        return root * self._factor.solve(root * missing)

    def joint_velocity(self, twist: Array) -> Array:
        """Return (nv,) the joint velocity that a tool twist and the posture ask for [rad/s]; call `assemble` first."""
        if self._pull is None or self._mobility_state is None:
            return self._compliance.dot(self._force(twist))
        return self._pull + self._compliance.dot(self._force(twist - self._mobility_state.J.dot(self._pull)))

    def solve(
        self,
        state: ArmState,
        friction: Array | None = None,
        cancelled: Array | None = None,
        time: float | None = None,
    ) -> ControllerOutput:
        """Return the torques of the program that was assembled.

        Args:
            state: State that was assembled.
            friction: (nv,) Torque against the expected friction [N·m].
            cancelled: (nv,) Torque against a known torque of the environment on the joints [N·m].
            time: Time of the observation [s]; it shows whether the last call was one period ago.
        """
        start = perf_counter()
        offset = state.h if friction is None else state.h + friction
        if cancelled is not None:
            offset = offset + cancelled
        if self._torque_limit is not None:
            self._torque_limit.write(*self._torque_bounds, offset)
        _, _, G, lower, upper = self._program
        best, slack = self._best, self._slack
        values = np.concatenate((best, G.dot(best)))
        np.subtract(values, lower, self._above_lower)
        np.subtract(upper, values, self._below_upper)
        np.subtract(slack, self._reserve, slack)
        # argmin costs a fifth of min. It finds a NaN first, which fails the comparison.
        if slack.item(slack.argmin()) > 0.0:
            output = ControllerOutput(Command(self._torque + offset), best, (), perf_counter() - start)
        else:
            self._relax_bounds(state, time)
            H = self._metric(state)
            self._program = QuadraticProgram(H, -H.dot(best), G, lower, upper)
            output = super().solve(state, friction, cancelled)
        self._last = None if time is None else _Period(time, state, output.acceleration, friction)
        return output

    def _metric(self, state: ArmState) -> Array:
        """Return (nv, nv) the metric M + c Jᵀ Lambda J of deviations from a*."""
        J = self._task.sqrt_weight[:, None] * state.J if self._weighted else state.J
        return state.M + _TOOL_PRIORITY * J.T.dot(self._factor.solve(J))

    def _relax_bounds(self, state: ArmState, time: float | None) -> None:
        """Move the bounds outwards by the acceleration that the environment took away in the last period.

        They never move inwards, because such a bound would answer an impact with the full torque.
        """
        last = self._last
        if last is None or time is None or not _MIN_ELAPSED < (time - last.time) * self._rate < _MAX_ELAPSED:
            return
        arm, v = self.arm, state.v
        rest = -coulomb_torque(v, arm.friction_coulomb, EXPECTED_FRICTION_SCALE) - arm.friction_viscous * v
        if last.friction is not None:
            rest += last.friction
        expected = last.acceleration + LLT(last.state.M).solve(rest)
        taken = (v - last.state.v) * self._rate - expected
        # Friction alone can take this much from a joint that it holds, so the environment need not be the cause.
        held = arm.friction_coulomb * np.linalg.inv(last.state.M).diagonal()
        lower, upper = self._program.lower[: len(v)], self._program.upper[: len(v)]
        lower -= np.maximum(taken - held, 0.0)
        upper -= np.minimum(taken + held, 0.0)
