"""Fig. 9: how large the objects are, compared with the end-effector; light spheres in a corner, shovel (V-D)."""

from matplotlib.figure import Figure

from pilegrasp_ctrl.scenarios.paper.charts import panels, rate_axis, rates
from pilegrasp_ctrl.scenarios.paper.conditions import sized
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import SIMULATED, Experiment, Row
from pilegrasp_ctrl.scenarios.paper.palette import Palette

RATIOS = (0.3, 0.45, 0.6, 0.75, 0.9, 1.1, 1.3, 1.5)


def draw(evidence: Evidence, palette: Palette) -> Figure:
    """Return the success, and the number of objects held, over the ratio."""
    figure, (left, right) = panels(2)
    samples = [evidence.of(sized(ratio)) for ratio in RATIOS]
    rates(left, RATIOS, samples, palette.first, "shovel, simulated", simulated=True)
    rate_axis(left)
    known = [(ratio, sample.mean_grasped) for ratio, sample in zip(RATIOS, samples, strict=True) if sample.n]
    right.plot([x for x, _ in known], [held for _, held in known], "--o", color=palette.first, mfc="none")
    right.set(ylabel="objects held, mean", ylim=(0.0, None))
    right.grid(axis="y")
    for axes in (left, right):
        axes.set_xlabel("diameter of an object / width of the shovel")
    return figure


EXPERIMENT = Experiment(
    "fig09",
    "Fig. 9: size of the objects",
    "Success and the number of objects depend on the ratio of the object's size to the end-effector's.",
    tuple(Row(sized(ratio), SIMULATED) for ratio in RATIOS),
    draw,
)
