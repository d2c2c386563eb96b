"""What the pile adds: success, and which object, over count, aim, support, hand or plate, and contacts among objects.

Usage: python docs/studies/pile_adds.py FOLDER [EACH JOBS]

FOLDER becomes a study, as `pilegrasp sweep` makes it; attempts that it holds are not run again, so a run may be
interrupted. Every cell has EACH attempts on seeds 30000 and up. The table is written to FOLDER/pile_adds.csv, and
FOLDER/pile_adds.png shows the rates over the count.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from pilegrasp_ctrl.scenarios.paper.conditions import HAND, grasp
from pilegrasp_ctrl.scenarios.paper.evidence import Sample
from pilegrasp_ctrl.scenarios.paper.figures_nulls import PLATE_PUSHES
from pilegrasp_ctrl.scenarios.paper.run import MEASURE
from pilegrasp_ctrl.statistics import markdown_table, wilson
from pilegrasp_ctrl.study.condition import Condition
from pilegrasp_ctrl.study.run import run_study
from script import run_script, seed_range, show_progress

FIRST_SEED = 30000
"""First seed of every cell."""

COUNTS = (1, 2, 3, 5, 10, 18)
"""Numbers of light balls."""

CORNER_COUNTS = (1, 5, 18)
"""Numbers of light balls in a corner."""

AIMS = (0.0, 0.02, 0.04)
"""Errors of the believed place of the pile, across the push [m]."""

FORCES = (3.0, 9.0, 17.0)
"""F_grasp without a support [N]; the last one is that of all other cells."""

COLORS = {0.0: "#1f5f99", 0.02: "#c2571a", 0.04: "#5b8c3a"}
"""Colour of each error of the aim."""


@dataclass(frozen=True, slots=True)
class Cell:
    """One cell: a number of balls, the aim, the support, what pushes, whether balls touch one another, and F_grasp."""

    count: int
    aim: float
    support: str
    pusher: str = "hand"
    contacts: bool = True
    force: float = FORCES[-1]

    @property
    def condition(self) -> Condition:
        """The condition of the cell's attempts."""
        keys: dict[str, Any] = {} if self.pusher == "hand" else dict(PLATE_PUSHES)
        if self.aim:
            keys["known__pile_y"] = self.aim
        if not self.contacts:
            keys["pile__mutual_contacts"] = False
        if self.force != FORCES[-1]:
            keys["strategy__grasp_force"] = self.force
        return grasp("light_sphere", self.support, HAND, self.count, **keys)


def cells() -> Iterator[Cell]:
    """Yield every cell; one ball has no contacts that could be switched off."""
    places = [*product(("none", "wall"), COUNTS), *product(("corner",), CORNER_COUNTS)]
    for (support, count), aim, pusher in product(places, AIMS, ("hand", "plate")):
        for contacts in (True, False) if count > 1 else (True,):
            yield Cell(count, aim, support, pusher, contacts)
    for count, force in product(COUNTS, FORCES[:-1]):
        yield Cell(count, 0.0, "none", force=force)


def row(cell: Cell, sample: Sample) -> tuple[Any, ...]:
    """Return a line of the table: the cell, its attempts, and how many held, triggered, held one, named the object."""
    low, high = wilson(sample.successes, sample.n) if sample.n else (0.0, 1.0)
    held = sample.successes
    chance = sample.mean("chance")
    return (
        *(cell.count, f"{1e3 * cell.aim:.0f}", cell.support, cell.pusher),
        *("on" if cell.contacts else "off", f"{cell.force:g}", sample.n, held, f"{low:.2f}", f"{high:.2f}"),
        *(sample.count("triggered"), held - sample.count("several"), sample.count("foreseen")),
        "" if chance is None else f"{chance:.2f}",
    )


HEAD = (
    *("count", "aim [mm]", "support", "pushes", "contacts", "F_grasp [N]", "n", "held", "from", "to"),
    *("F_grasp reached", "one alone", "named before", "by chance"),
)
"""Columns of the table; "from" and "to" are the 95 % Wilson interval of the rate."""


def draw(found: dict[Cell, Sample], file: Path) -> None:
    """Draw the rate over the count: a panel for each support and pusher, dashed without contacts among the balls."""
    supports, pushers = ("none", "wall", "corner"), ("hand", "plate")
    figure = Figure(figsize=(9.0, 5.2), layout="constrained")
    for (line, pusher), (column, support) in product(enumerate(pushers), enumerate(supports)):
        axes = figure.add_subplot(len(pushers), len(supports), line * len(supports) + column + 1)
        counts = CORNER_COUNTS if support == "corner" else COUNTS
        for aim, contacts in product(AIMS, (True, False)):
            points = [(n, found[cell]) for n in counts if (cell := Cell(n, aim, support, pusher, contacts)) in found]
            points = [(n, sample) for n, sample in points if sample.n]
            style, label = ("o-", f"aim off by {1e3 * aim:.0f} mm") if contacts else ("o--", None)
            axes.plot(
                [n for n, _ in points], [s.rate for _, s in points], style, color=COLORS[aim], label=label, markersize=4
            )
        axes.set(xscale="log", ylim=(-0.03, 1.03), title=f"{pusher} pushes, support: {support}")
        axes.set_xticks(counts, [str(n) for n in counts])
        axes.minorticks_off()
        if line == column == 0:
            axes.legend(frameon=False, fontsize=8)
    figure.supxlabel("balls; dashed: balls do not touch one another")
    figure.supylabel("held")
    figure.savefig(file, dpi=110)


def main(folder: Path, each: int = 20, jobs: int = 2) -> None:
    """Run the missing attempts; print and write the table, and draw it."""
    wanted = {cell: cell.condition for cell in cells()}
    seeds = seed_range(FIRST_SEED, FIRST_SEED + each)
    attempts = [(condition, seed) for seed in seeds for condition in wanted.values()]
    with run_study(attempts, folder, jobs=jobs, measure=MEASURE, progress=show_progress) as store:
        found = {
            cell: Sample.of(store.attempts([(condition, seed) for seed in seeds])) for cell, condition in wanted.items()
        }
    rows = [row(cell, sample) for cell, sample in found.items()]
    print(markdown_table(HEAD, [tuple(map(str, line)) for line in rows]))
    with (folder / "pile_adds.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([HEAD, *rows])
    draw(found, folder / "pile_adds.png")


if __name__ == "__main__":
    run_script(main)
