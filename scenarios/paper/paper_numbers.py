"""The paper beside the model: every result that the paper prints as a number, with the model's, and a p-value."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from itertools import product
from typing import Any

import numpy as np

from pilegrasp_ctrl.scenarios.paper.conditions import HAND, HEAVY_MASS, LIGHT_MASS, SHOVEL, grasp, spheres
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence, Sample, wilson
from pilegrasp_ctrl.scenarios.paper.figures_mechanism import OPERATORS, ORDER_NAMES, order_condition
from pilegrasp_ctrl.scenarios.paper.figures_objects import ROUNDNESS_NAMES, roundness_grid
from pilegrasp_ctrl.scenarios.paper.figures_piles import HARD_PUSH, ROBOT_COUNTS, UNSUPPORTED, USUAL_PUSH
from pilegrasp_ctrl.scenarios.paper.printed import printed_numbers
from pilegrasp_ctrl.study.condition import Condition


@cache
def _conditions() -> dict[str, tuple[Condition, ...]]:
    """Return the conditions of the model's attempts by a number's name, where it is about some of them."""
    found: dict[str, tuple[Condition, ...]] = {
        "shovel-light": (grasp("light_sphere", "wall", SHOVEL),),
        "unsupported-triggered": (UNSUPPORTED,),
        "unsupported-sensor": (UNSUPPORTED,),
        "push-usual": (USUAL_PUSH,),
        "push-hard": (HARD_PUSH,),
    }
    found |= {f"hand-{kind}": (grasp(kind),) for kind in ("light_sphere", "heavy_sphere", "cylinder")}
    found |= {f"grid-{kind}": roundness_grid(kind, HAND) for kind in ROUNDNESS_NAMES}
    found |= {f"order-{kind}": (order_condition(kind, OPERATORS[0]),) for kind in ORDER_NAMES}
    for word, mass in (("light", LIGHT_MASS), ("heavy", HEAVY_MASS)):
        for count, support in product(ROBOT_COUNTS, ("wall", "corner")):
            found[f"small-{word}-{count}-{support}"] = (spheres(mass, support, HAND, count),)
    return found


EVERYWHERE = {"several-hand": HAND, "several-shovel": SHOVEL}
"""End-effector of a number that is about all grasps with it, by the number's name."""


def _sample(name: str, evidence: Evidence) -> Sample:
    if name in EVERYWHERE:
        return evidence.grasps_with(EVERYWHERE[name])
    return evidence.balanced_sample(_conditions()[name])


def paper_beside_model(evidence: Evidence) -> list[dict[str, Any]]:
    """Return every printed number with the model's, as JSON values.

    Keys are those of the file, and: `n` attempts of the model, `value` its share or mean, `ci_low` and `ci_high` the
    95 % interval (Wilson's, or Student's of a mean), and `p`. It is two-sided where the numbers are compared as equal:
    Fisher's exact test of two counts, or Student's test of the model's mean, because the paper prints no deviation. Of
    a bound it is one-sided: the binomial probability of a share as far on the wrong side, or farther. All are None
    without attempts.
    """
    return [_compared(row, _sample(name, evidence)) for name, row in printed_numbers().items()]


def _compared(row: Mapping[str, Any], sample: Sample) -> dict[str, Any]:
    if "mean" in row:
        return {**row, **_mean(sample.numbers(row["number"]), row["mean"])}
    flags = sample.flags(row.get("flag", "success"))
    if "among" in row:
        flags = flags[sample.flags(row["among"])]
    return {**row, **_share(int(np.count_nonzero(flags)), int(flags.size), row)}


def _share(count: int, n: int, row: Mapping[str, Any]) -> dict[str, Any]:
    from scipy.stats import binom, fisher_exact

    if n == 0:
        return _nothing()
    share, relation = float(row["share"]), row["relation"]
    if relation == "equal":
        printed = round(share * row["of"])
        p = fisher_exact([[count, printed], [n - count, row["of"] - printed]]).pvalue
    elif relation == "at least":
        p = binom.cdf(count, n, share)
    else:
        p = binom.sf(count - 1, n, share)
    low, high = wilson(count, n)
    return {"n": n, "value": count / n, "ci_low": low, "ci_high": high, "p": float(p)}


def _mean(values: Any, printed: float) -> dict[str, Any]:
    from scipy.stats import t

    n = int(values.size)
    if n < 2:
        return _nothing() | {"n": n}
    mean, error = float(values.mean()), float(values.std(ddof=1)) / math.sqrt(n)
    half = float(t.ppf(0.975, n - 1)) * error
    p = 2.0 * float(t.sf(abs(mean - printed) / error, n - 1)) if error > 0.0 else float(mean == printed)
    return {"n": n, "value": mean, "ci_low": mean - half, "ci_high": mean + half, "p": p}


def _nothing() -> dict[str, Any]:
    return {"n": 0, "value": None, "ci_low": None, "ci_high": None, "p": None}
