"""Success, trigger time and peak force of spheres_wall at other steps and solver settings: tables of docs/numerics.md.

Usage: python convergence.py [FILE [FIRST LAST]]; attempts are kept in FILE (convergence.jsonl), and not run twice
"""

import sys
from pathlib import Path

from physics_convergence import SOLVERS, STEPS, convergence, convergence_table
from script import run_script, seed_range


def main(file: Path = Path("convergence.jsonl"), first: int = 0, last: int = 18) -> None:
    """Run what is missing of seeds FIRST to LAST - 1 (0 to 17) on one core, and print both tables."""

    def show(share: float, what: str) -> None:
        print(f"{share:4.0%} {what}", file=sys.stderr)

    results = convergence(file, "spheres_wall", seed_range(first, last), show)
    for column in (STEPS, SOLVERS):
        print(convergence_table(results, column), end="\n\n")


if __name__ == "__main__":
    run_script(main)
