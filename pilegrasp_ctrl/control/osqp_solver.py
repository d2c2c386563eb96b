"""OSQP: an operator-splitting method, in a workspace that is kept."""

from __future__ import annotations

import numpy as np
import osqp
from scipy import sparse

from ..types import Array
from .qp import QuadraticProgram

_INFINITY = 1e30
_STAGES = (1e-5, 1e-7, 1e-9)
_SETTINGS = {
    "verbose": False,
    "rho": 10.0,
    "max_iter": 4000,
    "check_termination": 10,
    "scaling": 0,
    # The default calls tight but feasible programs infeasible.
    "eps_prim_inf": 1e-7,
    # Its own polishing prints to standard output whenever no bound is active.
    "polishing": False,
}
_INFEASIBLE = osqp.SolverStatus.OSQP_PRIMAL_INFEASIBLE
_EXACT = 1e-9


class OsqpSolver:
    """Keeps one workspace for each size of program, and sharpens what the method found.

    The method converges slowly where the cost's curvature differs between directions, and here it differs by the ratio
    of tool to posture weight. It is therefore given y = Lᵀ x with L Lᵀ = H, in which the cost is a sphere, and rows of
    unit length. It stops as soon as it knows which bounds are active: with these as equations the optimum follows in
    closed form, and its multipliers tell whether they were the right ones.

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
        y = self._minimise(inverse @ problem.f, rows, lower, upper)
        return None if y is None else inverse.T @ y

    def _minimise(self, q: Array, rows: Array, lower: Array, upper: Array) -> Array | None:
        """Return the y that minimises ½ |y|² + qᵀ y under lower <= rows y <= upper."""
        workspace = self._workspaces.get(rows.shape)
        if workspace is None:
            workspace = self._workspaces[rows.shape] = _workspace(rows, q, lower, upper)
        else:
            workspace.update(q=q, Ax=rows.T.ravel(), l=lower, u=upper)
        # Each program starts from the same point, so that an answer does not depend on those before it.
        workspace.warm_start(x=np.zeros(len(q)), y=np.zeros(len(lower)))
        for tolerance in _STAGES:
            workspace.update_settings(rho=_SETTINGS["rho"], eps_abs=tolerance, eps_rel=tolerance)
            result = workspace.solve(raise_error=False)
            if result.info.status_val == _INFEASIBLE:
                return None
            y = _sharpen(q, rows, lower, upper, result.y)
            if y is not None:
                return y
        return np.array(result.x)


def _sharpen(q: Array, rows: Array, lower: Array, upper: Array, multipliers: Array) -> Array | None:
    """Return the optimum if the bounds with a multiplier are those that are active in it, else None."""
    active = np.abs(multipliers) > _EXACT
    at_upper = multipliers[active] > 0.0
    chosen = rows[active]
    y, exact = -q, np.zeros(len(chosen))
    if len(chosen):
        gap = chosen @ q + np.where(at_upper, upper[active], lower[active])
        exact = np.asarray(-np.linalg.lstsq(chosen @ chosen.T, gap, rcond=None)[0], dtype=np.float64)
        y = y - chosen.T @ exact
    values = rows @ y
    size = 1.0 + np.abs(values)
    feasible = (values >= lower - _EXACT * size).all() and (values <= upper + _EXACT * size).all()
    return y if feasible and (np.where(at_upper, exact, -exact) >= -_EXACT).all() else None


def _workspace(rows: Array, q: Array, lower: Array, upper: Array) -> osqp.OSQP:
    """Return a workspace for dense `rows`: every entry is stored, so that later values need no new pattern."""
    m, n = rows.shape
    pattern = (rows.T.ravel(), np.tile(np.arange(m), n), m * np.arange(n + 1))
    workspace = osqp.OSQP()
    A = sparse.csc_matrix(pattern, shape=(m, n))
    workspace.setup(P=sparse.eye(n, format="csc"), q=q, A=A, l=lower, u=upper, **_SETTINGS)
    return workspace
