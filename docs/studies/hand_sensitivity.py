"""How much the success of a grasp owes to numbers of the model that nobody has measured."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.episode import run
from pilegrasp_ctrl.exceptions import PilegraspError
from pilegrasp_ctrl.statistics import markdown_table, wilson

SCENARIO = "spheres_wall"
SHARE = 0.3
"""By which each uncertain number is lowered and raised."""
ENCLOSED_AIR = 1.1
"""Share of the bending stiffness that the air enclosed in a finger adds; the hand's README derives it."""
UNCERTAIN = (
    "hand_model.bending_stiffness",
    "hand_model.closing_moment",
    "hand_model.fingertip_radius",
    "hand_model.friction",
    "pile.friction",
    "hand_model.lateral_stiffness",
)
"""No measurement of these was found, and the grasp leans on them; see the hand's README and `docs/objects.md`."""


@dataclass(frozen=True, slots=True, order=True)
class Condition:
    """One key of a scenario with a value; no key at all is the scenario as it ships."""

    key: str
    value: float

    @property
    def label(self) -> str:
        """How a table and a figure name it."""
        return f"`{self.key}` = {self.value:g}" if self.key else "as shipped"

    def overrides(self) -> dict[str, float]:
        """Return what `load_scenario` takes."""
        return {self.key: self.value} if self.key else {}


@dataclass(frozen=True, slots=True)
class Row:
    """Successes of a condition with the 95 % Wilson interval of their rate."""

    condition: Condition
    successes: int
    attempts: int

    @property
    def interval(self) -> tuple[float, float]:
        """Lower and upper end of the rate."""
        return wilson(self.successes, self.attempts)


def conditions(share: float = SHARE) -> list[Condition]:
    """Return the scenario as it ships, stiffened fingers, and every uncertain number lowered and raised by `share`."""
    varied = [Condition(key, factor) for key in UNCERTAIN for factor in (1.0 - share, 1.0 + share)]
    return [Condition("", 1.0), Condition("hand_model.inflation_stiffness", ENCLOSED_AIR), *varied]


def attempt(condition: Condition, seed: int) -> tuple[bool, str]:
    """Run one seed; return success and why not. An attempt that cannot be carried out holds nothing."""
    try:
        result = run(load_scenario(SCENARIO, condition.overrides()), seed=seed)
    except PilegraspError as error:
        return False, str(error)
    return result.success, result.reason


def measure(wanted: Sequence[Condition], seeds: range, jobs: int, file: Path) -> Iterator[tuple[Condition, int]]:
    """Run what `file` does not hold yet and add it there, one line an attempt; yield each attempt as it ends.

    Conditions take turns, so that a run that is cut short has as many seeds of each.
    """
    done = _read(file)
    missing = [(condition, seed) for seed in seeds for condition in wanted if (condition, seed) not in done]
    if not missing:
        return
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool, file.open("a", newline="", encoding="utf-8") as sheet:
        ended = pool.map(attempt, *zip(*missing, strict=True))
        for (condition, seed), (success, reason) in zip(missing, ended, strict=True):
            csv.writer(sheet).writerow([condition.key, condition.value, seed, int(success), reason])
            sheet.flush()
            yield condition, seed


def rows(file: Path) -> list[Row]:
    """Count the attempts in `file`, in the order of `conditions`."""
    results = _read(file)
    counted = [[won for (of, _), won in results.items() if of == condition] for condition in conditions()]
    return [Row(c, sum(won), len(won)) for c, won in zip(conditions(), counted, strict=True) if won]


def markdown(counted: Sequence[Row]) -> str:
    """Return the rates as a Markdown table."""
    lines = []
    for row in counted:
        low, high = row.interval
        lines.append((row.condition.label, f"{row.successes} of {row.attempts}", f"{low:.0%} to {high:.0%}"))
    return markdown_table(("", "success", "95 % interval"), lines)


def _read(file: Path) -> dict[tuple[Condition, int], bool]:
    if not file.exists():
        return {}
    with file.open(newline="", encoding="utf-8") as sheet:
        return {(Condition(key, float(value)), int(seed)): won == "1" for key, value, seed, won, _ in csv.reader(sheet)}
