"""Rank the uncertain numbers by the variance of success that each explains: a Latin hypercube over their bands.

Usage: python docs/studies/first_order.py FOLDER [EACH JOBS]

Needs SALib (`pip install salib`). FOLDER becomes a study, as `pilegrasp sweep` makes it; attempts that it holds are not
run again. Each of four conditions has EACH attempts, every one with its own seed from 30000 on and its own numbers.
First-order indices are those of RBD-FAST (Tarantola, Gatelli and Mara 2006), with their 95 % bootstrap intervals. Total
indices come from a quadratic surrogate, where its cross-validated error is below that of the mean.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import qmc

from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.scenarios.paper.conditions import grasp
from pilegrasp_ctrl.statistics import markdown_table
from pilegrasp_ctrl.study.condition import Condition
from pilegrasp_ctrl.study.run import run_study
from pilegrasp_ctrl.types import Array
from script import run_script, seed_range, show_progress
from sensitivity import FACTORS, varied

FIRST_SEED = 30000
"""First seed of every condition."""

SAMPLER_SEED = 1
"""Seed of the hypercube; any number will do."""

CONDITIONS: dict[str, Condition] = {
    "14 cylinders, wall": grasp("cylinder"),
    "18 heavy, corner": grasp("heavy_sphere", "corner"),
    "5 light, corner": grasp("light_sphere", "corner", count=5),
    "14 cubes, wall": grasp("cube"),
}
"""Conditions in which the hand neither holds everything nor nothing."""

KEYS = tuple(key for band in FACTORS for key in band.ends[0])
"""Scenario keys of the numbers."""

BOUNDS = tuple((float(band.ends[0][key]), float(band.ends[1][key])) for band in FACTORS for key in band.ends[0])
"""Factors at the two ends of their bands."""

FOLDS = 10
"""Parts of the cross-validation [-]; chosen."""

RIDGE = 1.0
"""Penalty on the coefficients of the surrogate, whose numbers go from -1 to 1 [-]; chosen."""

SURROGATE_SAMPLES = 1024
"""Base samples of the total indices [-]; a power of two, chosen."""


def hypercube(each: int) -> Array:
    """Return the factors (each, numbers) of a Latin hypercube, rounded to 1e-4."""
    unit = qmc.LatinHypercube(len(KEYS), rng=np.random.default_rng(SAMPLER_SEED)).random(each)
    low, high = np.array(BOUNDS).T
    return np.asarray(np.round(low + unit * (high - low), 4))


def quadratic(factors: Array) -> Array:
    """Return the terms (n, m) of a quadratic surrogate without its constant: numbers, squares and products."""
    low, high = np.array(BOUNDS).T
    x = 2.0 * (factors - low) / (high - low) - 1.0
    rows, columns = np.triu_indices(x.shape[1])
    return np.hstack([x, x[:, rows] * x[:, columns]])


def fit(terms: Array, values: Array) -> tuple[float, Array]:
    """Return constant and coefficients of a ridge regression."""
    middle, offset = terms.mean(axis=0), float(values.mean())
    centred = terms - middle
    normal = centred.T @ centred + RIDGE * np.eye(terms.shape[1])
    coefficients = np.linalg.solve(normal, centred.T @ (values - offset))
    return offset - float(middle @ coefficients), coefficients


def gain_over_mean(factors: Array, values: Array) -> float:
    """Return the share by which the surrogate's squared error is below the mean's, in cross-validation [-]."""
    terms, order = quadratic(factors), np.random.default_rng(SAMPLER_SEED).permutation(values.size)
    own = mean = 0.0
    for part in np.array_split(order, FOLDS):
        rest = np.setdiff1d(order, part)
        constant, coefficients = fit(terms[rest], values[rest])
        own += float(((constant + terms[part] @ coefficients - values[part]) ** 2).sum())
        mean += float(((values[rest].mean() - values[part]) ** 2).sum())
    return 1.0 - own / mean if mean > 0.0 else 0.0


def totals(factors: Array, values: Array) -> Array | None:
    """Return the total indices (numbers,) of the surrogate, or None where it does not beat the mean."""
    from SALib.analyze import sobol
    from SALib.sample import sobol as sampling

    if gain_over_mean(factors, values) <= 0.0:
        return None
    drawn = sampling.sample(problem(), SURROGATE_SAMPLES, calc_second_order=False, seed=SAMPLER_SEED)
    constant, coefficients = fit(quadratic(factors), values)
    found = constant + quadratic(drawn) @ coefficients
    return np.asarray(sobol.analyze(problem(), found, calc_second_order=False, seed=SAMPLER_SEED)["ST"])


def problem() -> dict[str, Any]:
    """Return the numbers and their bands as SALib wants them."""
    return {"num_vars": len(KEYS), "names": list(KEYS), "bounds": [list(ends) for ends in BOUNDS]}


def main(folder: Path, each: int = 400, jobs: int = 2) -> None:
    """Run the missing attempts, and print a table for each condition, the largest index first."""
    try:
        from SALib.analyze import rbd_fast
    except ImportError:
        raise ConfigurationError("first_order.py needs SALib, which is not installed: pip install salib") from None
    seeds = seed_range(FIRST_SEED, FIRST_SEED + each)
    factors = hypercube(each)
    drawn = {
        name: [
            (varied(condition, dict(zip(KEYS, map(float, line), strict=True))), seed)
            for seed, line in zip(seeds, factors, strict=True)
        ]
        for name, condition in CONDITIONS.items()
    }
    # Conditions take turns, so that an interrupted run has equally many attempts of each.
    attempts = [pair for line in zip(*drawn.values(), strict=True) for pair in line]
    with run_study(attempts, folder, jobs=jobs, progress=show_progress) as store:
        results = {name: np.array([store.attempts([pair])[0].success for pair in drawn[name]], float) for name in drawn}
    for name, values in results.items():
        print(f"\n{name}: held {int(values.sum())} of {values.size}\n")
        if values.std() == 0.0:
            print("Nothing to explain.")
            continue
        first = rbd_fast.analyze(problem(), factors, values, seed=SAMPLER_SEED)
        whole = totals(factors, values)
        order = np.argsort(-np.asarray(first["S1"]))
        rows = [
            (
                f"`{KEYS[place]}`",
                f"{first['S1'][place]:.2f} ± {first['S1_conf'][place]:.2f}",
                "-" if whole is None else f"{whole[place]:.2f}",
            )
            for place in order
        ]
        print(markdown_table(("number", "first-order index", "total"), rows))


if __name__ == "__main__":
    run_script(main)
