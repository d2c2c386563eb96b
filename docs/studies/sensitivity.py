"""Run seven conditions with each uncertain number at the ends of its band, and rank the numbers by their effect.

Usage: python docs/studies/sensitivity.py FOLDER [FIRST LAST JOBS]

FOLDER holds the shapes of the shovel's tray, as folders of hands, and a study, as `pilegrasp sweep` makes it; attempts
that it holds are not run again. The effect of a number is the largest difference between the rates at its two ends and
in the middle, over the conditions. The table is printed and written to FOLDER/sensitivity.csv, and
FOLDER/sensitivity.png shows it.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.scenarios.paper.conditions import SHOVEL, grasp
from pilegrasp_ctrl.statistics import markdown_table
from pilegrasp_ctrl.study.condition import Condition
from pilegrasp_ctrl.study.run import run_study
from pilegrasp_ctrl.study.store import StudyStore
from script import run_script, seed_range, show_progress
from six_conditions import CONDITIONS, counts
from tray import TRAY_BANDS, tray

SEEDS = (10000, 10040)
"""First seed, and the one after the last."""

SCOOPED: dict[str, Condition] = {"18 light, wall, shovel": grasp("light_sphere", hand=SHOVEL)}
"""The condition of the shovel."""

ALL = CONDITIONS | SCOOPED
"""The seven conditions by name."""


@dataclass(frozen=True, slots=True)
class Band:
    """An uncertain number at the ends of its band.

    Attributes:
        name: What it is, and its values at both ends.
        ends: Scenario keys at both ends.
        conditions: Conditions by name in which it counts.
    """

    name: str
    ends: tuple[Mapping[str, Any], Mapping[str, Any]]
    conditions: Mapping[str, Condition]


def _factor(key: str, low: float, high: float, conditions: Mapping[str, Condition] = ALL) -> Band:
    return Band(f"`{key}` = {low:g}, {high:g}", ({key: low}, {key: high}), conditions)


FACTORS = (
    _factor("hand_model.fingertip_radius", 0.4375, 1.25, CONDITIONS),
    _factor("hand_model.pad_give", 0.667, 1.333, CONDITIONS),
    _factor("hand_model.twist_stiffness", 0.47, 2.2, CONDITIONS),
    _factor("hand_model.bending_stiffness", 0.5, 1.3, CONDITIONS),
    _factor("hand_model.lateral_stiffness", 0.5, 2.0, CONDITIONS),
    _factor("hand_model.closing_moment", 0.7, 1.3, CONDITIONS),
    _factor("hand_model.friction", 1.0, 1.5),
    _factor("pile.friction", 0.75, 1.2),
    _factor("sim.joint_friction", 0.7, 1.3),
    _factor("sim.arm_mass", 0.97, 1.03),
)
"""Numbers with a key: factors at the two ends of their bands, as the hand's README, docs/objects.md and the arm's
robot.toml state or imply them. An end of 1 is the shipped value."""


def bands(folder: Path) -> tuple[Band, ...]:
    """Return all bands; those of the shovel's tray are folders of hands in `folder`."""
    trays = tuple(
        Band(f"tray, {name} = {low}, {high} mm", _hands(folder, name, low, high), SCOOPED)
        for name, (low, high) in TRAY_BANDS.items()
    )
    return FACTORS + trays


def _hands(folder: Path, name: str, low: int, high: int) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
    first, second = ({"hand": f"{tray(folder, **{name: end})}"} for end in (low, high))
    return first, second


def varied(condition: Condition, keys: Mapping[str, Any]) -> Condition:
    """Return a condition with other values of some keys; a factor of 1 is left out."""
    changed = {**condition.varied, **{key: value for key, value in keys.items() if value != 1.0}}
    return Condition(load_scenario("spheres_wall", changed), changed)


@dataclass(frozen=True, slots=True)
class Row:
    """The attempts of a band: counts and rates at both ends by condition, and the largest effect [-]."""

    name: str
    counts: Mapping[str, tuple[str, str]]
    rates: Mapping[str, tuple[float, float, float]]

    @property
    def effect(self) -> float:
        """The largest difference of rates over the conditions [-]."""
        return max(max(three) - min(three) for three in self.rates.values())


def measure(store: StudyStore, band: Band, seeds: range) -> Row:
    """Return the rates at the low end, in the middle and at the high end."""
    cells, rates = {}, {}
    for name, condition in band.conditions.items():
        three = [varied(condition, band.ends[0]), condition, varied(condition, band.ends[1])]
        rows = [store.attempts([(each, seed) for seed in seeds]) for each in three]
        low, middle, high = (sum(row.success for row in some) / max(len(some), 1) for some in rows)
        cells[name], rates[name] = (counts(rows[0]), counts(rows[2])), (low, middle, high)
    return Row(band.name, cells, rates)


def draw(rows: list[Row], file: Path) -> None:
    """Draw for each condition the rates at both ends of every band, and that of the shipped model as a line."""
    figure = Figure(figsize=(11.0, 0.34 * len(rows) + 1.2), layout="constrained")
    panels = figure.subplots(1, len(ALL), sharey=True)
    for axes, name in zip(panels, ALL, strict=True):
        for place, row in enumerate(rows):
            if name in row.rates:
                low, middle, high = row.rates[name]
                axes.plot([low, high], [place, place], color="#999999", linewidth=1.5)
                axes.plot([low], [place], "<", color="#c2571a", markersize=6)
                axes.plot([high], [place], ">", color="#1f5f99", markersize=6)
                axes.axvline(middle, color="#999999", linewidth=0.8)
        axes.set(xlim=(-0.05, 1.05), xticks=(0.0, 0.5, 1.0))
        axes.set_title(name.replace(", ", ",\n"), fontsize=8)
    panels[0].set_yticks(range(len(rows)), [row.name.replace("`", "") for row in rows], fontsize=8)
    panels[0].invert_yaxis()
    figure.supxlabel("held; < low end, > high end, | as shipped", fontsize=8)
    figure.savefig(file, dpi=110)


def main(folder: Path, first: int = SEEDS[0], last: int = SEEDS[1], jobs: int = 1) -> None:
    """Run the missing attempts; print the table, write it and draw it."""
    seeds, every = seed_range(first, last), bands(folder)
    wanted = list(ALL.values())
    wanted += [varied(each, end) for band in every for end in band.ends for each in band.conditions.values()]
    wanted = list({condition.config_hash: condition for condition in wanted}.values())
    attempts = [(condition, seed) for seed in seeds for condition in wanted]
    with run_study(attempts, folder / "study", jobs=jobs, progress=show_progress) as store:
        middle = [counts(store.attempts([(each, seed) for seed in seeds])) for each in ALL.values()]
        rows = sorted((measure(store, band, seeds) for band in every), key=lambda row: -row.effect)
    table = [("as shipped", *middle, "")]
    for row in rows:
        table.append((row.name, *("; ".join(row.counts.get(name, ("-",))) for name in ALL), f"{row.effect:.0%}"))
    head = ("", *ALL, "effect")
    print(markdown_table(head, table))
    with (folder / "sensitivity.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([head, *table])
    draw(rows, folder / "sensitivity.png")


if __name__ == "__main__":
    run_script(main)
