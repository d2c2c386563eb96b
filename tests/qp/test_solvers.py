"""A solver is chosen by name or given as an object; its faults end in one sentence, and it never remembers."""

import copy
import pickle
import sys
import threading
import warnings
from typing import get_args

import daqp
import numpy as np
import pytest
import qpsolvers

import qp_programs
from arms import HOME, load
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.exceptions import ConfigurationError, SolverError
from pilegrasp_ctrl.provenance import SOLVER_PACKAGES
from pilegrasp_ctrl.qp import qpsolvers_solver
from pilegrasp_ctrl.qp.program import QuadraticProgram, make_solver, solve
from pilegrasp_ctrl.qp.qpsolvers_solver import QpsolversSolver
from pilegrasp_ctrl.qp.quiet import without_warnings
from pilegrasp_ctrl.qp.solvers import solver_name
from pilegrasp_ctrl.sections import ControllerConfig
from pilegrasp_ctrl.trajectories.straight_line import StraightLine
from pilegrasp_ctrl.types import Observation
from random_programs import contradiction, least_distance, random_program


class ExactSolver:
    """A user's solver: the optimum by an independent algorithm, from copies that it destroys."""

    def solve(self, program):
        x = least_distance(program)
        program.H[:], program.lower[:] = 0.0, -np.inf
        return x if np.isfinite(x).all() else None


class FaultySolver:
    """A user's solver that gives or raises what it was made with."""

    name = "mine"

    def __init__(self, answer):
        self.answer = answer

    def solve(self, program):
        if isinstance(self.answer, BaseException):
            raise self.answer
        return self.answer(program) if callable(self.answer) else self.answer


@pytest.fixture(params=qp_programs.SOLVERS)
def solver(request):
    return qp_programs.installed(request.param)


def test_the_solver_of_a_name_has_that_name(solver):
    assert solver_name(solver) in qp_programs.SOLVERS
    assert "Solver(" in repr(solver)


def test_every_installed_solver_of_qpsolvers_has_a_name_that_a_scenario_may_use():
    assert set(qpsolvers.available_solvers) <= SOLVER_PACKAGES.keys()
    assert get_args(ControllerConfig.model_fields["solver"].annotation) == tuple(SOLVER_PACKAGES)


def test_the_table_of_packages_holds_every_solver_of_qpsolvers_and_its_extra():
    from importlib.metadata import metadata
    from pathlib import Path

    modules = Path(qpsolvers.__file__).parent.glob("solvers/*_.py")
    assert {module.stem.removesuffix("_") for module in modules} - {"__init_"} == SOLVER_PACKAGES.keys()
    extras = metadata("qpsolvers").get_all("Provides-Extra")
    assert {extra for _, extra in SOLVER_PACKAGES.values() if extra} == {*extras} - {
        "open-source-solvers",
        "wheels-only",
    }


def test_an_unknown_solver_is_refused_with_the_installed_ones():
    with pytest.raises(ConfigurationError, match=r"^no solver 'simplex'; the solvers installed here are .*daqp.*osqp"):
        make_solver("simplex")


def test_a_known_solver_without_its_package_is_refused_with_the_command_that_installs_it(monkeypatch):
    monkeypatch.setattr(qpsolvers, "available_solvers", ["daqp", "osqp"])
    for name, remedy in {
        "proxqp": r"the package proxsuite: pip install 'qpsolvers\[proxqp\]'",
        "jaxopt_osqp": r"the package jaxopt: pip install 'qpsolvers\[jaxopt\]'",
        "mosek": r"the package mosek and cvxopt: pip install 'qpsolvers\[mosek\]'",
        "hpipm": "the package hpipm_python: see https://github.com/qpsolvers/qpsolvers#solvers",
    }.items():
        with pytest.raises(
            ConfigurationError, match=f"^the solver '{name}' needs {remedy}; .* are daqp, osqp$"
        ) as caught:
            OperationalSpaceController(load("panda"), solver=name)
        assert "\n" not in str(caught.value)


def test_a_setting_that_the_solver_does_not_know_is_refused_when_the_solver_is_made():
    qp_programs.installed("quadprog")
    with pytest.raises(
        ConfigurationError, match=r"^QpsolversSolver\('quadprog', steps=1\) fails .*TypeError"
    ) as caught:
        QpsolversSolver("quadprog", steps=1)
    assert "\n" not in str(caught.value)


def test_settings_of_a_solver_change_its_effort_and_not_its_answer():
    program = random_program(3, tight=0.3)
    hasty = QpsolversSolver("osqp", max_iter=1)
    assert repr(hasty) == "QpsolversSolver('osqp', max_iter=1)"
    np.testing.assert_array_equal(hasty.solve(program), QpsolversSolver("osqp").solve(program))


@pytest.mark.parametrize("answers", ["multipliers", "answers alone", "no answer", "an error"])
def test_whatever_a_solver_of_qpsolvers_answers_it_is_completed_to_the_optimum(answers, monkeypatch):
    def answered(problem, name, **settings):
        if answers == "an error":
            raise qpsolvers.exceptions.SolverError("domain error")
        solution = qpsolvers.Solution(problem)
        reference = solved(problem, name, **settings)
        solution.x = None if answers == "no answer" else reference.x
        if answers == "multipliers":
            solution.y, solution.z = reference.y, reference.z
        return solution

    solved, solver = qpsolvers.solve_problem, QpsolversSolver("daqp")
    monkeypatch.setattr(qpsolvers_solver.qpsolvers, "solve_problem", answered)
    for seed in range(10):
        program = random_program(seed, tight=0.3)
        lower, upper = program.lower.copy(), program.upper.copy()
        lower[8] = upper[8] = program.G[1] @ least_distance(program._replace(f=1.3 * program.f))
        for other in (program, program._replace(lower=lower, upper=upper)):
            np.testing.assert_allclose(solver.solve(other), least_distance(other), atol=1e-8)


class CompiledSolver:
    """A solver whose method does not tell its arguments."""

    solve = {}.update


def test_a_compiled_method_need_not_tell_its_arguments():
    compiled = CompiledSolver()
    assert make_solver(compiled) is compiled


class NotASolver:
    solve = 3


@pytest.mark.parametrize(
    ("given", "why"),
    [
        (None, "solver = None is not a solver; give a name such as 'daqp'"),
        (5, "solver = 5 is not a solver"),
        (NotASolver(), "is not a solver"),
        (FaultySolver, "its solve must take one program; FaultySolver is a class: give an instance of it"),
        (daqp, "its solve must take one program"),
    ],
)
def test_what_is_no_solver_is_refused_in_one_sentence(given, why):
    with pytest.raises(ConfigurationError, match=why) as caught:
        make_solver(given)
    assert "\n" not in str(caught.value)


def test_an_object_with_solve_is_taken_as_it_is_and_is_called_by_its_class_without_a_name():
    mine = ExactSolver()
    assert make_solver(mine) is mine
    assert solver_name(mine) == "ExactSolver"


def test_a_solver_of_the_user_may_overwrite_what_it_is_given():
    program = random_program(4, tight=0.3)
    kept = [array.copy() for array in program]
    np.testing.assert_allclose(solve(program, ExactSolver()).x, solve(program, make_solver("daqp")).x, atol=1e-8)
    for array, before in zip(program, kept, strict=True):
        np.testing.assert_array_equal(array, before)


def test_a_solution_stays_when_the_solver_uses_its_array_again():
    buffer, exact = np.zeros(7), make_solver("daqp")

    def answer(program):
        buffer[:] = exact.solve(program)
        return buffer

    first, second = (solve(random_program(seed), FaultySolver(answer)).x for seed in (0, 1))
    np.testing.assert_array_equal(first, exact.solve(random_program(0)))
    np.testing.assert_array_equal(second, exact.solve(random_program(1)))


@pytest.mark.parametrize("answer", [10.0, 1e9, np.nan, np.inf, None])
def test_an_answer_is_accepted_by_its_residuals_not_by_the_solver_s_status(answer):
    wrong = FaultySolver(None if answer is None else lambda program: np.full(len(program.f), answer))
    with pytest.raises(SolverError, match=r"^mine found no accelerations within the hard limits$"):
        solve(random_program(0), wrong)


@pytest.mark.parametrize(
    ("answer", "sentence"),
    [
        (
            lambda program: np.zeros(3),
            r"returned an array of shape \(3,\); it must return an array of shape \(14,\) or",
        ),
        (lambda program: np.zeros((len(program.f), 1)), r"returned an array of shape \(14, 1\)"),
        (lambda program: [0.0] * len(program.f), "returned a list; it must return an array"),
        (lambda program: 0.0, "returned a float"),
        (lambda program: np.array(["a"] * len(program.f)), "returned an array of <U1"),
        (lambda program: np.zeros(len(program.f), complex), "returned an array of complex128"),
        (ValueError("no\nsolution"), "raised ValueError: no$"),
        (KeyError(), "raised KeyError$"),
        (ConfigurationError("no licence"), "raised ConfigurationError: no licence"),
    ],
)
@pytest.mark.parametrize("reads_only", [False, True])
def test_a_fault_of_a_solver_is_one_sentence(answer, sentence, reads_only):
    faulty = FaultySolver(answer)
    faulty.reads_only = reads_only
    with pytest.raises(SolverError, match=f"^mine {sentence}") as caught:
        solve(random_program(0), faulty)
    assert "\n" not in str(caught.value)


def test_a_solver_that_raises_where_there_is_no_answer_gets_the_softened_program():
    def answer(program):
        x = exact.solve(program)
        if x is None:
            raise ValueError("constraints are inconsistent, no solution")
        return x

    exact = make_solver("daqp")
    solution = solve(contradiction(), FaultySolver(answer))
    assert solution.relaxed
    np.testing.assert_array_equal(solution.x, solve(contradiction(), exact).x)


def observation() -> Observation:
    return Observation(0.0, HOME["panda"], np.zeros(7))


def test_a_controller_takes_a_solver_of_the_user():
    arm = load("panda")
    line = StraightLine(arm.update(HOME["panda"], np.zeros(7)).pose, [0.0, 0.1, 0.05], 0.5)
    mine, reference = (
        OperationalSpaceController(arm, posture=HOME["panda"], solver=s) for s in (ExactSolver(), "daqp")
    )
    outputs = [controller.step(observation(), line.at(0.1)) for controller in (mine, reference)]
    assert not outputs[0].fallback
    np.testing.assert_allclose(outputs[0].command.torque, outputs[1].command.torque, atol=1e-6)


def test_a_controller_whose_solver_fails_gives_the_reason_and_a_fallback_torque():
    arm = load("panda")
    line = StraightLine(arm.update(HOME["panda"], np.zeros(7)).pose, [0.0, 0.1, 0.05], 0.5)
    controller = OperationalSpaceController(arm, posture=HOME["panda"], solver=FaultySolver(RuntimeError("no licence")))
    output = controller.step(observation(), line.at(0.1))
    assert output.fallback.startswith("mine raised RuntimeError: no licence; ")
    assert (np.abs(output.command.torque) <= arm.torque_limit).all()


def test_a_solver_may_be_interrupted():
    with pytest.raises(KeyboardInterrupt):
        solve(random_program(0), FaultySolver(KeyboardInterrupt()))


def programs() -> list[QuadraticProgram]:
    return [random_program(seed, tight=0.3) for seed in range(6)] + [contradiction(), contradiction().softened()]


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda made: pickle.loads(pickle.dumps(made))])
@pytest.mark.parametrize("used", [False, True])
def test_a_copy_of_a_solver_fresh_or_used_answers_to_the_bit(solver, used, copied):
    for program in programs() if used else ():
        solver.solve(program)
    twin = copied(solver)
    assert repr(twin) == repr(solver)
    for program in programs():
        first, second = solver.solve(program), twin.solve(program)
        assert (first is None) == (second is None)
        assert first is None or np.array_equal(first, second)


def test_threads_may_share_a_solver(solver):
    expected, found = [solver.solve(program) for program in programs()], {}

    def work(number):
        found[number] = [[solver.solve(program) for program in programs()] for _ in range(20)]

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        threads = [threading.Thread(target=work, args=(number,)) for number in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        sys.setswitchinterval(interval)
    assert len(found) == 3
    for answers in (answers for rounds in found.values() for answers in rounds):
        for answer, other in zip(answers, expected, strict=True):
            assert np.array_equal(answer, other) if other is not None else answer is None


def test_a_solver_prints_and_warns_nothing(solver, capfd, recwarn):
    warnings.simplefilter("always")
    sparse = QpsolversSolver("osqp", max_iter=1)
    for program in programs():
        solver.solve(program)
        sparse.solve(program)
    assert capfd.readouterr() == ("", "")
    assert not recwarn


def test_only_the_thread_that_asked_for_quiet_is_quiet():
    def warn():
        warnings.warn("from another thread", stacklevel=1)

    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        with without_warnings():
            warnings.warn("from this thread", stacklevel=1)
            other = threading.Thread(target=warn)
            other.start()
            other.join()
        warnings.warn("afterwards", stacklevel=1)
    assert [str(warning.message) for warning in seen] == ["from another thread", "afterwards"]


def test_quiet_adds_one_filter_however_often_it_is_asked_for():
    with warnings.catch_warnings():
        before = len(warnings.filters)
        for _ in range(5):
            with without_warnings():
                warnings.simplefilter("error")
        assert len(warnings.filters) <= before + 2
