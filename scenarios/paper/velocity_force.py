"""Section V-F: heavy spheres in a corner, pushed faster and harder."""

from matplotlib.figure import Figure

from pilegrasp_ctrl.scenarios.paper.charts import categories, legend_above, panels, rate_axis, rates, stated
from pilegrasp_ctrl.scenarios.paper.conditions import grasp
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import ROBOT, Experiment, Row
from pilegrasp_ctrl.scenarios.paper.palette import Palette

USUAL = grasp("heavy_sphere", "corner")
HARDER = grasp("heavy_sphere", "corner", strategy__speed=0.25, strategy__grasp_force=25.0)


def draw(evidence: Evidence, palette: Palette) -> Figure:
    """Return two rates beside the paper's."""
    figure, (axes,) = panels(width=5.0)
    rates(axes, (0, 1), [evidence.of(USUAL), evidence.of(HARDER)], palette.second, "RBO Hand 2")
    stated(axes, (0, 1), (60, 85), palette)
    categories(axes, ("0.10 m/s, 17 N", "0.25 m/s, 25 N"))
    rate_axis(axes)
    legend_above(figure, axes)
    return figure


EXPERIMENT = Experiment(
    "velocity_force",
    "V-F: faster and harder",
    "18 heavy spheres in a corner: 60 % at 0.10 m/s and 17 N, 85 % at 0.25 m/s and 25 N.",
    (Row(USUAL, ROBOT), Row(HARDER, ROBOT)),
    draw,
)
