"""Print how success, trigger time and peak force of `spheres_wall` depend on the physics step and the contact solver.

Usage: python docs/studies/convergence.py [FIRST LAST]

The two tables are those of docs/numerics.md.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import ttest_ind

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.episode import run_attempt
from pilegrasp_ctrl.exceptions import PilegraspError
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sim.scene import SOLVER_ITERATIONS
from pilegrasp_ctrl.statistics import markdown_table, wilson
from script import run_script, seed_range

TOLERANCE = 1e-8
"""Tolerance of MuJoCo's contact solver in the models [-]; MuJoCo's default."""


@dataclass(frozen=True, slots=True)
class Numerics:
    """Settings of the physics.

    Attributes:
        timestep: Physics step [s].
        iterations: Largest number of iterations of the contact solver.
        tolerance: Tolerance at which the contact solver stops [-].
    """

    timestep: float = 1e-3
    iterations: int = SOLVER_ITERATIONS
    tolerance: float = TOLERANCE

    @property
    def label(self) -> str:
        """Name in a table."""
        return f"{1e3 * self.timestep:g} ms, {self.iterations} iterations, {self.tolerance:.0e}"


STEPS = tuple(Numerics(timestep) for timestep in (2e-3, 1e-3, 5e-4, 2.5e-4))
"""Settings in the rows of the first table."""

SOLVERS = (Numerics(iterations=10, tolerance=1e-6), Numerics(), Numerics(iterations=200, tolerance=1e-12))
"""Settings in the rows of the second table."""


@dataclass(frozen=True, slots=True)
class Result:
    """One attempt.

    Attributes:
        success: Whether an object was held.
        trigger_time: Time from the start of the push to F_grasp [s]; NaN if the sensor did not feel F_grasp.
        peak_force: Largest force of the push [N]; NaN without a push.
    """

    success: bool
    trigger_time: float = math.nan
    peak_force: float = math.nan


def run_with(numerics: Numerics, seed: int) -> Result:
    """Run one attempt; an attempt whose pile does not settle, or that the watchdog stops, has failed."""
    try:
        prepared = prepare(load_scenario("spheres_wall", {"sim.timestep": numerics.timestep}), seed)
        option = prepared.simulation.scene.model.opt
        option.iterations, option.tolerance = numerics.iterations, numerics.tolerance
        result = run_attempt(prepared)
    except PilegraspError:
        return Result(False)
    push = next((outcome for outcome in result.outcomes if outcome.name == "push"), None)
    if push is None:
        return Result(False)
    time = push.end - push.start if push.status == "ended" else math.nan
    return Result(result.success, time, push.peak_force)


def convergence_table(results: Mapping[Numerics, Sequence[Result]], column: Sequence[Numerics]) -> str:
    """Return a Markdown table with a row for each setting and its differences from the next row.

    A difference is a 95 % interval, by Newcombe for the rate and by Welch for the means.
    """
    header = ("step, solver", "success", "trigger [s]", "peak [N]", "less the next: success", "trigger [s]", "peak [N]")
    rows = []
    for index, numerics in enumerate(column):
        own, below = results[numerics], results[column[min(index + 1, len(column) - 1)]]
        hits, count = sum(result.success for result in own), len(own)
        low, high = wilson(hits, count)
        cells = [numerics.label, f"{hits} of {count} ({low:.0%} to {high:.0%})"]
        cells += [_mean(_values(own, name)) for name in ("trigger_time", "peak_force")]
        if index + 1 < len(column):
            low, high = rate_difference(hits, count, sum(result.success for result in below), len(below))
            cells.append(f"{low:+.0%} to {high:+.0%}")
            cells += [_difference(_values(own, name), _values(below, name)) for name in ("trigger_time", "peak_force")]
        else:
            cells += [""] * 3
        rows.append(cells)
    return markdown_table(header, rows)


def rate_difference(hits: int, count: int, other_hits: int, other_count: int) -> tuple[float, float]:
    """Return the 95 % interval of a difference of two rates (Newcombe 1998, method 10)."""
    own, other = hits / count, other_hits / other_count
    (own_low, own_high), (other_low, other_high) = wilson(hits, count), wilson(other_hits, other_count)
    difference = own - other
    low = difference - math.hypot(own - own_low, other_high - other)
    return low, difference + math.hypot(own_high - own, other - other_low)


def _values(results: Sequence[Result], name: str) -> list[float]:
    return [value for result in results if math.isfinite(value := getattr(result, name))]


def _mean(values: Sequence[float]) -> str:
    return f"{np.mean(values):.2f} ± {np.std(values, ddof=1):.2f}" if len(values) > 1 else "-"


def _difference(own: Sequence[float], other: Sequence[float]) -> str:
    interval = ttest_ind(own, other, equal_var=False).confidence_interval(0.95)
    return f"{interval.low:+.2f} to {interval.high:+.2f}"


def main(first: int = 0, last: int = 18) -> None:
    """Run seeds FIRST to LAST - 1 (0 to 17) with every setting on one core, and print both tables."""
    results: dict[Numerics, list[Result]] = {numerics: [] for numerics in (*STEPS, *SOLVERS)}
    for seed in seed_range(first, last):
        for numerics, done in results.items():
            print(f"seed {seed}, {numerics.label}", file=sys.stderr)
            done.append(run_with(numerics, seed))
    for column in (STEPS, SOLVERS):
        print(convergence_table(results, column), end="\n\n")


if __name__ == "__main__":
    run_script(main)
