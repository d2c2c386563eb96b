"""OSQP: an operator-splitting method that finds the active bounds; an exact method completes its answer."""

from __future__ import annotations

import threading

import numpy as np
import osqp
from scipy import sparse

from ..types import Array
from .least_distance import LeastDistanceProgram
from .program import QuadraticProgram

_INFINITY = 1e30
"""Value of a bound that OSQP treats as none."""
_SETTINGS = {
    "verbose": False,
    "rho": 10.0,
    # This nearly finds the active set; the cost's scale is 1.
    "eps_abs": 1e-5,
    "eps_rel": 1e-5,
    "max_iter": 100,
    "check_termination": 10,
    "scaling": 0,
    # OSQP's polishing prints to standard output whenever no bound is active.
    "polishing": False,
}
"""Settings of OSQP; chosen."""


class _Workspaces(threading.local):
    """The workspaces of one thread, by the shape of the rows."""

    def __init__(self) -> None:
        self.by_shape: dict[tuple[int, ...], osqp.OSQP] = {}


class OsqpSolver:
    """Keeps one workspace for each size of program, and completes the method's answer.

    The method is that of Stellato et al., "OSQP: an operator splitting solver for quadratic programs", Mathematical
    Programming Computation 12, 2020. It gets the program as a least distance: the cost is a sphere and every row has
    unit length. The distance is scaled to about 1. The method need not converge, and with softened bounds it often does
    not. Its multipliers are the guess of the active bounds from which `LeastDistanceProgram.nearest` finds the
    exact optimum.

    A workspace never changes an answer. Each thread has its own ones, and copies and pickles begin without any.
    """

    name = "osqp"
    reads_only = True

    def __init__(self) -> None:
        """Start without a workspace; `solve` makes one for each size of program."""
        self._kept = _Workspaces()

    def __repr__(self) -> str:
        return "OsqpSolver()"

    def __reduce__(self) -> tuple[type[OsqpSolver], tuple[()]]:
        return type(self), ()

    def solve(self, program: QuadraticProgram) -> Array | None:
        """Return x (n,), or None if there is none."""
        distance = LeastDistanceProgram.from_program(program)
        if distance is None:
            return None
        y = distance.nearest(self._multipliers(distance))
        return None if y is None else distance.x(y)

    def _multipliers(self, distance: LeastDistanceProgram) -> Array:
        """Return OSQP's multipliers (k,), converged or not."""
        rows = distance.rows
        if not len(rows):
            return np.zeros(0)
        unit = max(1.0, float(np.abs(distance.goal).max()))
        data = {
            "q": -distance.goal / unit,
            "l": np.maximum(distance.lower / unit, -_INFINITY),
            "u": np.minimum(distance.upper / unit, _INFINITY),
        }
        workspaces = self._kept.by_shape
        workspace = workspaces.get(rows.shape)
        if workspace is None:
            workspace = workspaces[rows.shape] = _workspace(rows, data)
        else:
            workspace.update(Ax=rows.T.ravel(), **data)
        # Each program starts from the same point, so an answer does not depend on earlier ones.
        workspace.update_settings(rho=_SETTINGS["rho"])
        workspace.warm_start(x=np.zeros(rows.shape[1]), y=np.zeros(len(rows)))
        # OSQP's multipliers are negative at lower bounds.
        return np.nan_to_num(-workspace.solve(raise_error=False).y)


def _workspace(rows: Array, data: dict[str, Array]) -> osqp.OSQP:
    """Return a workspace for dense `rows`; it stores every entry, so later values need no new pattern."""
    m, n = rows.shape
    pattern = (rows.T.ravel(), np.tile(np.arange(m), n), m * np.arange(n + 1))
    workspace = osqp.OSQP()
    A = sparse.csc_matrix(pattern, shape=(m, n))
    workspace.setup(P=sparse.eye(n, format="csc"), A=A, **data, **_SETTINGS)
    return workspace
