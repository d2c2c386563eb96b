"""Section III and Fig. 2: how the objects move while they are pushed."""

from matplotlib.figure import Figure

from pilegrasp_ctrl.scenarios.paper.charts import categories, legend_above, panels
from pilegrasp_ctrl.scenarios.paper.conditions import SUPPORTS, grasp
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import ROBOT, Experiment, Row
from pilegrasp_ctrl.scenarios.paper.palette import Palette

PUSHED = {support: grasp("light_sphere", support) for support in SUPPORTS}


def draw(evidence: Evidence, palette: Palette) -> Figure:
    """Return the speed at which objects before the hand come nearer, and at which the others move away, by support."""
    figure, (axes,) = panels(width=5.6)
    for name, aside, colour, label in (
        ("approach_speed", -0.12, palette.first, "inside the funnel: toward the hand"),
        ("spread_speed", 0.12, palette.fourth, "outside: away from it"),
    ):
        found = [evidence.of(PUSHED[support]).measures("motion", name) for support in SUPPORTS]
        boxes = [[1000.0 * speed for speed in speeds] for speeds in found]
        for place, speeds in enumerate(boxes):
            axes.plot([place + aside] * len(speeds), speeds, "o", color=colour, markersize=4, alpha=0.5)
            if speeds:
                mean = sum(speeds) / len(speeds)
                axes.plot([place + aside - 0.09, place + aside + 0.09], [mean, mean], color=colour)
        axes.plot([], [], "o-", color=colour, markersize=4, label=label)
    axes.axhline(0.0, color=palette.soft, linewidth=0.8)
    categories(axes, SUPPORTS)
    axes.set_ylabel("mean speed in a push [mm/s]")
    axes.grid(axis="y")
    legend_above(figure, axes)
    return figure


EXPERIMENT = Experiment(
    "motion_pattern",
    "Fig. 2: the motion pattern",
    "Objects in front of the hand are pushed toward it, the others spread; a support narrows the spread.",
    tuple(Row(condition, ROBOT) for condition in PUSHED.values()),
    draw,
)
