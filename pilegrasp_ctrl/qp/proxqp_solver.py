"""ProxQP: a proximal method that finds the active bounds; an exact method completes its answer. Optional."""

from __future__ import annotations

import numpy as np

from ..exceptions import ConfigurationError
from ..types import Array
from .least_distance import LeastDistanceProgram
from .program import QuadraticProgram

try:
    from proxsuite import proxqp
except ImportError:
    raise ConfigurationError("the solver 'proxqp' needs an optional package: pip install 'pilegrasp[proxqp]'") from None

_INFINITY = 1e20
"""Value of a bound that ProxQP treats as none."""


class ProxqpSolver:
    """Keeps one workspace for each size of program, and completes the method's answer.

    The method is the proximal augmented-Lagrangian one of Bambade et al., "PROX-QP: yet another quadratic programming
    solver for robotics and beyond", RSS 2022. It gets the program scaled so that the cost's gradient is about 1,
    because its tolerance is absolute; otherwise programs with softened bounds do not converge. If the cost hardly
    curves, the method stops far from the optimum, and its last digits depend on the workspace's place in memory. Its
    multipliers are the guess of the active bounds from which `LeastDistanceProgram.nearest` finds the exact optimum.

    Attributes:
        name: "proxqp".
    """

    name = "proxqp"

    def __init__(self) -> None:
        """Start without a workspace; `solve` makes one for each size of program."""
        self._workspaces: dict[tuple[int, ...], proxqp.dense.QP] = {}

    def solve(self, problem: QuadraticProgram) -> Array | None:
        """Return x (n,), or None if there is none."""
        distance = LeastDistanceProgram.from_problem(problem)
        if distance is None:
            return None
        multipliers = self._multipliers(problem)
        y = distance.nearest(multipliers[distance.place] * distance.length)
        return None if y is None else distance.x(y)

    def _multipliers(self, problem: QuadraticProgram) -> Array:
        """Return ProxQP's multipliers (n + m,), converged or not."""
        H, f, G, lower, upper = problem
        n = len(f)
        unit = max(1.0, float(np.abs(f).max()))
        lower, upper = np.maximum(lower / unit, -_INFINITY), np.minimum(upper / unit, _INFINITY)
        workspace = self._workspaces.get(G.shape)
        if workspace is None:
            workspace = self._workspaces[G.shape] = _workspace(n, len(G))
        workspace.init(H, f / unit, None, None, G, lower[n:], upper[n:], lower[:n], upper[:n])
        workspace.solve()
        # ProxQP orders multipliers as G x, then x; they are negative at lower bounds.
        return np.nan_to_num(-np.roll(workspace.results.z, n))


def _workspace(n: int, m: int) -> proxqp.dense.QP:
    workspace = proxqp.dense.QP(n, 0, m, True)
    settings = workspace.settings
    # The posture has a weight of 1e-4; a tolerance near that would leave the posture undetermined.
    settings.eps_abs, settings.eps_rel = 1e-9, 0.0
    # Each program starts from the same point, so an answer does not depend on earlier ones.
    settings.initial_guess = proxqp.InitialGuess.NO_INITIAL_GUESS
    # This is enough for the active set. Without a solution, the defaults would run for thousands of iterations.
    settings.max_iter, settings.max_iter_in = 20, 20
    return workspace
