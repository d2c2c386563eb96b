"""Every installed solver on the recorded programs of two arms, as the Markdown tables of docs/solvers.md.

Usage: python docs/studies/compare_solvers.py [FILE]; `python tests/helpers/qp_programs.py record` writes such a file.
"""

from pathlib import Path

from recorded_program import load_programs
from script import run_script
from solver_comparison import SolverComparison

RECORDED = Path(__file__).resolve().parents[2] / "tests" / "data" / "qp_programs.npy"


def main(file: Path = RECORDED) -> None:
    """Compare and print."""
    print(SolverComparison.of(load_programs(file)).markdown())


if __name__ == "__main__":
    run_script(main)
