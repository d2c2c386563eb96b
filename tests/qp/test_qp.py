"""Every solver finds the optimum within all bounds, and an answer counts only if its residuals are small."""

import sys
from typing import get_args

import numpy as np
import pytest
import qpsolvers
from scipy.optimize import nnls

import qp_programs
from arms import load
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.exceptions import ConfigurationError, SolverError
from pilegrasp_ctrl.qp import program as qp
from pilegrasp_ctrl.qp.least_distance import LeastDistanceProgram
from pilegrasp_ctrl.qp.program import QuadraticProgram, make_solver
from pilegrasp_ctrl.sections import ControllerConfig

EXACT = 1e-9


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


def least_distance(problem: QuadraticProgram) -> np.ndarray:
    """Return the optimum by Lawson and Hanson's least distance programming, an independent algorithm."""
    n = len(problem.f)
    L = np.linalg.cholesky(problem.H)
    shift = np.linalg.solve(L, problem.f)
    rows = np.vstack((np.eye(n), problem.G))
    C, d = np.vstack((rows, -rows)), np.concatenate((problem.lower, -problem.upper))
    finite = np.isfinite(d)
    G = np.linalg.solve(L, C[finite].T).T
    h = d[finite] + G @ shift
    E = np.vstack((G.T, h))
    target = np.eye(n + 1)[n]
    residual = E @ nnls(E, target, maxiter=1000)[0] - target
    return np.linalg.solve(L.T, -residual[:n] / residual[n] - shift)


@pytest.fixture(params=qp.SOLVERS)
def solver(request):
    return qp_programs.installed(request.param)


@pytest.mark.parametrize("tight", [0.3, 1.0, 10.0])
def test_the_optimum_is_found_and_every_bound_held(solver, tight):
    active = 0
    for seed in range(30):
        problem = random_program(seed, tight=tight)
        solution = qp.solve(problem, solver)
        assert not solution.relaxed
        assert solution.margin >= -qp.FEASIBILITY
        np.testing.assert_allclose(solution.x, least_distance(problem), atol=EXACT)
        active += solution.margin < 1e-6
    assert active > 0


def test_qpsolvers_confirms_that_residuals_and_duality_gap_vanish():
    """qpsolvers computes primal and dual residuals and the duality gap from the problem and multipliers."""
    problem = random_program(3)
    solution = qp.solve(problem, make_solver("daqp"))
    n = len(problem.f)
    rows = np.vstack((problem.G, -problem.G))
    judged = qpsolvers.Problem(
        problem.H,
        problem.f,
        rows,
        np.r_[problem.upper[n:], -problem.lower[n:]],
        None,
        None,
        problem.lower[:n],
        problem.upper[:n],
    )
    reference = qpsolvers.solve_problem(judged, solver="daqp")
    assert max(reference.primal_residual(), reference.dual_residual(), abs(reference.duality_gap())) < 1e-6
    np.testing.assert_allclose(solution.x, reference.x, atol=1e-9)


def test_without_bounds_the_answer_is_the_minimum(solver):
    problem = random_program(1)._replace(lower=np.full(14, -np.inf), upper=np.full(14, np.inf))
    solution = qp.solve(problem, solver)
    np.testing.assert_allclose(solution.x, np.linalg.solve(problem.H, -problem.f), atol=1e-6)
    assert solution.margin == np.inf


def contradiction() -> QuadraticProgram:
    """Return a program whose bounds on x contradict those on G x."""
    problem = random_program(2)
    n = len(problem.f)
    lower, upper = problem.lower.copy(), problem.upper.copy()
    far = np.linalg.solve(problem.G, 0.5 * (lower + upper)[n:]) + 5.0
    lower[:n], upper[:n] = far - 0.1, far + 0.1
    return problem._replace(lower=lower, upper=upper)


def test_if_bounds_contradict_the_rows_the_bounds_are_softened_and_the_rows_hold(solver):
    problem = contradiction()
    n = len(problem.f)
    solution = qp.solve(problem, solver)
    assert solution.relaxed
    assert solution.margin < -0.1
    assert (solution.slack[:, n:] >= -qp.FEASIBILITY).all()


def test_softened_bounds_are_exceeded_by_a_least_squares_amount(solver):
    problem = contradiction()
    np.testing.assert_allclose(qp.solve(problem, solver).x, least_distance(problem.softened())[:7], atol=1e-6)


def test_a_feasible_program_is_not_softened(solver):
    problem = random_program(4, tight=0.3)
    np.testing.assert_allclose(qp.solve(problem, solver).x, least_distance(problem), atol=EXACT)
    soft = least_distance(problem.softened())[:7]
    assert np.abs(soft - least_distance(problem)).max() > 1e-6


class WrongSolver:
    """A solver that returns a wrong answer as solved."""

    name = "wrong"

    def __init__(self, answer):
        self.answer = answer

    def solve(self, problem):
        return None if self.answer is None else np.full(len(problem.f), self.answer)


@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")
@pytest.mark.parametrize("answer", [10.0, 1e9, np.nan, np.inf, None])
def test_an_answer_is_accepted_by_its_residuals_not_by_the_solver_s_status(answer):
    with pytest.raises(SolverError, match="wrong found no accelerations within the torque limits"):
        qp.solve(random_program(0), WrongSolver(answer))


@pytest.mark.parametrize(
    ("field", "value"),
    [("H", np.nan), ("f", np.nan), ("G", np.nan), ("lower", np.nan), ("H", np.inf), ("f", np.inf), ("G", -np.inf)],
)
def test_a_program_that_is_not_finite_is_an_error_and_names_its_part(solver, field, value):
    problem = random_program(0)
    bad = getattr(problem, field).copy()
    bad.flat[3] = value
    with pytest.raises(SolverError, match="bounds" if field == "lower" else f"program's {field} "):
        qp.solve(problem._replace(**{field: bad}), solver)


@pytest.mark.parametrize("row", [3, 9])
@pytest.mark.parametrize("bound", [np.inf, 1e3])
def test_a_lower_bound_above_the_upper_one_is_an_error(solver, row, bound):
    problem = random_program(0)
    lower = problem.lower.copy()
    lower[row] = bound
    with pytest.raises(SolverError, match=f"{solver.name} found no accelerations"):
        qp.solve(problem._replace(lower=lower), solver)


def test_a_row_of_zeros_is_ignored_if_its_bounds_allow_zero(solver):
    problem = random_program(4, tight=0.3)
    G, lower, upper = problem.G.copy(), problem.lower.copy(), problem.upper.copy()
    G[2], lower[9], upper[9] = 0.0, -1.0, 0.0
    solution = qp.solve(problem._replace(G=G, lower=lower, upper=upper), solver)
    lower[9], upper[9] = -np.inf, np.inf
    np.testing.assert_allclose(solution.x, least_distance(problem._replace(lower=lower, upper=upper)), atol=EXACT)
    lower[9], upper[9] = 1.0, 2.0
    with pytest.raises(SolverError):
        qp.solve(problem._replace(G=G, lower=lower, upper=upper), solver)


@pytest.mark.parametrize("rows", [[0], [8], [0, 8], [7, 8, 9], range(7)])
def test_equal_bounds_are_an_equation(solver, rows):
    problem = random_program(4, tight=0.3)
    x = least_distance(problem)
    values = np.concatenate((x, problem.G @ x))
    lower, upper = problem.lower.copy(), problem.upper.copy()
    # A point within all bounds, so that the equations contradict none of the others.
    target = 0.9 * values + 0.05 * (lower + upper)
    target[7:] = problem.G @ target[:7]
    lower, upper = np.minimum(lower, target - 0.01), np.maximum(upper, target + 0.01)
    lower[list(rows)] = upper[list(rows)] = target[list(rows)]
    equal = problem._replace(lower=lower, upper=upper)
    solution = qp.solve(equal, solver)
    assert not solution.relaxed
    guess = np.where(lower == upper, 1.0, np.where(solution.slack[0] < 1e-7, 1.0, -1.0 * (solution.slack[1] < 1e-7)))
    np.testing.assert_allclose(solution.x, qp_programs.exact_optimum(equal, guess)[0].astype(float), atol=EXACT)
    np.testing.assert_allclose(np.concatenate((solution.x, problem.G @ solution.x))[list(rows)], target[list(rows)])


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e3, 1e6, 1e9])
def test_the_optimum_does_not_depend_on_the_units(solver, factor):
    """The units of accelerations, costs or some rows are up to 1e9 larger or smaller."""
    for seed in range(4, 8):
        problem = random_program(seed, tight=0.3)
        x = least_distance(problem)
        units = np.concatenate((np.ones(7), np.where(np.arange(7) % 2, factor, 1.0)))
        others = (
            problem._replace(f=factor * problem.f, lower=factor * problem.lower, upper=factor * problem.upper),
            problem._replace(H=factor * problem.H, f=factor * problem.f),
            problem._replace(G=units[7:, None] * problem.G, lower=units * problem.lower, upper=units * problem.upper),
        )
        for other, unit in zip(others, (factor, 1.0, 1.0), strict=True):
            np.testing.assert_allclose(solver.solve(other) / unit, x, atol=EXACT * np.abs(x).max())


def test_an_indefinite_or_infeasible_program_has_no_least_distance_form():
    problem = random_program(0)
    assert LeastDistanceProgram.from_problem(problem._replace(H=-problem.H)) is None
    assert LeastDistanceProgram.from_problem(problem._replace(lower=problem.upper + 1.0)) is None


def test_crossed_bounds_on_the_rows_are_an_error(solver):
    problem = random_program(0)
    upper = problem.upper.copy()
    upper[-1] = problem.lower[-1] - 1.0
    with pytest.raises(SolverError):
        qp.solve(problem._replace(upper=upper), solver)


def test_an_unknown_solver_is_named_with_the_known_ones():
    with pytest.raises(ConfigurationError, match="no solver 'gurobi'; the solvers are daqp, osqp, proxqp, quadprog"):
        make_solver("gurobi")


@pytest.mark.parametrize("name", qp_programs.OPTIONAL)
def test_the_error_for_a_missing_package_says_how_to_install_it(name, monkeypatch):
    monkeypatch.setitem(sys.modules, qp_programs.OPTIONAL[name], None)
    monkeypatch.delitem(sys.modules, f"pilegrasp_ctrl.qp.{name}_solver", raising=False)
    with pytest.raises(ConfigurationError, match=rf"pip install 'pilegrasp\[{name}\]'$") as caught:
        OperationalSpaceController(load("panda"), solver=name)
    assert "\n" not in str(caught.value)


def test_a_scenario_may_name_every_solver():
    assert get_args(ControllerConfig.model_fields["solver"].annotation) == qp.SOLVERS


def test_osqp_prints_nothing_to_standard_output(capfd):
    solver = make_solver("osqp")
    for seed in range(3):
        qp.solve(random_program(seed, tight=10.0), solver)
    assert capfd.readouterr().out == ""
