"""Fig. 10: how many objects a pile needs, with and without a support (V-E)."""

from itertools import product

from matplotlib.figure import Figure

from pilegrasp_ctrl.scenarios.paper.charts import legend_above, panels, rate_axis, rates
from pilegrasp_ctrl.scenarios.paper.conditions import HAND, SHOVEL, SUPPORTS, spheres
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import ROBOT, SIMULATED, Experiment, Row
from pilegrasp_ctrl.scenarios.paper.palette import Palette

COUNTS = (3, 5, 10, 15, 20, 25, 30, 60, 90)
MASSES = (0.06, 0.12, 0.18)
ROBOT_COUNTS, ROBOT_MASSES = (5, 18), (0.06, 0.18)
ALONE = spheres(0.18, "none")
"""The paper tried this ten times."""


def draw(evidence: Evidence, palette: Palette) -> Figure:
    """Return a panel for each support: hand solid at the robot's counts, shovel dashed over all."""
    figure, axes = panels(3, 11.0, SUPPORTS)
    colours = dict(zip(MASSES, (palette.first, palette.third, palette.second), strict=True))
    for place, support in zip(axes, SUPPORTS, strict=True):
        for mass, colour in colours.items():
            simulated = [evidence.of(spheres(mass, support, SHOVEL, count)) for count in COUNTS]
            rates(place, COUNTS, simulated, colour, f"shovel, {1000 * mass:.0f} g", simulated=True)
            real = [evidence.of(spheres(mass, support, HAND, count)) for count in ROBOT_COUNTS]
            rates(place, ROBOT_COUNTS, real, colour, f"hand, {1000 * mass:.0f} g", marker="s")
        place.set_xscale("log")
        place.set_xticks((3, 5, 10, 20, 30, 60, 90), ("3", "5", "10", "20", "30", "60", "90"))
        place.minorticks_off()
        place.set_xlabel("objects")
        rate_axis(place)
    legend_above(figure, axes[1], 6)
    return figure


def share(mass: float, support: str, count: int) -> float:
    """Return what a shortened run makes of a cell's attempts: half where cells are judged together."""
    alone = mass == MASSES[0] and support != "none" and count in ROBOT_COUNTS
    return 1.0 if alone else 0.5


EXPERIMENT = Experiment(
    "fig10",
    "Fig. 10: number of objects",
    "More than 85 % already for small piles beside a wall or in a corner; without a support the hand never triggered "
    "(0 of 10), and simulated piles of 60 and more may do without one.",
    (
        *(
            Row(spheres(mass, support, HAND, count), ROBOT)
            for mass, support, count in product(ROBOT_MASSES, ("wall", "corner"), ROBOT_COUNTS)
        ),
        Row(ALONE, 10),
        *(
            Row(spheres(mass, support, SHOVEL, count), SIMULATED, share(mass, support, count))
            for mass, support, count in product(MASSES, SUPPORTS, COUNTS)
        ),
    ),
    draw,
)
