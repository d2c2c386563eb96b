"""Null models N1 to N4, and grasps with a worse wrist sensor (C16): their conditions, and one chart of rates each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from itertools import product

from matplotlib.figure import Figure

from pilegrasp_ctrl.hand_folder import parameters
from pilegrasp_ctrl.scenarios.paper.charts import Palette, draw_rates, panels, set_rate_axis
from pilegrasp_ctrl.scenarios.paper.conditions import HAND, SHOVEL, grasp
from pilegrasp_ctrl.scenarios.paper.evidence import Evidence
from pilegrasp_ctrl.scenarios.paper.experiment import CELL, USUAL, Experiment, ExperimentCondition
from pilegrasp_ctrl.scenarios.paper.figures_mechanism import NOISY
from pilegrasp_ctrl.scenarios.paper.figures_piles import UNSUPPORTED
from pilegrasp_ctrl.study.condition import Condition

FEW = (1, 2, 3, 5)
"""Numbers of balls of N1."""
AIM_ERRORS = (-0.04, -0.02, 0.0, 0.02, 0.04)
"""Errors of the believed place of the pile, across the push to the wall, in N1 [m]."""
TIP_RADII = (0.0035, 0.005, 0.006, 0.007, 0.00875)
"""Radii of the fingertips in N4 [m]."""


@cache
def few(count: int, support: str, error: float) -> Condition:
    """Return one or some light spheres, met with an error of the aim [m]."""
    keys = {"known__pile_y": error} if error else {}
    return grasp("light_sphere", support, HAND, count, **keys)


def tip_factor(radius: float) -> float:
    """Return the factor of `hand_model.fingertip_radius` for fingertips with a radius [m]."""
    return round(radius / float(parameters(HAND)["fingers"]["radius_tip"]), 4)


def with_tips(radius: float) -> dict[str, float]:
    """Return the key of fingertips with a radius [m]; none for the shipped radius."""
    factor = tip_factor(radius)
    return {} if factor == 1.0 else {"hand_model__fingertip_radius": factor}


FEW_BALLS = {
    f"{count} {'ball' if count == 1 else 'balls'}, {support}, {1000 * error:+.0f} mm": few(count, support, error)
    for support, count, error in product(("wall", "corner"), FEW, AIM_ERRORS)
}
"""Conditions of N1 by name."""
PLATE_PUSHES = {"program": "swap", "strategy__pushing_hand": "plate"}
"""Keys with which a flat plate pushes, and the hand closes where it stopped."""
SWAPPED = {support: grasp("light_sphere", support, **PLATE_PUSHES) for support in ("wall", "corner")}
"""A plate pushes, and the hand closes where it stopped, by support (N2)."""
LOOSE = {
    "18 heavy spheres, no support": (UNSUPPORTED, grasp("heavy_sphere", "none", pile__mutual_contacts=False)),
    **{
        f"{count} light spheres, {support}": (
            grasp("light_sphere", support, HAND, count),
            grasp("light_sphere", support, HAND, count, pile__mutual_contacts=False),
        )
        for count in (5, 18)
        for support in ("wall", "corner")
    },
    "90 heavy spheres, no support, shovel": (
        grasp("heavy_sphere", "none", SHOVEL, 90),
        grasp("heavy_sphere", "none", SHOVEL, 90, pile__mutual_contacts=False),
    ),
}
"""Piles with and without contacts among their objects, by name (N3)."""
TIPS = {
    f"{words}, tips of {1000 * radius:g} mm": grasp(object_model, support, **with_tips(radius), **keys)
    for words, object_model, support, keys in (
        ("heavy, corner, 17 N", "heavy_sphere", "corner", {}),
        ("heavy, corner, 25 N", "heavy_sphere", "corner", {"strategy__speed": 0.25, "strategy__grasp_force": 25.0}),
        ("cylinders, wall", "cylinder", "wall", {}),
    )
    for radius in TIP_RADII
}
"""The fingertip's radius, which has no source, at the conditions of C10 and C1 (N4)."""
WORLDS = {
    "prisms of 20 x 40 x 40 mm": grasp("prism", count=14),
    "spheres, cylinders and cubes": grasp("light_sphere+cylinder+cube", count=18),
    **{f"sizes ± {100 * share:.0f} %": grasp("light_sphere", pile__spread__size=share) for share in (0.05, 0.2)},
    **{f"table {1000 * off:+.0f} mm": grasp("light_sphere", known__table_z=off) for off in (-0.005, 0.005)},
    **{f"wall {1000 * off:+.0f} mm": grasp("light_sphere", known__support_x=off) for off in (-0.01, 0.01)},
    **{f"aim {1000 * off:+.0f} mm": grasp("light_sphere", known__pile_y=off) for off in (-0.02, 0.02)},
    **{f"arm friction x {factor:g}": grasp("light_sphere", sim__joint_friction=factor) for factor in (0.5, 1.5)},
    "hand that does not go on": grasp("light_sphere", hand_model__advance=0.0),
}
"""Worlds that the arm does not know, and other piles, all beside a wall (N4)."""
NOISE = {f"{part.varied['hand']}, {part.varied['support.kind']}, noisy": part for part in NOISY}
"""Grasps with a worse wrist sensor by name (C16)."""


def _chart(conditions: Mapping[str, Condition]) -> Callable[[Evidence, Palette], Figure]:
    """Return a function that draws the rates of conditions one below the other's name."""

    def draw(evidence: Evidence, palette: Palette) -> Figure:
        figure, (axes,) = panels(width=max(6.2, 0.3 * len(conditions)))
        places = list(range(len(conditions)))
        samples = [evidence.sample(condition) for condition in conditions.values()]
        draw_rates(axes, places, samples, palette.first, "hand", joined=False)
        axes.set_xticks(places, list(conditions), rotation=90, fontsize=6)
        axes.set_xlim(-0.6, len(conditions) - 0.4)
        set_rate_axis(axes)
        return figure

    return draw


def _experiment(name: str, title: str, conditions: Mapping[str, Condition], attempts: int) -> Experiment:
    parts = tuple(ExperimentCondition(condition, attempts) for condition in conditions.values())
    return Experiment(name, title, "The paper has no such experiment.", parts, _chart(conditions), extra=True)


LOOSE_ONLY = {name: loose for name, (_, loose) in LOOSE.items()}
"""Piles without contacts among their objects, by name (N3)."""
EXPERIMENTS = (
    _experiment("few_balls", "N1: one ball, and a few", FEW_BALLS, CELL),
    _experiment("flat_plate", "N2: a plate pushes, the hand closes", SWAPPED, USUAL),
    _experiment("loose_pile", "N3: no contacts among the objects", LOOSE_ONLY, USUAL),
    _experiment("brittle_axes", "N4: what may decide without a source", TIPS | WORLDS, USUAL),
    _experiment("noisy_sensor", "C16: three times the noise and 1 N of slow drift", NOISE, USUAL),
)
"""Experiments of this module."""
