"""Fig. 7: the rounder the object, the better, over orientations of the hand and numbers of objects (V-C)."""

from itertools import product

from matplotlib.figure import Figure

from pilegrasp_ctrl.scenarios.paper.charts import categories, panels, rate_axis, violins
from pilegrasp_ctrl.scenarios.paper.conditions import HAND, SHOVEL, grasp
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import ROBOT, SIMULATED, Experiment, Row
from pilegrasp_ctrl.scenarios.paper.palette import Palette
from pilegrasp_ctrl.study.condition import Condition

ANGLES = ((0.0, 0.0), (30.0, -10.0), (30.0, 20.0), (45.0, -20.0))
COUNTS = (14, 15, 18, 20)
KINDS = {"light_sphere": "spheres", "cylinder": "cylinders", "cube": "cubes"}
MASS = 0.06
CELL = 0.25
"""A shortened run makes a quarter of its attempts in each of the 16 cells, which are judged by their mean."""


def grid(kind: str, hand: str) -> list[Condition]:
    """Return the 16 conditions of a kind of object; all weigh 60 g."""
    mass = None if kind == "light_sphere" else MASS
    return [grasp(kind, "wall", hand, count, mass, angles) for angles, count in product(ANGLES, COUNTS)]


def draw(evidence: Evidence, palette: Palette) -> Figure:
    """Return the densities of the cells' rates: hand solid, shovel dashed."""
    figure, (axes,) = panels()
    colours = (palette.first, palette.third, palette.fourth)
    for hand, aside in ((HAND, -0.2), (SHOVEL, 0.2)):
        samples = [[evidence.of(cell) for cell in grid(kind, hand)] for kind in KINDS]
        data = [[sample.rate for sample in cells if sample.n] for cells in samples]
        violins(axes, [x + aside for x in range(3)], data, colours, hand == SHOVEL)
    axes.plot([], [], color=palette.ink, label="RBO Hand 2, mean")
    axes.plot([], [], color=palette.ink, linestyle="--", label="shovel, mean")
    axes.hlines([80, 80, 50], [-0.45, 0.55, 1.55], [0.45, 1.45, 2.45], color=palette.paper, linestyle=":")
    axes.plot([], [], color=palette.paper, linestyle=":", label="paper: above 80 %, cubes below 50 %")
    categories(axes, list(KINDS.values()))
    rate_axis(axes, "success of a cell [%]")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper left", ncols=3)
    return figure


EXPERIMENT = Experiment(
    "fig07",
    "Fig. 7: roundness helps",
    "Means over the grid: at least 80 % for spheres and cylinders, below 50 % for cubes; simulation in the same order.",
    tuple(
        Row(cell, number, CELL)
        for hand, number in ((HAND, ROBOT), (SHOVEL, SIMULATED))
        for kind in KINDS
        for cell in grid(kind, hand)
    ),
    draw,
)
