"""OSQP: an operator-splitting method, in a workspace that is kept."""

from __future__ import annotations

import numpy as np
import osqp
from scipy import sparse

from ..types import Array
from .qp import QuadraticProgram

_INFINITY = 1e30
_SOFT_WEIGHT = 1e6
_SETTINGS = {
    "verbose": False,
    # At the default 1e-3 limits are exceeded by a per mille and the weakly weighted posture is lost.
    "eps_abs": 1e-9,
    "eps_rel": 1e-9,
    "max_iter": 20000,
    "check_termination": 10,
    # Polishing prints to standard output whenever no bound is active.
    "polishing": False,
}


class OsqpSolver:
    """Keeps one workspace for hard bounds and, once needed, one for soft bounds.

    Attributes:
        name: "osqp".
    """

    name = "osqp"

    def __init__(self, n: int, m: int) -> None:
        """Prepare for n variables and m rows."""
        self._n, self._m = n, m
        self._workspaces: dict[bool, osqp.OSQP] = {}
        columns, rows = np.tril_indices(n)
        self._upper_triangle = (rows, columns)
        self._A = np.ones((n, 1 + m))

    def solve(self, problem: QuadraticProgram, soft: bool) -> Array | None:
        """Return x (n,), or None where OSQP does not converge."""
        n = self._n
        lower = np.maximum(problem.lower, -_INFINITY)
        upper = np.minimum(problem.upper, _INFINITY)
        if not np.isfinite(problem.f).all() or (lower > upper).any():
            return None
        self._A[:, 1:] = problem.G.T
        Px, Ax, q = problem.H[self._upper_triangle], self._A.ravel(), problem.f
        if soft:
            Px = np.concatenate((Px, np.full(n, _SOFT_WEIGHT)))
            Ax = np.concatenate((Ax, np.ones(n)))
            q = np.concatenate((q, np.zeros(n)))
        workspace = self._workspaces.get(soft)
        if workspace is None:
            workspace = self._workspaces[soft] = self._setup(Px, q, Ax, lower, upper, soft)
        else:
            workspace.update(Px=Px, q=q, Ax=Ax, l=lower, u=upper)
        # Each program starts from the same point, so that an answer does not depend on those before it.
        workspace.warm_start(x=np.zeros(len(q)), y=np.zeros(len(lower)))
        result = workspace.solve(raise_error=False)
        return np.array(result.x[:n]) if result.info.status_val == 1 else None

    def _setup(self, Px: Array, q: Array, Ax: Array, lower: Array, upper: Array, soft: bool) -> osqp.OSQP:
        n, m = self._n, self._m
        lengths = np.arange(1, n + 1)
        rows = self._upper_triangle[0]
        a_rows = np.hstack((np.arange(n)[:, None], np.tile(np.arange(n, n + m), (n, 1)))).ravel()
        a_lengths = np.full(n, 1 + m)
        if soft:
            rows = np.concatenate((rows, np.arange(n, 2 * n)))
            lengths = np.concatenate((lengths, np.ones(n, dtype=int)))
            a_rows = np.concatenate((a_rows, np.arange(n)))
            a_lengths = np.concatenate((a_lengths, np.ones(n, dtype=int)))
        size = len(q)
        P = sparse.csc_matrix((Px, rows, np.concatenate(([0], np.cumsum(lengths)))), shape=(size, size))
        A = sparse.csc_matrix((Ax, a_rows, np.concatenate(([0], np.cumsum(a_lengths)))), shape=(n + m, size))
        workspace = osqp.OSQP()
        workspace.setup(P=P, q=q, A=A, l=lower, u=upper, **_SETTINGS)
        return workspace
