"""Any rows may be soft: where no answer is within all bounds, those alone give way, by as little as they must."""

import numpy as np
import pytest

import qp_programs
from pilegrasp_ctrl.exceptions import ArgumentError, SolverError
from pilegrasp_ctrl.qp.program import FEASIBILITY, SOFT_WEIGHT, QuadraticProgram, make_solver, solve
from random_programs import contradiction, least_distance, random_program


@pytest.fixture(params=qp_programs.SOLVERS)
def solver(request):
    return qp_programs.installed(request.param)


def rows(*soft: int) -> np.ndarray:
    return np.isin(np.arange(14), soft)


BOUNDS_ON_X = np.arange(14) < 7


def values(program: QuadraticProgram, x: np.ndarray) -> np.ndarray:
    return np.concatenate((x, program.G @ x))


def test_the_bounds_on_x_are_soft_unless_something_else_is_said(solver):
    assert_same(solve(contradiction(), solver), solve(contradiction(), solver, BOUNDS_ON_X))


def assert_same(solution, other):
    assert solution.relaxed
    assert other.relaxed
    np.testing.assert_array_equal(solution.x, other.x)


def test_soft_rows_of_g_give_way_and_bounds_on_x_hold(solver):
    program = contradiction()
    solution = solve(program, solver, ~BOUNDS_ON_X)
    assert solution.relaxed
    assert (solution.slack[:, :7] >= -FEASIBILITY).all()
    assert solution.slack[:, 7:].min() < -0.1
    np.testing.assert_allclose(solution.x, least_distance(program.softened(~BOUNDS_ON_X))[:7], atol=1e-6)


def test_only_the_rows_that_are_said_to_be_soft_give_way(solver):
    """Two bounds that contradict each other: the one on x or the one on G x gives way."""
    program = random_program(5, tight=10.0)
    lower, upper = program.lower.copy(), program.upper.copy()
    G = program.G.copy()
    G[2] = np.eye(7)[3]
    lower[3], upper[3], lower[9], upper[9] = 1.0, 2.0, -2.0, -1.0
    program = program._replace(G=G, lower=lower, upper=upper)
    for soft, hard in ((3, 9), (9, 3)):
        solution = solve(program, solver, rows(soft))
        assert solution.slack[:, soft].min() < -1.9
        assert solution.slack[:, np.arange(14) != soft].min() >= -FEASIBILITY
        assert abs(solution.slack[:, hard]).min() < 1e-3
    both = solve(program, solver, rows(3, 9))
    np.testing.assert_allclose(both.slack.min(axis=0)[[3, 9]], -1.0, atol=1e-3)


def test_rows_that_do_not_contradict_are_kept_even_if_they_are_soft(solver):
    program = random_program(4, tight=0.3)
    solution = solve(program, solver, np.ones(14, dtype=bool))
    assert not solution.relaxed
    np.testing.assert_array_equal(solution.x, solver.solve(program))


def test_hard_rows_that_contradict_are_an_error_whatever_is_soft(solver):
    program = contradiction()
    for soft in (np.zeros(14, dtype=bool), rows(0)):
        with pytest.raises(SolverError, match=f"{solver.name} found no accelerations within the hard limits"):
            solve(program, solver, soft)


def test_if_every_row_is_soft_there_is_always_an_answer(solver):
    solution = solve(contradiction(), solver, np.ones(14, dtype=bool))
    np.testing.assert_allclose(
        solution.x, least_distance(contradiction().softened(np.ones(14, dtype=bool)))[:7], atol=1e-6
    )


def test_a_larger_weight_leaves_a_smaller_excess_and_approaches_the_least_one(solver):
    """A demand of the cost stretches soft bounds beyond what the hard rows make necessary."""
    excess = []
    for weight in (1e1, 1e3, SOFT_WEIGHT, 1e6):
        solution = solve(contradiction(), solver, soft_weight=weight)
        assert solution.soft_weight == weight
        excess.append(np.linalg.norm(np.maximum(-solution.slack[:, :7], 0.0)))
    # Beyond the least excess, rounding decides the order.
    assert (np.diff(excess) < 1e-12).all()
    assert excess[0] > 1.001 * excess[-1]
    assert excess[2] < 1.001 * excess[3]


def test_only_soft_rows_with_a_bound_get_a_slack():
    program = contradiction()
    lower, upper = program.lower.copy(), program.upper.copy()
    lower[[0, 8]], upper[[0, 8]] = -np.inf, np.inf
    upper[1] = np.inf
    program = program._replace(lower=lower, upper=upper)
    softened = program.softened(rows(0, 1, 8, 9), 5.0)
    n = len(softened.f)
    assert n == 7 + 2
    np.testing.assert_array_equal(np.diag(softened.H)[7:], 5.0)
    np.testing.assert_array_equal(softened.G[:, 7:], np.eye(14)[:, [1, 9]])
    np.testing.assert_array_equal(softened.G[:, :7], np.vstack((np.eye(7), program.G)))
    np.testing.assert_array_equal(softened.lower, [*[-np.inf] * n, *lower])
    np.testing.assert_array_equal(softened.upper, [*[np.inf] * n, *upper])


def test_a_softened_program_has_the_excess_behind_x(solver):
    program, soft = contradiction(), rows(1, 2, 3, 8)
    soft[:7] = True
    answer = solver.solve(program.softened(soft))
    relaxed = values(program, answer[:7])
    relaxed[soft] += answer[7:]
    assert (relaxed >= program.lower - 1e-8).all()
    assert (relaxed <= program.upper + 1e-8).all()


def test_a_program_without_rows_of_g_is_relaxed_as_others_are(solver):
    program = random_program(0)._replace(G=np.zeros((0, 7)))
    lower, upper = program.lower[:7], program.upper[:7]
    program = program._replace(lower=lower, upper=upper)
    np.testing.assert_allclose(solve(program, solver).x, least_distance(program), atol=1e-8)
    crossed = program._replace(lower=upper + 1.0, upper=lower)
    with pytest.raises(SolverError, match=r"row 0 .* lower bound above its upper bound"):
        solve(crossed, solver)


@pytest.mark.parametrize("soft", [np.ones(13, dtype=bool), np.arange(14), [0, 1], 3])
def test_a_mask_that_does_not_fit_is_refused(soft):
    with pytest.raises(ArgumentError, match="soft must be 14 booleans, one for each row"):
        solve(random_program(0), make_solver("daqp"), soft)


@pytest.mark.parametrize("weight", [0.0, -1.0, np.nan, np.inf])
def test_a_weight_that_is_not_positive_is_refused(weight):
    with pytest.raises(ArgumentError, match=r"soft_weight = .* must be a positive number"):
        solve(random_program(0), make_solver("daqp"), soft_weight=weight)


def test_a_program_whose_arrays_do_not_fit_together_is_refused():
    program = random_program(0)
    for wrong in (
        {"G": program.G[:, :6]},
        {"lower": program.lower[:7]},
        {"upper": program.upper[1:]},
        {"H": np.eye(6)},
    ):
        with pytest.raises(ArgumentError, match="arrays do not fit together: H "):
            solve(program._replace(**wrong), make_solver("daqp"))
