"""Every installed solver on the recorded programs of two arms, as the Markdown tables of docs/solvers.md.

Usage: python compare_solvers.py [FILE], a file of `python tests/qp_programs.py record`; by default the checkout's own
"""

from pathlib import Path

from pilegrasp_ctrl.experiments.recorded_program import load_programs
from pilegrasp_ctrl.experiments.solver_comparison import SolverComparison
from pilegrasp_ctrl.scenarios._script import run_script

RECORDED = Path(__file__).resolve().parents[1] / "tests" / "data" / "qp_programs.npy"


def main(file: Path = RECORDED) -> None:
    """Compare and print."""
    print(SolverComparison.of(load_programs(file)).markdown())


if __name__ == "__main__":
    run_script(main)
