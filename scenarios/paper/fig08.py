"""Fig. 8: a soft hand against a rigid shovel, beside a wall; and both under either controller (V-D)."""

from matplotlib.figure import Figure

from pilegrasp_ctrl.scenarios.paper.charts import categories, legend_above, panels, rate_axis, rates, stated
from pilegrasp_ctrl.scenarios.paper.conditions import HAND, SHOVEL, grasp
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import ROBOT, SIMULATED, Experiment, Row
from pilegrasp_ctrl.scenarios.paper.palette import Palette
from pilegrasp_ctrl.study.condition import Condition

KINDS = {"light_sphere": "light spheres", "heavy_sphere": "heavy spheres", "cylinder": "cylinders", "cube": "cubes"}


def swapped(hand: str) -> Condition:
    """Return light spheres under the controller that the hand does not use by itself."""
    other = "impedance" if hand == HAND else "operational_space"
    return grasp("light_sphere", "wall", hand, controller__kind=other)


def draw(evidence: Evidence, palette: Palette) -> Figure:
    """Return the rate of each end-effector for each kind of object."""
    figure, (axes,) = panels()
    for hand, aside, colour, name in (
        (HAND, -0.1, palette.first, "RBO Hand 2"),
        (SHOVEL, 0.1, palette.second, "shovel"),
    ):
        samples = [evidence.of(grasp(kind, "wall", hand)) for kind in KINDS]
        places = [x + aside for x in range(len(KINDS))]
        rates(axes, places, samples, colour, name, simulated=hand == SHOVEL, joined=False)
    axes.vlines(
        [-0.2, 0.8, 1.8], 95, 100, color=palette.paper, linewidth=4, alpha=0.4, label="paper, hand: 95 to 100 %"
    )
    stated(axes, [0.2], [85], palette, "paper, real shovel: 85 %")
    categories(axes, list(KINDS.values()))
    rate_axis(axes)
    legend_above(figure, axes)
    return figure


EXPERIMENT = Experiment(
    "fig08",
    "Fig. 8: hand and shovel",
    "Hand: 95 to 100 % for round objects. Real shovel: 85 % for light spheres, poor otherwise, and far below the "
    "simulated one. Cubes: poor for both.",
    (
        *(Row(grasp(kind, "wall", HAND), ROBOT) for kind in KINDS),
        *(Row(grasp(kind, "wall", SHOVEL), SIMULATED) for kind in KINDS),
        *(Row(swapped(hand), ROBOT) for hand in (HAND, SHOVEL)),
    ),
    draw,
)
