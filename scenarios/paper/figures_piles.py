"""Fig. 9 to 11 and section V-F: size, number and mass of the objects, and faster and harder pushes (V-D to V-F)."""

from __future__ import annotations

from itertools import product

from matplotlib.figure import Figure

from pilegrasp_ctrl.scenarios.paper.charts import (
    Palette,
    draw_rates,
    draw_stated,
    panels,
    put_legend_above,
    set_categories,
    set_rate_axis,
)
from pilegrasp_ctrl.scenarios.paper.conditions import (
    HAND,
    HEAVY_MASS,
    LIGHT_MASS,
    SHOVEL,
    SUPPORTS,
    grasp,
    sized,
    spheres,
)
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import CELL, USUAL, Experiment, ExperimentCondition
from pilegrasp_ctrl.scenarios.paper.printed import printed_percent

SIZE_RATIOS = (0.3, 0.45, 0.6, 0.75, 0.9, 1.1, 1.3, 1.5)
"""Diameter of an object over the width of the shovel (Fig. 9)."""
COUNTS = (3, 5, 10, 15, 20, 25, 30, 60, 90)
"""Numbers of objects of Fig. 10."""
COUNT_MASSES = (0.06, 0.12, 0.18)
"""Masses of an object in Fig. 10 [kg]."""
MASSES = (0.03, 0.06, 0.12, 0.18, 0.36, 0.72)
"""Masses of an object in Fig. 11 [kg]."""
ROBOT_COUNTS, ROBOT_MASSES = (5, 18), (LIGHT_MASS, HEAVY_MASS)
"""Numbers of objects and masses [kg] of the paper's robot experiments."""
UNSUPPORTED = spheres(HEAVY_MASS, "none")
"""18 heavy spheres without a support; the paper's robot made ten attempts."""
USUAL_PUSH = grasp("heavy_sphere", "corner")
"""Heavy spheres in a corner at 0.10 m/s and 17 N."""
HARD_PUSH = grasp("heavy_sphere", "corner", strategy__speed=0.25, strategy__grasp_force=25.0)
"""Heavy spheres in a corner at 0.25 m/s and 25 N."""


def draw_sizes(evidence: Evidence, palette: Palette) -> Figure:
    """Draw the success, and the number of objects held, over the ratio."""
    figure, (left, right) = panels(2)
    samples = [evidence.sample(sized(ratio)) for ratio in SIZE_RATIOS]
    draw_rates(left, SIZE_RATIOS, samples, palette.first, "shovel, simulated", simulated=True)
    set_rate_axis(left)
    known = [(ratio, sample.mean_grasped) for ratio, sample in zip(SIZE_RATIOS, samples, strict=True) if sample.n]
    right.plot([x for x, _ in known], [held for _, held in known], "--o", color=palette.first, mfc="none")
    right.set(ylabel="objects held, mean", ylim=(0.0, None))
    right.grid(axis="y")
    for axes in (left, right):
        axes.set_xlabel("diameter of an object / width of the shovel")
    return figure


def draw_counts(evidence: Evidence, palette: Palette) -> Figure:
    """Draw a panel for each support: hand solid at the robot's counts, shovel dashed over all."""
    figure, axes = panels(3, 11.0, SUPPORTS)
    colours = dict(zip(COUNT_MASSES, (palette.first, palette.third, palette.second), strict=True))
    for place, support in zip(axes, SUPPORTS, strict=True):
        for mass, colour in colours.items():
            simulated = [evidence.sample(spheres(mass, support, SHOVEL, count)) for count in COUNTS]
            draw_rates(place, COUNTS, simulated, colour, f"shovel, {1000 * mass:.0f} g", simulated=True)
            real = [evidence.sample(spheres(mass, support, HAND, count)) for count in ROBOT_COUNTS]
            draw_rates(place, ROBOT_COUNTS, real, colour, f"hand, {1000 * mass:.0f} g", marker="s")
        place.set_xscale("log")
        place.set_xticks((3, 5, 10, 20, 30, 60, 90), ("3", "5", "10", "20", "30", "60", "90"))
        place.minorticks_off()
        place.set_xlabel("objects")
        set_rate_axis(place)
    put_legend_above(figure, axes[1], 6)
    return figure


def draw_masses(evidence: Evidence, palette: Palette) -> Figure:
    """Draw a line for each support: hand solid, shovel dashed."""
    figure, (axes,) = panels()
    colours = dict(zip(SUPPORTS, (palette.fourth, palette.first, palette.third), strict=True))
    for support, colour in colours.items():
        simulated = [evidence.sample(spheres(mass, support, SHOVEL)) for mass in MASSES]
        draw_rates(axes, [1000 * mass for mass in MASSES], simulated, colour, f"shovel, {support}", simulated=True)
        real = [evidence.sample(spheres(mass, support)) for mass in ROBOT_MASSES]
        draw_rates(axes, [1000 * mass for mass in ROBOT_MASSES], real, colour, f"hand, {support}", marker="s")
    axes.set_xscale("log")
    axes.set_xticks([1000 * mass for mass in MASSES], [f"{1000 * mass:.0f}" for mass in MASSES])
    axes.minorticks_off()
    axes.set_xlabel("mass of an object [g]")
    set_rate_axis(axes)
    put_legend_above(figure, axes, 3)
    return figure


def draw_pushes(evidence: Evidence, palette: Palette) -> Figure:
    """Draw two rates beside the paper's."""
    figure, (axes,) = panels(width=5.0)
    samples = [evidence.sample(USUAL_PUSH), evidence.sample(HARD_PUSH)]
    draw_rates(axes, (0, 1), samples, palette.second, "RBO Hand 2")
    draw_stated(axes, (0, 1), [printed_percent(name) for name in ("push-usual", "push-hard")], palette)
    set_categories(axes, ("0.10 m/s, 17 N", "0.25 m/s, 25 N"))
    set_rate_axis(axes)
    put_legend_above(figure, axes)
    return figure


def _count_attempts(mass: float) -> int:
    """Return the attempts of the hand at a cell of Fig. 10: C7 reads the light spheres cell by cell."""
    return USUAL if mass == COUNT_MASSES[0] else CELL


FIG09 = Experiment(
    "fig09",
    "Fig. 9: size of the objects",
    "Success and the number of objects depend on the ratio of the object's size to the end-effector's.",
    tuple(ExperimentCondition(sized(ratio)) for ratio in SIZE_RATIOS),
    draw_sizes,
)
"""Rate and number of held objects over the size ratio (V-D)."""
FIG10 = Experiment(
    "fig10",
    "Fig. 10: number of objects",
    "More than 85 % already for small piles beside a wall or in a corner; without a support the hand never triggered "
    "(0 of 10), and simulated piles of 60 and more may do without one.",
    (
        *(
            ExperimentCondition(spheres(mass, support, HAND, count), _count_attempts(mass))
            for mass, support, count in product(ROBOT_MASSES, ("wall", "corner"), ROBOT_COUNTS)
        ),
        ExperimentCondition(UNSUPPORTED),
        *(
            ExperimentCondition(spheres(mass, support, SHOVEL, count), CELL)
            for mass, support, count in product(COUNT_MASSES, SUPPORTS, COUNTS)
        ),
    ),
    draw_counts,
)
"""Rates over the number of objects (V-E)."""
FIG11 = Experiment(
    "fig11",
    "Fig. 11: mass of the objects",
    "Lighter objects are easier to grasp where the pile is supported; supports hinder heavy ones."
    " Without one, nothing works.",
    (
        *(ExperimentCondition(spheres(mass, support)) for mass, support in product(ROBOT_MASSES, ("wall", "corner"))),
        *(ExperimentCondition(spheres(mass, support, SHOVEL)) for mass, support in product(MASSES, SUPPORTS)),
    ),
    draw_masses,
)
"""Rates over the mass of the objects (V-F)."""
VELOCITY_FORCE = Experiment(
    "velocity_force",
    "V-F: faster and harder",
    "18 heavy spheres in a corner: 60 % at 0.10 m/s and 17 N, 85 % at 0.25 m/s and 25 N.",
    (ExperimentCondition(USUAL_PUSH), ExperimentCondition(HARD_PUSH)),
    draw_pushes,
)
"""Rates at two speeds and forces of the push (V-F)."""
EXPERIMENTS = (FIG09, FIG10, FIG11, VELOCITY_FORCE)
"""Experiments of this module, in the order of the paper."""
