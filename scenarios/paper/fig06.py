"""Fig. 6: the pile-based strategy against one that chooses an object and looks at the pile (V-B)."""

from itertools import product

from matplotlib.figure import Figure

from pilegrasp_ctrl.scenarios.paper.charts import categories, legend_above, panels, rate_axis, rates
from pilegrasp_ctrl.scenarios.paper.conditions import BEST, grasp
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import ROBOT, Experiment, Row
from pilegrasp_ctrl.scenarios.paper.palette import Palette
from pilegrasp_ctrl.study.condition import Condition

CASES = tuple(product(BEST, ("wall", "corner")))
WORDS = {"light_sphere": "light\nspheres", "heavy_sphere": "heavy\nspheres", "cylinder": "cylinders"}


def pair(kind: str, support: str) -> tuple[Condition, Condition]:
    """Return the conditions of the pile-based and of the object-based strategy."""
    return grasp(kind, support, angles=BEST[kind]), grasp(kind, support, strategy__kind="object")


def draw(evidence: Evidence, palette: Palette) -> Figure:
    """Return two rates for each of the six cases."""
    figure, (axes,) = panels()
    pile, chosen = zip(*(map(evidence.of, pair(*case)) for case in CASES), strict=True)
    places = range(len(CASES))
    rates(axes, [x - 0.12 for x in places], pile, palette.first, "pile-based", joined=False)
    rates(axes, [x + 0.12 for x in places], chosen, palette.second, "object-based", joined=False, marker="s")
    categories(axes, [f"{WORDS[kind]}\n{support}" for kind, support in CASES])
    rate_axis(axes)
    legend_above(figure, axes)
    return figure


EXPERIMENT = Experiment(
    "fig06",
    "Fig. 6: no need to choose an object",
    "The object-based strategy never outperforms the pile-based one; beside a wall, heavy spheres show a large gap.",
    tuple(Row(condition, ROBOT) for case in CASES for condition in pair(*case)),
    draw,
)
