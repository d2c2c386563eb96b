"""Every installed solver on the recorded programs of two arms, as the Markdown tables of docs/solvers.md.

Usage: python compare_solvers.py [FILE], a file of `python tests/qp_programs.py record`; by default the checkout's own
"""

import sys
from pathlib import Path

from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.experiments.recorded_program import load_programs
from pilegrasp_ctrl.experiments.solver_comparison import SolverComparison

RECORDED = Path(__file__).resolve().parents[1] / "tests" / "data" / "qp_programs.npy"


def main() -> None:
    """Compare and print."""
    try:
        programs = load_programs(Path(sys.argv[1]) if sys.argv[1:] else RECORDED)
    except ConfigurationError as error:
        sys.exit(str(error))
    print(SolverComparison.of(programs).markdown())


if __name__ == "__main__":
    main()
