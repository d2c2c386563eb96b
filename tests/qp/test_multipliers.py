"""The multipliers of a checked answer meet the optimality conditions, whatever solver found it."""

import numpy as np
import pytest

import qp_programs
from pilegrasp_ctrl.qp.multipliers import multipliers
from pilegrasp_ctrl.qp.program import FEASIBILITY, QuadraticProgram, Solution, make_solver, solve
from random_programs import contradiction, least_distance, random_program

PROGRAMS = qp_programs.recorded()


@pytest.fixture(params=qp_programs.SOLVERS)
def solver(request):
    return qp_programs.installed(request.param)


def assert_optimal(program: QuadraticProgram, solution: Solution, found: np.ndarray, tolerance: float = 1e-6) -> None:
    """Assert stationarity, relative to its terms, and that every multiplier has the sign of an active bound."""
    H, f, G, *_ = program
    n = len(f)
    residual = H @ solution.x + f - found[:n] - G.T @ found[n:]
    terms = np.abs(H) @ np.abs(solution.x) + np.abs(f) + np.abs(found[:n]) + np.abs(G.T) @ np.abs(found[n:])
    assert (np.abs(residual) <= tolerance * terms.max()).all()
    below, above = solution.slack <= FEASIBILITY
    assert below[found > 0.0].all()
    assert above[found < 0.0].all()


@pytest.mark.parametrize("kind", sorted({program.kind for program in PROGRAMS}))
def test_the_multipliers_of_recorded_programs_are_the_proved_ones(solver, kind):
    for program in (program for program in PROGRAMS if program.kind == kind):
        solution = solve(program.problem, solver)
        found = multipliers(program.problem, solution)
        assert_optimal(program.problem, solution, found)
        size = np.abs(program.multipliers).max()
        np.testing.assert_allclose(found, program.multipliers, atol=1e-6 * size, rtol=0.0)


def test_some_recorded_programs_have_active_bounds_on_both_sides_of_both_kinds_of_rows():
    signs = {(row < 7, np.sign(value)) for program in PROGRAMS for row, value in enumerate(program.multipliers)}
    assert {(kind, sign) for kind in (True, False) for sign in (-1.0, 1.0)} <= signs


def test_a_multiplier_is_the_rate_at_which_the_cost_falls_when_its_bound_moves_outwards():
    program, solver = random_program(4, tight=0.3), make_solver("daqp")

    def cost(program):
        x = solve(program, solver).x
        return 0.5 * x @ program.H @ x + program.f @ x

    found = multipliers(program, solve(program, solver))
    step, active = 1e-5, np.flatnonzero(found)
    assert len(active) > 1
    assert (np.sign(found[active]) == 1.0).any()
    assert (np.sign(found[active]) == -1.0).any()
    for row in active:
        moved = {"lower": program.lower.copy(), "upper": program.upper.copy()}
        moved["lower" if found[row] > 0.0 else "upper"][row] -= np.sign(found[row]) * step
        fall = cost(program) - cost(program._replace(**moved))
        np.testing.assert_allclose(fall / step, abs(found[row]), rtol=1e-2)


def test_without_an_active_bound_all_multipliers_are_zero(solver):
    free = random_program(0)._replace(lower=np.full(14, -np.inf), upper=np.full(14, np.inf))
    assert not multipliers(free, solve(free, solver)).any()


def test_active_bounds_that_depend_on_each_other_have_multipliers_too(solver):
    """Twice the same row, a row of zeros at its bound, and more active bounds than variables."""
    for seed in range(4, 10):
        program = random_program(seed, tight=0.3)
        x = least_distance(program)
        rng = np.random.default_rng(seed)
        extra = rng.normal(size=(9, 7))
        extra[7], extra[8] = program.G[0], 0.0
        program = program._replace(
            G=np.vstack((program.G, extra)),
            lower=np.concatenate((program.lower, extra[:7] @ x, program.lower[7:8], [0.0])),
            upper=np.concatenate((program.upper, np.full(7, np.inf), program.upper[7:8], [0.0])),
        )
        solution = solve(program, solver)
        np.testing.assert_allclose(solution.x, x, atol=1e-7)
        assert (solution.slack <= FEASIBILITY).sum() > 7
        assert_optimal(program, solution, multipliers(program, solution))


def test_an_equation_has_a_multiplier_of_either_sign(solver):
    program = random_program(4)
    x = np.linalg.solve(program.H, -program.f)
    signs = set()
    for offset in (-0.1, 0.1):
        lower, upper = np.full(14, -np.inf), np.full(14, np.inf)
        lower[2] = upper[2] = x[2] + offset
        equal = program._replace(lower=lower, upper=upper)
        solution = solve(equal, solver)
        found = multipliers(equal, solution)
        assert_optimal(equal, solution, found)
        signs.add(np.sign(found[2]))
    assert signs == {-1.0, 1.0}


@pytest.mark.parametrize("soft", [None, np.arange(14) >= 7, np.ones(14, dtype=bool)])
@pytest.mark.parametrize("weight", [1e2, 1e4])
def test_the_multiplier_of_a_soft_row_is_its_excess_times_the_weight(solver, soft, weight):
    program = contradiction()
    solution = solve(program, solver, soft, weight)
    assert solution.relaxed
    found = multipliers(program, solution)
    assert_optimal(program, solution, found)
    excess = np.maximum(-solution.slack[0], 0.0) - np.maximum(-solution.slack[1], 0.0)
    soft = np.arange(14) < 7 if soft is None else soft
    assert np.abs(excess[soft]).max() > 1e-2
    np.testing.assert_allclose(found[soft], weight * excess[soft], rtol=1e-6, atol=1e-3)


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e3, 1e6])
def test_multipliers_do_not_depend_on_the_unit_of_the_cost(factor):
    program, solver = random_program(4, tight=0.3), make_solver("daqp")
    found = multipliers(program, solve(program, solver))
    scaled = program._replace(H=factor * program.H, f=factor * program.f)
    size = np.abs(found).max()
    np.testing.assert_allclose(multipliers(scaled, solve(scaled, solver)) / factor, found, atol=1e-8 * size)


def test_a_bound_near_the_answer_but_not_on_it_has_no_multiplier():
    program, solver = random_program(4, tight=0.3), make_solver("daqp")
    x = solve(program, solver).x
    lower = program.lower.copy()
    row = int(np.argmax(np.minimum(x - program.lower[:7], program.upper[:7] - x)))
    lower[row] = x[row] - 0.1 * FEASIBILITY
    near = program._replace(lower=lower)
    found = multipliers(near, solve(near, solver))
    assert abs(found[row]) < 1e-9 * np.abs(found).max()
