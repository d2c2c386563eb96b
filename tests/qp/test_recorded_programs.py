"""Every solver finds the proved optima of programs that closed loops recorded."""

import os
import subprocess
import sys
from itertools import islice

import numpy as np
import pytest

import qp_programs
from arms import ARMS, HOME, load, simulate, without_friction
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.qp import least_distance
from pilegrasp_ctrl.qp import program as qp
from pilegrasp_ctrl.qp.least_distance import LeastDistanceProgram
from pilegrasp_ctrl.qp.program import QuadraticProgram, make_solver
from pilegrasp_ctrl.trajectories.straight_line import StraightLine
from places import ROOT

KINDS = ("nominal", "torque", "velocity", "position", "infeasible", "stretched", "wrist", "weight")
PROGRAMS = qp_programs.recorded()


@pytest.fixture(params=qp_programs.SOLVERS)
def solver(request):
    return qp_programs.installed(request.param)


def of_kind(kind: str):
    return [program for program in PROGRAMS if program.kind == kind]


def accuracy(problem: QuadraticProgram) -> float:
    """Return the accuracy of a backward stable method: 100 round-offs of the optimum's sensitivity, at most 1e-6."""
    return min(1e-6, 100.0 * np.finfo(float).eps * np.linalg.cond(problem.H))


@pytest.mark.parametrize("kind", KINDS)
def test_every_recorded_program_is_solved_exactly_and_softened_only_where_it_must_be(solver, kind):
    for program in of_kind(kind):
        solution = qp.solve(program.problem, solver)
        assert solution.relaxed == (not program.feasible)
        problem = program.problem if program.feasible else program.problem.softened()
        size = np.abs(program.x).max()
        np.testing.assert_allclose(solution.x, program.x, rtol=0.0, atol=accuracy(problem) * size)
        np.testing.assert_allclose(program.problem.G @ (solution.x - program.x), 0.0, atol=1e-8)
        values = np.concatenate((solution.x, program.problem.G @ solution.x))
        hard = slice(0 if program.feasible else 7, None)
        excess = np.maximum(program.problem.lower - values, values - program.problem.upper)[hard]
        assert excess.max() <= 1e-9
        np.testing.assert_allclose(solution.slack.min(axis=0)[hard], -excess, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_a_solver_reports_that_there_is_no_solution(solver, kind):
    for program in of_kind(kind):
        assert (solver.solve(program.problem) is None) == (kind == "infeasible")


def test_the_excess_of_softened_bounds_is_the_smallest_in_least_squares(solver):
    for program in of_kind("infeasible"):
        slack = solver.solve(program.problem.softened())[7:]
        np.testing.assert_allclose(slack, program.excess, atol=1e-8 * np.abs(program.excess).max())


def test_the_recorded_answers_are_proved_without_rounding():
    for program in PROGRAMS:
        problem, x, multipliers = program.problem, program.x, program.multipliers
        if not program.feasible:
            assert qp_programs.gap_of(program.certificate, problem) > qp_programs.CLEARLY
            problem, x = problem.softened(), np.concatenate((x, program.excess))
            multipliers = np.concatenate((np.zeros(14), multipliers))
        assert qp_programs.positive_definite(problem.H)
        assert qp_programs.kkt_residual(problem, x, multipliers) < 1e-12, "run `python tests/helpers/qp_programs.py`"


def test_the_proof_fails_for_a_wrong_answer():
    program = of_kind("torque")[0]
    shifted = program.x + 1e-9 * np.abs(program.x).max()
    assert qp_programs.kkt_residual(program.problem, shifted, program.multipliers) > 1e-11
    assert qp_programs.kkt_residual(program.problem, program.x, -program.multipliers) > 1e-3
    assert qp_programs.gap_of(of_kind("infeasible")[0].certificate, program.problem) < 0


def test_the_exact_answer_does_not_depend_on_the_guess_of_the_active_set():
    for program in (of_kind("torque")[0], of_kind("velocity")[-1], of_kind("position")[0]):
        x, multipliers = qp_programs.exact_optimum(program.problem, np.zeros(14))
        np.testing.assert_array_equal(x.astype(float), program.x)
        np.testing.assert_array_equal(multipliers.astype(float), program.multipliers)


def test_the_recorded_programs_have_the_properties_in_their_names():
    assert {(program.arm, program.kind) for program in PROGRAMS} == {(arm, kind) for arm in ARMS for kind in KINDS}
    assert all(len(of_kind(kind)) == 2 * qp_programs.COUNT for kind in KINDS)
    for program in PROGRAMS:
        bound, torque = program.multipliers[:7].any(), program.multipliers[7:].any()
        assert program.feasible == (program.kind != "infeasible")
        assert {"nominal": not bound and not torque, "torque": torque, "velocity": bound, "position": bound}.get(
            program.kind, True
        )
    assert min(np.linalg.cond(program.problem.H) for program in of_kind("weight")) > 1e8
    assert any(not np.allclose(program.problem.G, program.problem.G.T) for program in PROGRAMS)


def test_answers_are_the_same_bits_regardless_of_earlier_programs(solver):
    problems = [program.problem for program in PROGRAMS[::3]]
    problems += [program.problem.softened() for program in of_kind("infeasible")]
    first = [solver.solve(problem) for problem in problems]
    rng, kept = np.random.default_rng(0), []
    for _ in range(2):
        # Extra memory and copied arrays change the addresses that the packages allocate.
        kept += [np.zeros(size) for size in rng.integers(1, 64, 200)]
        other = make_solver(solver.name)
        for index in rng.permutation(len(problems)):
            again = other.solve(QuadraticProgram(*(array.copy() for array in problems[index])))
            assert (again is None) == (first[index] is None)
            assert again is None or np.array_equal(again, first[index])


def test_any_guess_of_the_active_set_leads_to_the_same_bits():
    rng = np.random.default_rng(0)
    for program in PROGRAMS[::3]:
        distance = LeastDistanceProgram.from_program(program.problem)
        k = len(distance.rows)
        guesses = [np.zeros(k), np.ones(k), -np.ones(k), *rng.normal(size=(3, k))]
        answers = [distance.nearest(guess) for guess in guesses]
        if not program.feasible:
            assert answers == [None] * len(guesses)
            continue
        assert all(np.array_equal(answer, answers[0]) for answer in answers)
        size = np.abs(program.x).max()
        np.testing.assert_allclose(distance.x(answers[0]), program.x, atol=accuracy(program.problem) * size)


def test_a_guess_of_a_bound_that_is_not_there_does_no_harm():
    program = of_kind("torque")[0]
    lower = np.where(program.multipliers > 0.0, program.problem.lower, -np.inf)
    upper = np.where(program.multipliers < 0.0, program.problem.upper, np.inf)
    distance = LeastDistanceProgram.from_program(program.problem._replace(lower=lower, upper=upper))
    for guess in (np.ones(len(distance.rows)), -np.ones(len(distance.rows))):
        np.testing.assert_allclose(distance.x(distance.nearest(guess)), program.x, atol=1e-8)


@pytest.mark.parametrize("name", ARMS)
def test_every_solver_drives_a_pushed_arm_in_the_same_way(solver, name):
    """Pushes overpower weak drives, so programs of every kind occur; every period has an answer."""
    true = load(name)
    arm = without_friction(name, torque_limit=0.3 * true.torque_limit, velocity_limit=0.3 * true.velocity_limit)
    push = 0.3 * true.torque_limit * np.array([1.0, -1.0, 1.0, 1.0, -1.0, 1.0, -1.0])
    ends = {}
    for other in ("daqp", solver.name):
        controller = OperationalSpaceController(arm, posture=HOME[name], solver=other)
        line = StraightLine(arm.update(HOME[name], np.zeros(7)).pose, [0.0, 0.1, 0.05], 0.5)

        def step(observation, controller=controller, line=line):
            output = controller.step(observation, line.at(observation.time))
            assert output.fallback == ""
            assert (np.abs(output.command.torque) <= arm.torque_limit).all()
            return output.command.torque

        *_, last = islice(simulate(arm, step, HOME[name], 1.0, external=lambda q, v: push), 60)
        ends[other] = last
    np.testing.assert_allclose(ends[solver.name][1], ends["daqp"][1], atol=1e-7)
    np.testing.assert_allclose(ends[solver.name][3], ends["daqp"][3], atol=1e-5)


@pytest.mark.parametrize("name", ["osqp", "proxqp"])
def test_a_package_nearly_finds_the_active_set(name, monkeypatch):
    """The exact method takes few steps from that guess or none; without a guess it takes many."""
    solver, steps = qp_programs.installed(name), []
    nearest = least_distance.nearest_point
    monkeypatch.setattr(least_distance, "nearest_point", lambda *given: steps.append(nearest(*given)) or steps[-1])
    feasible = [program.problem for program in PROGRAMS if program.feasible]
    for program in feasible:
        solver.solve(program)
    assert len(steps) == len(feasible)
    assert sum(steps) <= 5
    steps.clear()
    for program in feasible:
        distance = LeastDistanceProgram.from_program(program)
        distance.nearest(np.zeros(len(distance.rows)))
    assert sum(steps) > 150


ANSWERS = """
import hashlib
import qp_programs
from pilegrasp_ctrl.qp.program import solve
digest = hashlib.sha256()
for name in ("daqp", "osqp"):
    for program in qp_programs.recorded()[::4]:
        solution = solve(program.problem, qp_programs.installed(name))
        digest.update(solution.x.tobytes() + solution.slack.tobytes())
print(digest.hexdigest())
"""


def test_answers_are_the_same_bits_on_other_processors_and_without_compilation():
    """numpy's matrix products take other instructions, and so round otherwise, for each of these processors."""
    paths = os.pathsep.join(map(str, (ROOT, ROOT / "tests" / "helpers", ROOT / "docs" / "studies")))
    digests = set()
    for change in ({"OPENBLAS_CORETYPE": "Haswell"}, {"OPENBLAS_CORETYPE": "Nehalem"}, {"NUMBA_DISABLE_JIT": "1"}):
        environment = os.environ | {"PYTHONPATH": paths} | change
        command = [sys.executable, "-c", ANSWERS]
        digests.add(subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout)
    assert len(digests) == 1
