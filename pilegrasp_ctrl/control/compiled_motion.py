"""The usual period of operational-space control in compiled code: optional, and about twice as fast."""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np

from ..arm.state import ArmState
from ..exceptions import ConfigurationError
from ..qp.program import QuadraticProgram
from ..tasks.frame_task import FrameMotionTask
from ..types import Array, Command, ControllerOutput, Reference
from .friction_compensation import FrictionCompensation
from .inverse_dynamics import ACTIVE, InverseDynamics


class CompiledMotion:
    """Compiled code for periods in which no limit is near, the posture is regular and the error is moderate.

    In every other period `step` returns None, and the caller uses the Python code, which handles all cases. If both
    give torques, these agree to 1e-9 N·m. They are not the same bits, because sums are taken in another order.
    """

    def __init__(self, dynamics: InverseDynamics, task: FrameMotionTask, friction: FrictionCompensation | None) -> None:
        """Take the numbers from the parts of a controller.

        Args:
            dynamics: Program of the controller.
            task: Task of the tool.
            friction: Friction feed-forward; None without one.

        Raises:
            ConfigurationError: numba is not installed.
        """
        try:
            from .compiled_kernels import assemble, judge
        except ImportError:
            raise ConfigurationError(
                "compiled control needs numba; `pip install pilegrasp[fast]`, or leave controller.compiled at false"
            ) from None
        self._assemble, self._judge = assemble, judge
        self._arguments = dynamics, task, friction
        self._dynamics = dynamics
        n = dynamics.arm.nv
        numbers = (*task.thresholds(), dynamics.posture_root, *_friction_numbers(friction))
        self._constants = (
            *dynamics.constants(),
            np.stack((task.sqrt_weight, task.rates, task.gains.damping)),
            np.vstack((dynamics.arm.velocity_limit, *_factors(friction, n), *dynamics.limits())),
            np.array(numbers),
        )
        H, f, G = np.zeros((n, n)), np.zeros(n), np.zeros((n, n))
        self._program = QuadraticProgram(H, f, G, np.zeros(2 * n), np.zeros(2 * n))
        self._offset = np.zeros(n)
        self._out = (*self._program, self._offset)
        self._n = n

    def __repr__(self) -> str:
        return f"CompiledMotion({self._dynamics!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and pickle by the arguments; see `InverseDynamics`."""
        return type(self), self._arguments

    def step(self, state: ArmState, reference: Reference) -> ControllerOutput | None:
        """Return the torques for one control period, or None if the case is not the usual one."""
        x, _, _, M, h, J, Jdot_v, p, R, twist = state
        pose = reference.pose
        nearest = self._assemble(
            x, M, h, J, Jdot_v, p, R, twist, pose.translation, pose.rotation, reference.twist, reference.acceleration,
            *self._constants, *self._out,
        )  # fmt: skip
        if not self._dynamics.is_far(nearest):
            return None
        start = perf_counter()
        a = self._dynamics.solver.solve(self._program)
        elapsed = perf_counter() - start
        if a is None:
            return None
        torque: Array = np.empty(self._n)
        _, _, G, lower, upper = self._program
        if not self._judge(a, M, self._offset, G, lower, upper, torque) > ACTIVE:
            return None
        return ControllerOutput(Command(torque), a, (), elapsed)


def _factors(friction: FrictionCompensation | None, n: int) -> tuple[Array, Array]:
    return (np.zeros(n), np.zeros(n)) if friction is None else (friction.coulomb, friction.viscous)


def _friction_numbers(friction: FrictionCompensation | None) -> tuple[float, ...]:
    if friction is None:
        return 0.0, 0.0, 1.0, 1.0, 1.0
    return (1.0, friction.error_rate, friction.scale, *friction.largest_approach)
