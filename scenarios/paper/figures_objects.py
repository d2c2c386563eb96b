"""Fig. 6 to 8: strategies, roundness of the objects, and end-effectors, beside a support (V-B to V-D)."""

from __future__ import annotations

from functools import cache
from itertools import product

from matplotlib.figure import Figure

from pilegrasp_ctrl.hand_folder import parameters
from pilegrasp_ctrl.scenarios.paper.charts import (
    Palette,
    draw_rates,
    draw_stated,
    draw_violins,
    panels,
    put_legend_above,
    set_categories,
    set_rate_axis,
)
from pilegrasp_ctrl.scenarios.paper.conditions import BEST_ANGLES, HAND, OBJECT_NAMES, SHOVEL, grasp
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import CELL, FINE, USUAL, Experiment, ExperimentCondition
from pilegrasp_ctrl.scenarios.paper.printed import printed_percent
from pilegrasp_ctrl.study.condition import Condition

STRATEGY_CASES = tuple(product(BEST_ANGLES, ("wall", "corner")))
"""Object model and support of the six pairs in Fig. 6."""

ROUNDNESS_NAMES = {"light_sphere": "spheres", "cylinder": "cylinders", "cube": "cubes"}
"""Object models of Fig. 7 in the paper's words, roundest first."""
GRID_ANGLES = ((0.0, 0.0), (30.0, -10.0), (30.0, 20.0), (45.0, -20.0))
"""alpha and beta of the grid's cells [deg] (V-C)."""
GRID_COUNTS = (14, 15, 18, 20)
"""Numbers of objects of the grid's cells (V-C)."""
GRID_MASS = 0.06
"""Mass of every object in the grid [kg] (V-C)."""
GRID_KEYS: dict[str, dict[str, str]] = {HAND: {}, SHOVEL: {"pile__variant": "sim"}}
"""Further keys of the grid by end-effector."""


@cache
def strategy_pair(object_model: str, support: str) -> tuple[Condition, Condition]:
    """Return the conditions of the pile-based and of the object-based strategy."""
    pile_based = grasp(object_model, support, angles=BEST_ANGLES[object_model])
    return pile_based, grasp(object_model, support, strategy__kind="object")


@cache
def roundness_grid(object_model: str, hand: str) -> tuple[Condition, ...]:
    """Return the 16 conditions of an object model.

    The shovel stands for the paper's simulation, so it meets the simulated objects, which share one friction.
    """
    mass = None if object_model == "light_sphere" else GRID_MASS
    return tuple(
        grasp(object_model, "wall", hand, count, mass, angles, **GRID_KEYS[hand])
        for angles, count in product(GRID_ANGLES, GRID_COUNTS)
    )


@cache
def with_other_controller(hand: str) -> Condition:
    """Return light spheres with the controller that is not the hand's default."""
    shipped = parameters(hand)["hand"]["controller"]
    (other,) = {"operational_space", "impedance"} - {shipped}
    return grasp("light_sphere", "wall", hand, controller__kind=other)


def draw_strategies(evidence: Evidence, palette: Palette) -> Figure:
    """Draw two rates for each of the six cases."""
    figure, (axes,) = panels()
    pile, chosen = zip(*(map(evidence.sample, strategy_pair(*case)) for case in STRATEGY_CASES), strict=True)
    places = range(len(STRATEGY_CASES))
    draw_rates(axes, [x - 0.12 for x in places], pile, palette.first, "pile-based", joined=False)
    draw_rates(axes, [x + 0.12 for x in places], chosen, palette.second, "object-based", joined=False, marker="s")
    names = [OBJECT_NAMES[object_model].replace(" ", "\n") for object_model, _ in STRATEGY_CASES]
    set_categories(axes, [f"{name}\n{support}" for name, (_, support) in zip(names, STRATEGY_CASES, strict=True)])
    set_rate_axis(axes)
    put_legend_above(figure, axes)
    return figure


def draw_roundness(evidence: Evidence, palette: Palette) -> Figure:
    """Draw the densities of the cells' rates: hand solid, shovel dashed."""
    figure, (axes,) = panels()
    colours = (palette.first, palette.third, palette.fourth)
    for hand, offset, simulated in ((HAND, -0.2, False), (SHOVEL, 0.2, True)):
        samples = [[evidence.sample(cell) for cell in roundness_grid(name, hand)] for name in ROUNDNESS_NAMES]
        data = [[sample.rate for sample in cells if sample.n] for cells in samples]
        draw_violins(axes, [x + offset for x in range(3)], data, colours, simulated)
    axes.plot([], [], color=palette.ink, label="RBO Hand 2, mean")
    axes.plot([], [], color=palette.ink, linestyle="--", label="shovel, mean")
    axes.hlines([80, 80, 50], [-0.45, 0.55, 1.55], [0.45, 1.45, 2.45], color=palette.paper, linestyle=":")
    axes.plot([], [], color=palette.paper, linestyle=":", label="paper: above 80 %, cubes below 50 %")
    set_categories(axes, list(ROUNDNESS_NAMES.values()))
    set_rate_axis(axes, "success of a cell [%]")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper left", ncols=3)
    return figure


def draw_end_effectors(evidence: Evidence, palette: Palette) -> Figure:
    """Draw the rate of each end-effector for each object model."""
    figure, (axes,) = panels()
    for hand, offset, colour, name, simulated in (
        (HAND, -0.1, palette.first, "RBO Hand 2", False),
        (SHOVEL, 0.1, palette.second, "shovel", True),
    ):
        samples = [evidence.sample(grasp(object_model, "wall", hand)) for object_model in OBJECT_NAMES]
        places = [x + offset for x in range(len(OBJECT_NAMES))]
        draw_rates(axes, places, samples, colour, name, simulated=simulated, joined=False)
    axes.vlines(
        [-0.2, 0.8, 1.8], 95, 100, color=palette.paper, linewidth=4, alpha=0.4, label="paper, hand: 95 to 100 %"
    )
    draw_stated(axes, [0.2], [printed_percent("shovel-light")], palette, "paper, real shovel: 85 %")
    set_categories(axes, list(OBJECT_NAMES.values()))
    set_rate_axis(axes)
    put_legend_above(figure, axes)
    return figure


FIG06 = Experiment(
    "fig06",
    "Fig. 6: no need to choose an object",
    "The object-based strategy never outperforms the pile-based one; beside a wall, heavy spheres show a large gap.",
    tuple(ExperimentCondition(condition, FINE) for case in STRATEGY_CASES for condition in strategy_pair(*case)),
    draw_strategies,
)
"""Rates of the pile-based and the object-based strategy (V-B)."""
FIG07 = Experiment(
    "fig07",
    "Fig. 7: roundness helps",
    "Means over the grid: at least 80 % for spheres and cylinders, below 50 % for cubes; simulation in the same order.",
    tuple(
        ExperimentCondition(cell, CELL)
        for hand in (HAND, SHOVEL)
        for object_model in ROUNDNESS_NAMES
        for cell in roundness_grid(object_model, hand)
    ),
    draw_roundness,
)
"""Rates over a grid of angles and counts, by roundness of the objects (V-C)."""
FIG08 = Experiment(
    "fig08",
    "Fig. 8: hand and shovel",
    "Hand: 95 to 100 % for round objects. Real shovel: 85 % for light spheres, poor otherwise, and far below the "
    "simulated one. Cubes: poor for both.",
    (
        *(
            ExperimentCondition(grasp(object_model, "wall", HAND), USUAL if object_model == "cube" else FINE)
            for object_model in OBJECT_NAMES
        ),
        *(ExperimentCondition(grasp(object_model, "wall", SHOVEL)) for object_model in OBJECT_NAMES),
        *(ExperimentCondition(with_other_controller(hand)) for hand in (HAND, SHOVEL)),
    ),
    draw_end_effectors,
)
"""Rates of both end-effectors by object model, and of both controllers (V-D)."""
EXPERIMENTS = (FIG06, FIG07, FIG08)
"""Experiments of this module, in the order of the paper."""
