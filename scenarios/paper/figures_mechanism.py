"""Fig. 2 and Table I: how the objects move while they are pushed (III), and orders from a tilted bin (V-H)."""

from __future__ import annotations

from functools import cache
from typing import Any

from matplotlib.figure import Figure

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.scenarios.paper.charts import Palette, panels, put_legend_above, set_categories
from pilegrasp_ctrl.scenarios.paper.conditions import HAND, OBJECT_NAMES, SHOVEL, SUPPORTS, grasp
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import Experiment, ExperimentCondition
from pilegrasp_ctrl.scenarios.paper.printed import printed_numbers
from pilegrasp_ctrl.study.condition import Condition

PUSHED = {support: grasp("light_sphere", support) for support in SUPPORTS}
"""Conditions of Fig. 2 by support."""
FLAT = {support: grasp("light_sphere", support, "plate") for support in SUPPORTS}
"""The same piles, pushed by a flat plate of the hand's width, by support."""
NOISY = tuple(
    grasp("light_sphere", support, hand, sensor__force_noise=0.3, sensor__torque_noise=0.012, sensor__slow_drift=1.0)
    for hand in (HAND, SHOVEL)
    for support in ("wall", "corner")
)
"""Grasps with three times the wrist sensor's noise (docs/sensor.md) and 1 N of slow drift (C16)."""
ORDERS = 15
"""Number of orders for each object model and operator."""

ORDER_NAMES = {name: OBJECT_NAMES[name] for name in ("light_sphere", "heavy_sphere", "cylinder")} | {
    "lime_net": "nets of limes",
    "apple": "apples",
}
"""Object models of the orders in words."""
PAPER_ATTEMPTS = {name: float(printed_numbers()[f"order-{kind}"]["mean"]) for kind, name in ORDER_NAMES.items()}
"""Mean number of attempts for an order of four, the paper's R (Table I)."""


OPERATORS = ("alternates", "sees")
"""Operators of the orders. The one that is judged comes first: it knows the bin's pose and the wrist sensor alone; the
other one sees the pose of every object."""


@cache
def order_condition(object_model: str, operator: str = "sees") -> Condition:
    """Return the condition of an order: 18 objects, or five nets of three, in a bin that is tilted by 5 degrees.

    An attempt of this condition is a whole order.
    """
    varied: dict[str, Any] = {"pile.object": object_model, "pile.count": 15 if object_model == "lime_net" else 18}
    scenario = load_scenario("bin_picking", varied | {"order.operator": operator})
    return Condition(scenario, varied if operator == "sees" else varied | {"order.operator": operator})


def draw_motion(evidence: Evidence, palette: Palette) -> Figure:
    """Draw by support how fast objects before the hand approach it, and how fast the others move away."""
    figure, (axes,) = panels(width=5.6)
    for name, offset, colour, label in (
        ("approach speed", -0.12, palette.first, "inside the funnel: toward the hand"),
        ("spread speed", 0.12, palette.fourth, "outside: away from it"),
    ):
        found = [evidence.sample(PUSHED[support]).numbers(name) for support in SUPPORTS]
        boxes = [[1000.0 * speed for speed in speeds] for speeds in found]
        for place, speeds in enumerate(boxes):
            axes.plot([place + offset] * len(speeds), speeds, "o", color=colour, markersize=4, alpha=0.5)
            if speeds:
                mean = sum(speeds) / len(speeds)
                axes.plot([place + offset - 0.09, place + offset + 0.09], [mean, mean], color=colour)
        axes.plot([], [], "o-", color=colour, markersize=4, label=label)
    axes.axhline(0.0, color=palette.soft, linewidth=0.8)
    set_categories(axes, SUPPORTS)
    axes.set_ylabel("mean speed in a push [mm/s]")
    axes.grid(axis="y")
    put_legend_above(figure, axes)
    return figure


def draw_orders(evidence: Evidence, palette: Palette) -> Figure:
    """Draw every order's attempts and their mean beside the paper's R."""
    figure, (axes,) = panels(width=5.6)
    for place, object_model in enumerate(ORDER_NAMES):
        found = [
            float(x) for x in evidence.sample(order_condition(object_model, OPERATORS[0])).numbers("order attempts")
        ]
        axes.plot([place - 0.1] * len(found), found, "o", color=palette.first, markersize=4, alpha=0.4)
        if found:
            axes.plot([place - 0.25, place + 0.05], 2 * [sum(found) / len(found)], color=palette.first)
    axes.plot([], [], "o-", color=palette.first, markersize=4, label="orders and their mean")
    stated = list(PAPER_ATTEMPTS.values())
    axes.plot(range(len(ORDER_NAMES)), stated, "D", mfc="none", mec=palette.paper, label="paper")
    axes.axhline(4.0, color=palette.soft, linewidth=0.8, linestyle=":")
    set_categories(axes, [name.replace(" ", "\n", 1) for name in ORDER_NAMES.values()])
    axes.set(ylabel="attempts for four objects", ylim=(0.0, None))
    axes.grid(axis="y")
    put_legend_above(figure, axes)
    return figure


MOTION_PATTERN = Experiment(
    "motion_pattern",
    "Fig. 2: the motion pattern",
    "Objects in front of the hand are pushed toward it, the others spread; a support narrows the spread.",
    tuple(ExperimentCondition(condition) for condition in (*PUSHED.values(), *FLAT.values())),
    draw_motion,
)
"""Motion of the objects during the push, by support (III)."""
TABLE1 = Experiment(
    "table1",
    "Table I: orders of four from a tilted bin",
    "R = 4.3 light spheres, 5 heavy spheres, 9 cylinders, 5.6 limes, 7.6 apples; 4 is perfect. Three sessions each.",
    tuple(
        ExperimentCondition(order_condition(object_model, operator), ORDERS)
        for operator in OPERATORS
        for object_model in ORDER_NAMES
    ),
    draw_orders,
)
"""Attempts for an order, by object model (V-H)."""
EXPERIMENTS = (MOTION_PATTERN, TABLE1)
"""Experiments of this module, in the order of the paper."""
