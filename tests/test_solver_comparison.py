"""The comparison of solvers: what it says of good ones and of bad ones, and the file that it reads."""

import runpy
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import qp_programs

from pilegrasp_ctrl.control.qp import SOLVERS, make_solver
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.experiments.naive_solver import NaiveSolver
from pilegrasp_ctrl.experiments.recorded_program import load_programs, save_programs
from pilegrasp_ctrl.experiments.solver_assessment import SolverAssessment, Verdict
from pilegrasp_ctrl.experiments.solver_comparison import SolverComparison

PROGRAMS = qp_programs.recorded()[::5]
SCRIPT = Path(__file__).parents[1] / "scenarios" / "compare_solvers.py"


def test_programs_are_read_as_they_were_written(tmp_path):
    file = tmp_path / "programs.npy"
    save_programs(file, PROGRAMS)
    for one, other in zip(load_programs(file), PROGRAMS, strict=True):
        assert one[:3] == other[:3]
        for a, b in zip((*one.problem, *one[4:]), (*other.problem, *other[4:]), strict=True):
            np.testing.assert_array_equal(a, b)


def test_a_file_without_programs_is_one_sentence(tmp_path):
    with pytest.raises(ConfigurationError, match="No such file or directory; recorded programs come with the source"):
        load_programs(tmp_path / "absent.npy")
    (tmp_path / "text.npy").write_text("x = 1")
    np.save(tmp_path / "numbers.npy", np.zeros(3))
    np.save(tmp_path / "objects.npy", np.array([{}]), allow_pickle=True)
    for name in ("text", "numbers", "objects"):
        with pytest.raises(ConfigurationError, match=f"{name}.npy: holds no recorded programs"):
            load_programs(tmp_path / f"{name}.npy")


class Answering:
    """Gives the same kind of answer to every program."""

    name = "answering"

    def __init__(self, answer):
        self.answer = answer

    def solve(self, problem):
        return self.answer(problem)


def test_a_solver_that_is_right_is_said_to_be():
    assessment = SolverAssessment.of(lambda: make_solver("daqp"), PROGRAMS)
    assert {verdict[1:3] for verdict in assessment.verdicts.values()} == {(0, 0)}
    assert sum(verdict.right for verdict in assessment.verdicts.values()) == len(PROGRAMS) + 4
    assert max(verdict.error for verdict in assessment.verdicts.values()) < 1e-6
    assert assessment.torque_error < 1e-6
    assert max(assessment.excess, assessment.torque_excess) < 1e-9
    assert assessment.repeatable


def test_a_solver_that_refuses_is_right_where_there_is_no_solution():
    verdicts = SolverAssessment.of(lambda: Answering(lambda problem: None), PROGRAMS).verdicts
    assert verdicts["infeasible"] == Verdict(right=4)
    assert {verdict for kind, verdict in verdicts.items() if kind != "infeasible"} == {Verdict(refused=4)}


def test_a_solver_that_is_wrong_is_measured():
    assessment = SolverAssessment.of(lambda: Answering(lambda problem: np.zeros(len(problem.f))), PROGRAMS)
    for kind, verdict in assessment.verdicts.items():
        known = [np.abs(program.x).max() for program in PROGRAMS if program.kind == kind]
        known = {"infeasible": [0.0], "softened": [verdict.error]}.get(kind, known)
        assert verdict == Verdict(wrong=4, error=max(known))
    assert assessment.torque_error == max(np.abs(program.problem.G @ program.x).max() for program in PROGRAMS)
    assert assessment.excess > 1.0
    assert assessment.torque_excess > 1.0
    noisy = SolverAssessment.of(lambda: Answering(lambda problem: np.random.normal(size=len(problem.f))), PROGRAMS)  # noqa: NPY002
    assert not noisy.repeatable


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_the_naive_call_leaves_the_bounds_while_it_says_solved():
    assessment = SolverAssessment.of(lambda: NaiveSolver("osqp"), PROGRAMS)
    assert assessment.verdicts["nominal"].wrong == 4
    assert max(assessment.excess, assessment.torque_excess) > 1e-3


def test_the_table_has_a_row_for_every_solver_that_is_installed(monkeypatch):
    installed = {name for name in SOLVERS if name not in qp_programs.OPTIONAL or _found(name)}
    comparison = SolverComparison.of(PROGRAMS, blocks=1, block_time=1e-4)
    naive = {f"naive {name}" for name in ("osqp", "proxqp") if name in installed}
    assert {row.solver for row in comparison.rows} == installed | naive
    lines = comparison.markdown().splitlines()
    first, second = lines[: lines.index("")], lines[lines.index("") + 1 :]
    for table in (first, second):
        assert len({line.count("|") for line in table}) == 1
    assert len(first) == 2 + len(comparison.rows)
    assert {line.split(" | ")[0] for line in second[2:]} == {
        f"| {kind}" for kind in comparison.rows[0].assessment.verdicts
    }
    for name in qp_programs.OPTIONAL:
        monkeypatch.setitem(sys.modules, qp_programs.OPTIONAL[name], None)
        monkeypatch.delitem(sys.modules, f"pilegrasp_ctrl.control.{name}_solver", raising=False)
    fewer = SolverComparison.of(PROGRAMS, blocks=1, block_time=1e-4)
    assert [row.solver for row in fewer.rows] == ["daqp", "osqp", "naive osqp"]


def _found(name: str) -> bool:
    try:
        make_solver(name)
    except ConfigurationError:
        return False
    return True


def test_the_script_prints_the_tables(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", [str(SCRIPT)])
    monkeypatch.setattr(SolverComparison, "of", partial(SolverComparison.of, blocks=1, block_time=1e-4))
    runpy.run_path(str(SCRIPT), run_name="__main__")
    assert capsys.readouterr().out.startswith("| solver | version |")
    monkeypatch.setattr(sys, "argv", [str(SCRIPT), "absent.npy"])
    with pytest.raises(SystemExit, match="2"):
        runpy.run_path(str(SCRIPT), run_name="__main__")
    assert "absent.npy: cannot be read" in capsys.readouterr().err
