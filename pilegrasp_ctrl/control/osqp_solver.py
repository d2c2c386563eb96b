"""OSQP: an operator-splitting method, in a workspace that is kept."""

from __future__ import annotations

import numpy as np
import osqp
from scipy import sparse

from ..types import Array
from .qp import QuadraticProgram

_INFINITY = 1e30
_REFUSED = {
    osqp.SolverStatus.OSQP_PRIMAL_INFEASIBLE,
    osqp.SolverStatus.OSQP_PRIMAL_INFEASIBLE_INACCURATE,
    osqp.SolverStatus.OSQP_NON_CVX,
}
_SETTINGS = {
    "verbose": False,
    # At the default 1e-3 limits are exceeded by a per mille and the weakly weighted posture is lost.
    "eps_abs": 1e-9,
    "eps_rel": 1e-9,
    "max_iter": 20000,
    "check_termination": 10,
    "scaling": 0,
    # Polishing prints to standard output whenever no bound is active.
    "polishing": False,
}


class OsqpSolver:
    """Keeps one workspace for each size of program.

    The method converges slowly where the cost's curvature differs between directions, and here it differs by the ratio
    of tool to posture weight. It is therefore given y = Lᵀ x with L Lᵀ = H, in which the cost is a sphere, and rows of
    unit length.

    Attributes:
        name: "osqp".
    """

    name = "osqp"

    def __init__(self) -> None:
        """Set up no workspace yet."""
        self._workspaces: dict[tuple[int, int], osqp.OSQP] = {}

    def solve(self, problem: QuadraticProgram) -> Array | None:
        """Return x (n,), or None where OSQP finds none."""
        if not all(np.isfinite(array).all() for array in (problem.H, problem.f, problem.G)):
            return None
        inverse = np.linalg.inv(np.linalg.cholesky(problem.H))
        bounded = np.isfinite(problem.lower) | np.isfinite(problem.upper)
        rows = np.vstack((inverse.T, problem.G @ inverse.T))[bounded]
        scale = 1.0 / np.linalg.norm(rows, axis=1)
        rows *= scale[:, None]
        lower = np.maximum(problem.lower[bounded] * scale, -_INFINITY)
        upper = np.minimum(problem.upper[bounded] * scale, _INFINITY)
        if not (lower <= upper).all():
            return None
        q = inverse @ problem.f
        workspace = self._workspaces.get(rows.shape)
        if workspace is None:
            workspace = self._workspaces[rows.shape] = _workspace(rows, q, lower, upper)
        else:
            workspace.update(q=q, Ax=rows.T.ravel(), l=lower, u=upper)
        # Each program starts from the same point, so that an answer does not depend on those before it.
        workspace.warm_start(x=np.zeros(len(q)), y=np.zeros(len(lower)))
        result = workspace.solve(raise_error=False)
        return None if result.info.status_val in _REFUSED else inverse.T @ result.x


def _workspace(rows: Array, q: Array, lower: Array, upper: Array) -> osqp.OSQP:
    """Return a workspace for dense `rows`: every entry is stored, so that later values need no new pattern."""
    m, n = rows.shape
    pattern = (rows.T.ravel(), np.tile(np.arange(m), n), m * np.arange(n + 1))
    workspace = osqp.OSQP()
    A = sparse.csc_matrix(pattern, shape=(m, n))
    workspace.setup(P=sparse.eye(n, format="csc"), q=q, A=A, l=lower, u=upper, **_SETTINGS)
    return workspace
