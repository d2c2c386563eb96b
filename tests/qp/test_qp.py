"""Every solver finds the optimum within all bounds, and an answer counts only if its residuals are small."""

import numpy as np
import pytest

import qp_programs
from pilegrasp_ctrl.exceptions import SolverError
from pilegrasp_ctrl.qp import program as qp
from pilegrasp_ctrl.qp.least_distance import LeastDistanceProgram
from random_programs import contradiction, least_distance, random_program

EXACT = 1e-9


@pytest.fixture(params=qp_programs.SOLVERS)
def solver(request):
    return qp_programs.installed(request.param)


@pytest.mark.parametrize("tight", [0.3, 1.0, 10.0])
def test_the_optimum_is_found_and_every_bound_held(solver, tight):
    active = 0
    for seed in range(30):
        program = random_program(seed, tight=tight)
        solution = qp.solve(program, solver)
        assert not solution.relaxed
        assert solution.margin >= -qp.FEASIBILITY
        np.testing.assert_allclose(solution.x, least_distance(program), atol=EXACT)
        active += solution.margin < 1e-6
    assert active > 0


def test_without_bounds_the_answer_is_the_minimum(solver):
    program = random_program(1)._replace(lower=np.full(14, -np.inf), upper=np.full(14, np.inf))
    solution = qp.solve(program, solver)
    np.testing.assert_allclose(solution.x, np.linalg.solve(program.H, -program.f), atol=1e-6)
    assert solution.margin == np.inf


def test_if_bounds_contradict_the_rows_the_bounds_are_softened_and_the_rows_hold(solver):
    program = contradiction()
    n = len(program.f)
    solution = qp.solve(program, solver)
    assert solution.relaxed
    assert solution.margin < -0.1
    assert (solution.slack[:, n:] >= -qp.FEASIBILITY).all()


def test_softened_bounds_are_exceeded_by_a_least_squares_amount(solver):
    program = contradiction()
    np.testing.assert_allclose(qp.solve(program, solver).x, least_distance(program.softened())[:7], atol=1e-6)


def test_a_feasible_program_is_not_softened(solver):
    program = random_program(4, tight=0.3)
    np.testing.assert_allclose(qp.solve(program, solver).x, least_distance(program), atol=EXACT)
    soft = least_distance(program.softened())[:7]
    assert np.abs(soft - least_distance(program)).max() > 1e-6


@pytest.mark.parametrize(
    ("field", "value"),
    [("H", np.nan), ("f", np.nan), ("G", np.nan), ("lower", np.nan), ("H", np.inf), ("f", np.inf), ("G", -np.inf)],
)
def test_a_program_that_is_not_finite_is_an_error_and_names_its_part(solver, field, value):
    program = random_program(0)
    bad = getattr(program, field).copy()
    bad.flat[3] = value
    with pytest.raises(SolverError, match="bounds" if field == "lower" else f"program's {field} "):
        qp.solve(program._replace(**{field: bad}), solver)


@pytest.mark.parametrize("row", [3, 9])
@pytest.mark.parametrize("bound", [np.inf, 1e3])
def test_a_lower_bound_above_the_upper_one_is_an_error(solver, row, bound):
    program = random_program(0)
    lower = program.lower.copy()
    lower[row] = bound
    sentence = "infinity that no value can meet" if bound == np.inf else f"row {row} .* lower bound above its upper"
    with pytest.raises(SolverError, match=sentence):
        qp.solve(program._replace(lower=lower), solver)


def test_a_row_of_zeros_is_ignored_if_its_bounds_allow_zero(solver):
    program = random_program(4, tight=0.3)
    G, lower, upper = program.G.copy(), program.lower.copy(), program.upper.copy()
    G[2], lower[9], upper[9] = 0.0, -1.0, 0.0
    solution = qp.solve(program._replace(G=G, lower=lower, upper=upper), solver)
    lower[9], upper[9] = -np.inf, np.inf
    np.testing.assert_allclose(solution.x, least_distance(program._replace(lower=lower, upper=upper)), atol=EXACT)
    lower[9], upper[9] = 1.0, 2.0
    with pytest.raises(SolverError):
        qp.solve(program._replace(G=G, lower=lower, upper=upper), solver)


@pytest.mark.parametrize("rows", [[0], [8], [0, 8], [7, 8, 9], range(7)])
def test_equal_bounds_are_an_equation(solver, rows):
    program = random_program(4, tight=0.3)
    x = least_distance(program)
    values = np.concatenate((x, program.G @ x))
    lower, upper = program.lower.copy(), program.upper.copy()
    # A point within all bounds, so that the equations contradict none of the others.
    target = 0.9 * values + 0.05 * (lower + upper)
    target[7:] = program.G @ target[:7]
    lower, upper = np.minimum(lower, target - 0.01), np.maximum(upper, target + 0.01)
    lower[list(rows)] = upper[list(rows)] = target[list(rows)]
    equal = program._replace(lower=lower, upper=upper)
    solution = qp.solve(equal, solver)
    assert not solution.relaxed
    guess = np.where(lower == upper, 1.0, np.where(solution.slack[0] < 1e-7, 1.0, -1.0 * (solution.slack[1] < 1e-7)))
    np.testing.assert_allclose(solution.x, qp_programs.exact_optimum(equal, guess)[0].astype(float), atol=EXACT)
    np.testing.assert_allclose(np.concatenate((solution.x, program.G @ solution.x))[list(rows)], target[list(rows)])


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e3, 1e6, 1e9])
def test_the_optimum_does_not_depend_on_the_units(solver, factor):
    """The units of accelerations, costs or some rows are up to 1e9 larger or smaller."""
    for seed in range(4, 8):
        program = random_program(seed, tight=0.3)
        x = least_distance(program)
        units = np.concatenate((np.ones(7), np.where(np.arange(7) % 2, factor, 1.0)))
        others = (
            program._replace(f=factor * program.f, lower=factor * program.lower, upper=factor * program.upper),
            program._replace(H=factor * program.H, f=factor * program.f),
            program._replace(G=units[7:, None] * program.G, lower=units * program.lower, upper=units * program.upper),
        )
        for other, unit in zip(others, (factor, 1.0, 1.0), strict=True):
            np.testing.assert_allclose(solver.solve(other) / unit, x, atol=EXACT * np.abs(x).max())


def test_an_indefinite_or_infeasible_program_has_no_least_distance_form():
    program = random_program(0)
    assert LeastDistanceProgram.from_program(program._replace(H=-program.H)) is None
    assert LeastDistanceProgram.from_program(program._replace(lower=program.upper + 1.0)) is None


def test_crossed_bounds_on_the_rows_are_an_error(solver):
    program = random_program(0)
    upper = program.upper.copy()
    upper[-1] = program.lower[-1] - 1.0
    with pytest.raises(SolverError):
        qp.solve(program._replace(upper=upper), solver)
