"""The program that `as_problem` gives to qpsolvers has the same answer."""

import subprocess
import sys

import numpy as np
import pytest
import qpsolvers

import qp_programs
from pilegrasp_ctrl.qp.problem import as_problem
from pilegrasp_ctrl.qp.program import make_solver, solve
from random_programs import contradiction, least_distance, random_program

PROGRAMS = [program for program in qp_programs.recorded() if program.feasible and program.kind != "weight"]


@pytest.mark.parametrize("name", ["daqp", "quadprog"])
def test_qpsolvers_finds_the_same_answer(name):
    qp_programs.installed(name)
    for program in PROGRAMS[::3]:
        x = qpsolvers.solve_problem(as_problem(program.problem), name).x
        np.testing.assert_allclose(x, program.x, atol=1e-6 * np.abs(program.x).max())
    softened = contradiction().softened()
    found = qpsolvers.solve_problem(as_problem(softened), name).x
    np.testing.assert_allclose(found, make_solver("daqp").solve(softened), atol=1e-6)


def test_qpsolvers_confirms_that_residuals_and_duality_gap_vanish():
    program = random_program(3)
    reference = qpsolvers.solve_problem(as_problem(program), "daqp")
    assert max(reference.primal_residual(), reference.dual_residual(), abs(reference.duality_gap())) < 1e-6
    np.testing.assert_allclose(solve(program, make_solver("daqp")).x, reference.x, atol=1e-9)


def test_two_sided_rows_become_one_sided_and_equal_bounds_equations():
    program = random_program(4, tight=10.0)
    lower, upper = program.lower.copy(), program.upper.copy()
    upper[0], lower[1], lower[9], upper[10] = np.inf, -np.inf, -np.inf, np.inf
    lower[[11, 12]], upper[[11, 12]] = -np.inf, np.inf
    x = np.linalg.solve(program.H, -program.f)
    lower[2] = upper[2] = x[2]
    lower[13] = upper[13] = program.G[6] @ x
    program = program._replace(lower=lower, upper=upper)
    problem = as_problem(program)
    above, below = [0, 1, 2], [0, 1, 3]
    np.testing.assert_array_equal(problem.G, np.vstack((program.G[above], -program.G[below])))
    np.testing.assert_array_equal(problem.h, [*upper[[7, 8, 9]], *-lower[[7, 8, 10]]])
    np.testing.assert_array_equal(problem.A, [np.eye(7)[2], program.G[6]])
    np.testing.assert_array_equal(problem.b, lower[[2, 13]])
    free = np.arange(7) == 2
    np.testing.assert_array_equal(problem.lb, np.where(free, -np.inf, lower[:7]))
    np.testing.assert_array_equal(problem.ub, np.where(free, np.inf, upper[:7]))
    found = qpsolvers.solve_problem(problem, "daqp").x
    np.testing.assert_allclose(found, solve(program, make_solver("daqp")).x, atol=1e-6)


def test_what_a_program_does_not_have_is_none():
    free = random_program(0)._replace(lower=np.full(14, -np.inf), upper=np.full(14, np.inf))
    problem = as_problem(free)
    assert [problem.G, problem.h, problem.A, problem.b, problem.lb, problem.ub] == [None] * 6
    np.testing.assert_array_equal(problem.P, free.H)
    np.testing.assert_array_equal(problem.q, free.f)
    above = as_problem(free._replace(upper=np.r_[np.full(7, np.inf), np.ones(7)]))
    assert above.lb is None
    assert above.ub is None
    assert above.G.shape == (7, 7)


def test_the_problem_does_not_change_with_the_program():
    program = random_program(0)
    problem = as_problem(program)
    for array in program:
        array[:] = 0.0
    x = qpsolvers.solve_problem(problem, "daqp").x
    np.testing.assert_allclose(x, least_distance(random_program(0)), atol=1e-6)


def test_qpsolvers_is_loaded_only_when_it_is_asked_for():
    code = (
        "import sys; import pilegrasp_ctrl.qp.problem; from pilegrasp_ctrl.qp.program import make_solver\n"
        "make_solver('daqp'); make_solver('osqp'); assert 'qpsolvers' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
