"""Do the results of attempts depend on the numerics? The same seeds at other steps and other settings of the solver."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from scipy.stats import ttest_ind

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.episode import run_attempt
from pilegrasp_ctrl.exceptions import PilegraspError
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sim.scene import SOLVER_ITERATIONS
from pilegrasp_ctrl.statistics import markdown_table, wilson

TOLERANCE = 1e-8
"""MuJoCo's own, which the models keep."""


@dataclass(frozen=True, slots=True)
class Numerics:
    """Step [s], and most iterations and tolerance of the contact solver."""

    timestep: float = 1e-3
    iterations: int = SOLVER_ITERATIONS
    tolerance: float = TOLERANCE

    @property
    def label(self) -> str:
        """Words for a table."""
        return f"{1e3 * self.timestep:g} ms, {self.iterations} iterations, {self.tolerance:.0e}"


STEPS = tuple(Numerics(timestep) for timestep in (2e-3, 1e-3, 5e-4, 2.5e-4))
SOLVERS = (Numerics(iterations=10, tolerance=1e-6), Numerics(), Numerics(iterations=200, tolerance=1e-12))


@dataclass(frozen=True, slots=True)
class Result:
    """One attempt: `trigger_time` [s] from the start of the push to F_grasp, or NaN; `peak_force` of the push [N]."""

    numerics: Numerics
    seed: int
    success: bool
    trigger_time: float
    peak_force: float
    reason: str


def attempt(scenario: str, numerics: Numerics, seed: int) -> Result:
    """Carry out one attempt; one whose pile does not settle, or that the watchdog stops, has failed."""
    try:
        prepared = prepare(load_scenario(scenario, {"sim.timestep": numerics.timestep}), seed)
        option = prepared.simulation.scene.model.opt
        option.iterations, option.tolerance = numerics.iterations, numerics.tolerance
        result = run_attempt(prepared)
    except PilegraspError as error:
        return Result(numerics, seed, False, math.nan, math.nan, str(error))
    push = next((outcome for outcome in result.outcomes if outcome.name == "push"), None)
    if push is None:
        return Result(numerics, seed, False, math.nan, math.nan, result.reason)
    time = push.end - push.start if push.status == "ended" else math.nan
    return Result(numerics, seed, result.success, time, push.peak_force, result.reason)


def convergence(
    file: Path, scenario: str, seeds: Sequence[int], progress: Callable[[float, str], None] = lambda share, what: None
) -> list[Result]:
    """Carry out what `file` does not hold yet, one attempt a line, and return the results of `seeds`."""
    known = _read(file)
    wanted = [(numerics, seed) for seed in seeds for numerics in dict.fromkeys((*STEPS, *SOLVERS))]
    for done, (numerics, seed) in enumerate(wanted):
        progress(done / len(wanted), f"seed {seed}, {numerics.label}")
        if (numerics, seed) not in known:
            known[numerics, seed] = attempt(scenario, numerics, seed)
            with file.open("a", encoding="utf-8") as lines:
                lines.write(json.dumps(asdict(known[numerics, seed])) + "\n")
    return [known[key] for key in wanted]


def _read(file: Path) -> dict[tuple[Numerics, int], Result]:
    lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    documents = [json.loads(line) for line in lines]
    results = [Result(**{**document, "numerics": Numerics(**document["numerics"])}) for document in documents]
    return {(result.numerics, result.seed): result for result in results}


def convergence_table(results: Sequence[Result], column: Sequence[Numerics]) -> str:
    """Return a Markdown table: a row a setting, and how it differs from the setting below it.

    Differences are given with their 95 % interval (Newcombe for the rate, Welch for the means).
    """
    header = ("step, solver", "success", "trigger [s]", "peak [N]", "less the next: success", "trigger [s]", "peak [N]")
    rows = []
    for index, numerics in enumerate(column):
        own = [result for result in results if result.numerics == numerics]
        below = [result for result in results if result.numerics == column[min(index + 1, len(column) - 1)]]
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
