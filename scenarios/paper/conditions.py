"""The conditions of the paper's experiments, in the paper's words; equal conditions share their attempts everywhere."""

from __future__ import annotations

from functools import cache
from typing import Any

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.hand_folder import parameters
from pilegrasp_ctrl.study.condition import Condition

HAND, SHOVEL = "rbo_hand2", "shovel"
"""Names of the two end-effectors in a scenario."""
HAND_NAMES = {HAND: "hand", SHOVEL: "shovel"}
"""End-effectors in the paper's words."""
SUPPORTS = ("none", "wall", "corner")
"""Supports of the pile in the paper, as a scenario names them."""
COUNTS = {"light_sphere": 18, "heavy_sphere": 18, "cylinder": 14, "cube": 14}
"""Number of objects in a pile by object model (V-A)."""
BEST_ANGLES = {"light_sphere": (0.0, 0.0), "heavy_sphere": (0.0, 0.0), "cylinder": (45.0, -20.0)}
"""Best alpha and beta of the paper's pile-based strategy by object model [deg] (V-B)."""
OBJECT_NAMES = {
    "light_sphere": "light spheres",
    "heavy_sphere": "heavy spheres",
    "cylinder": "cylinders",
    "cube": "cubes",
}
"""Object models in the paper's words."""
LIGHT_MASS, HEAVY_MASS = 0.06, 0.18
"""Mass of a light and of a heavy sphere [kg]; `scenarios/objects`."""
SHOVEL_WIDTH: float = parameters(SHOVEL)["scoop"]["width"]
"""Width of the shovel [m]."""
BALL_DIAMETER = 0.054
"""Diameter of the spheres [m]; `scenarios/objects`."""
FRAME_SIZE = 0.25
"""Inner side of the frame of 18 spheres, which the layout chooses by their number [m]."""


@cache
def grasp(
    object_model: str,
    support: str = "wall",
    hand: str = HAND,
    count: int | None = None,
    mass: float | None = None,
    angles: tuple[float, float] = (0.0, 0.0),
    **keys: Any,
) -> Condition:
    """Return a condition for a single grasp.

    Args:
        object_model: Name of the object.
        support: One of `SUPPORTS`.
        hand: End-effector.
        count: Number of objects; None takes the number in `COUNTS`.
        mass: Mass of an object [kg]; None takes the mass in its file.
        angles: Angles alpha and beta [deg].
        keys: Other scenario keys, with `__` in place of the dot.
    """
    varied: dict[str, Any] = {"hand": hand, "support.kind": support, "pile.object": object_model}
    varied["pile.count"] = COUNTS[object_model] if count is None else count
    if mass is not None:
        varied["pile.mass"] = mass
    if angles != (0.0, 0.0):
        varied["strategy.alpha_deg"], varied["strategy.beta_deg"] = angles
    varied |= {key.replace("__", "."): value for key, value in keys.items()}
    return Condition(load_scenario("spheres_wall", varied), varied)


def spheres(mass: float, support: str, hand: str = HAND, count: int = 18) -> Condition:
    """Return tennis balls of a mass [kg]: hollow ones up to 60 g, and heavier ones filled with sand."""
    object_model = "light_sphere" if mass <= LIGHT_MASS else "heavy_sphere"
    file_mass = {"light_sphere": LIGHT_MASS, "heavy_sphere": HEAVY_MASS}[object_model]
    return grasp(object_model, support, hand, count, None if mass == file_mass else mass)


@cache
def sized(ratio: float) -> Condition:
    """Return 18 light spheres in a corner, `ratio` times as wide as the shovel; the frame grows with the spheres."""
    scale = round(ratio * SHOVEL_WIDTH / BALL_DIAMETER, 4)
    keys = {} if scale == 1.0 else {"pile__scale": scale, "pile__frame_size": round(FRAME_SIZE * scale, 4)}
    return grasp("light_sphere", "corner", SHOVEL, **keys)
