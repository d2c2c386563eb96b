"""The torque of a period without a solution: gravity is held, and motion is damped."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arm.state import ArmState
from ..exceptions import SolverError, environment_fault
from ..kernels.algebra import cholesky, multiply, solve_factored
from ..limits.torque_limit import TorqueLimit
from ..types import Array, Command, ControllerOutput

_DAMPING = 10.0
"""Damping of the joints over their inertia [1/s]; chosen."""


def fall_back(
    state: ArmState, cut: Callable[[Array, ArmState], Array], error: SolverError, elapsed: float
) -> ControllerOutput:
    """Return gravity compensation with damping, within the torque limits of the arm.

    Args:
        state: State of the arm.
        cut: Function that returns a torque (nv,) within the limits of the controller [N·m].
        error: Why there is no solution.
        elapsed: Time that the solver took [s].
    """
    limit = TorqueLimit(state.arm)
    h: Array = np.nan_to_num(state.h)
    wanted: Array = np.nan_to_num(h - _DAMPING * state.M.diagonal() * state.v)
    torque = limit.cut(cut(wanted, state))
    rows = wanted.copy()
    if limit.matrix is not None:
        multiply(limit.matrix, wanted, rows)
    names = [
        f"{limit.row_names[row]} {'upper' if rows[row] > 0.0 else 'lower'}"
        for row in np.flatnonzero(np.abs(rows) >= limit.limit).tolist()
    ]
    acceleration, factor = torque - h, np.empty(state.M.shape)
    cholesky(state.M, factor)
    solve_factored(factor, acceleration)
    reason, refused = f"{error}; gravity compensation with damping instead", environment_fault(error) or ""
    return ControllerOutput(Command(torque), acceleration, tuple(names), elapsed, reason, refused)
