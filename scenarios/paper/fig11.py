"""Fig. 11: how heavy the objects are (V-F)."""

from itertools import product

from matplotlib.figure import Figure

from pilegrasp_ctrl.scenarios.paper.charts import legend_above, panels, rate_axis, rates
from pilegrasp_ctrl.scenarios.paper.conditions import SHOVEL, SUPPORTS, spheres
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import ROBOT, SIMULATED, Experiment, Row
from pilegrasp_ctrl.scenarios.paper.palette import Palette

MASSES = (0.03, 0.06, 0.12, 0.18, 0.36, 0.72)
ROBOT_MASSES = (0.06, 0.18)


def draw(evidence: Evidence, palette: Palette) -> Figure:
    """Return a line for each support: hand solid, shovel dashed."""
    figure, (axes,) = panels()
    colours = dict(zip(SUPPORTS, (palette.fourth, palette.first, palette.third), strict=True))
    for support, colour in colours.items():
        simulated = [evidence.of(spheres(mass, support, SHOVEL)) for mass in MASSES]
        rates(axes, [1000 * mass for mass in MASSES], simulated, colour, f"shovel, {support}", simulated=True)
        real = [evidence.of(spheres(mass, support)) for mass in ROBOT_MASSES]
        rates(axes, [1000 * mass for mass in ROBOT_MASSES], real, colour, f"hand, {support}", marker="s")
    axes.set_xscale("log")
    axes.set_xticks([1000 * mass for mass in MASSES], [f"{1000 * mass:.0f}" for mass in MASSES])
    axes.minorticks_off()
    axes.set_xlabel("mass of an object [g]")
    rate_axis(axes)
    legend_above(figure, axes, 3)
    return figure


EXPERIMENT = Experiment(
    "fig11",
    "Fig. 11: mass of the objects",
    "Lighter objects are easier to grasp where the pile is supported; supports hinder heavy ones."
    " Without one, nothing works.",
    (
        *(Row(spheres(mass, support), ROBOT) for mass, support in product(ROBOT_MASSES, ("wall", "corner"))),
        *(
            Row(spheres(mass, support, SHOVEL), SIMULATED, 0.5 if support == "none" else 1.0)
            for mass, support in product(MASSES, SUPPORTS)
        ),
    ),
    draw,
)
