"""Random quadratic programs of the controllers' shape, and their optimum by an independent algorithm."""

import numpy as np
from scipy.optimize import nnls

from pilegrasp_ctrl.qp.program import QuadraticProgram


def random_program(seed: int, n: int = 7, tight: float = 1.0) -> QuadraticProgram:
    """Return a feasible program of the controllers' shape: six stiff rows and a weak posture."""
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(6, n))
    H = J.T @ J + 1e-4 * np.eye(n)
    roots = rng.normal(size=(n, n))
    G = roots @ roots.T / n + np.diag(rng.uniform(0.05, 1.0, n))
    inside = rng.normal(size=n)
    values = np.concatenate((inside, G @ inside))
    width = tight * rng.uniform(0.05, 3.0, size=(2, 2 * n))
    f = -J.T @ rng.normal(scale=5.0, size=6) - 1e-4 * rng.normal(size=n)
    return QuadraticProgram(H, f, G, values - width[0], values + width[1])


def contradiction() -> QuadraticProgram:
    """Return a program whose bounds on x contradict those on G x."""
    program = random_program(2)
    n = len(program.f)
    lower, upper = program.lower.copy(), program.upper.copy()
    far = np.linalg.solve(program.G, 0.5 * (lower + upper)[n:]) + 5.0
    lower[:n], upper[:n] = far - 0.1, far + 0.1
    return program._replace(lower=lower, upper=upper)


def least_distance(program: QuadraticProgram) -> np.ndarray:
    """Return the optimum by Lawson and Hanson's least distance programming, an independent algorithm."""
    n = len(program.f)
    L = np.linalg.cholesky(program.H)
    shift = np.linalg.solve(L, program.f)
    rows = np.vstack((np.eye(n), program.G))
    C, d = np.vstack((rows, -rows)), np.concatenate((program.lower, -program.upper))
    finite = np.isfinite(d)
    G = np.linalg.solve(L, C[finite].T).T
    h = d[finite] + G @ shift
    E = np.vstack((G.T, h))
    target = np.eye(n + 1)[n]
    residual = E @ nnls(E, target, maxiter=1000)[0] - target
    return np.linalg.solve(L.T, -residual[:n] / residual[n] - shift)
