"""Table I and section V-H: orders of four from a bin that is tilted by 5 degrees; an attempt here is a whole order."""

from functools import cache

from matplotlib.figure import Figure

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.scenarios.paper.charts import categories, legend_above, panels
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import ROBOT, Experiment, Row
from pilegrasp_ctrl.scenarios.paper.palette import Palette
from pilegrasp_ctrl.scenarios.paper.sample import Sample
from pilegrasp_ctrl.study.condition import Condition

KINDS = {
    "light_sphere": "light spheres",
    "heavy_sphere": "heavy spheres",
    "cylinder": "cylinders",
    "lime_net": "nets of limes",
    "apple": "apples",
}
COUNTS = {"lime_net": 15}
PAPER = dict(zip(KINDS.values(), (4.3, 5.0, 9.0, 5.6, 7.6), strict=True))


@cache
def order(kind: str) -> Condition:
    """Return the condition of an order: 18 objects, or five nets of three."""
    varied = {"pile.object": kind, "pile.count": COUNTS.get(kind, 18)}
    return Condition(load_scenario("bin_picking", varied), varied)


def attempts(sample: Sample) -> list[int]:
    """Return how many attempts each order took, complete or not."""
    return [len(row.result["attempts"]) for row in sample.rows if row.result is not None and "attempts" in row.result]


def draw(evidence: Evidence, palette: Palette) -> Figure:
    """Return every order's attempts and their mean beside the paper's R."""
    figure, (axes,) = panels(width=5.6)
    for place, kind in enumerate(KINDS):
        found = attempts(evidence.of(order(kind)))
        axes.plot([place - 0.1] * len(found), found, "o", color=palette.first, markersize=4, alpha=0.4)
        if found:
            axes.plot([place - 0.25, place + 0.05], 2 * [sum(found) / len(found)], color=palette.first)
    axes.plot([], [], "o-", color=palette.first, markersize=4, label="orders and their mean")
    axes.plot(range(len(KINDS)), list(PAPER.values()), "D", mfc="none", mec=palette.paper, label="paper")
    axes.axhline(4.0, color=palette.soft, linewidth=0.8, linestyle=":")
    categories(axes, [name.replace(" ", "\n", 1) for name in KINDS.values()])
    axes.set(ylabel="attempts for four objects", ylim=(0.0, None))
    axes.grid(axis="y")
    legend_above(figure, axes)
    return figure


EXPERIMENT = Experiment(
    "table1",
    "Table I: orders of four from a tilted bin",
    "R = 4.3 light spheres, 5 heavy spheres, 9 cylinders, 5.6 limes, 7.6 apples; 4 is perfect. Three sessions each.",
    tuple(Row(order(kind), ROBOT, 0.75) for kind in KINDS),
    draw,
)
