"""The conditions of the paper's experiments in its own words; equal ones are the same object of study everywhere."""

from functools import cache
from typing import Any

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.study.condition import Condition

HAND, SHOVEL = "rbo_hand2", "shovel"
SUPPORTS = ("none", "wall", "corner")
COUNTS = {"light_sphere": 18, "heavy_sphere": 18, "cylinder": 14, "cube": 14}
BEST = {"light_sphere": (0.0, 0.0), "heavy_sphere": (0.0, 0.0), "cylinder": (45.0, -20.0)}
"""alpha and beta with which the paper's pile-based strategy did best [deg] (V-B)."""
SHOVEL_WIDTH = 0.12
BALL, FRAME = 0.054, 0.25


@cache
def grasp(
    kind: str,
    support: str = "wall",
    hand: str = HAND,
    count: int | None = None,
    mass: float | None = None,
    angles: tuple[float, float] = (0.0, 0.0),
    **keys: Any,
) -> Condition:
    """Return a condition: kind and number of objects, their mass [kg], support, hand, (alpha, beta) [deg], other keys.

    `keys` are dotted with `__` in place of the dot.
    """
    varied: dict[str, Any] = {"hand": hand, "support.kind": support, "pile.object": kind}
    varied["pile.count"] = COUNTS[kind] if count is None else count
    if mass is not None:
        varied["pile.mass"] = mass
    if angles != (0.0, 0.0):
        varied["strategy.alpha_deg"], varied["strategy.beta_deg"] = angles
    varied |= {key.replace("__", "."): value for key, value in keys.items()}
    return Condition(load_scenario("spheres_wall", varied), varied)


def spheres(mass: float, support: str, hand: str = HAND, count: int = 18) -> Condition:
    """Return tennis balls of a mass [kg]: hollow ones up to 60 g, and heavier ones filled with sand."""
    kind = "light_sphere" if mass <= 0.06 else "heavy_sphere"
    own = {"light_sphere": 0.06, "heavy_sphere": 0.18}[kind]
    return grasp(kind, support, hand, count, None if mass == own else mass)


@cache
def sized(ratio: float) -> Condition:
    """Return 18 light spheres in a corner for the shovel, `ratio` times as wide as it; the frame grows with them."""
    scale = round(ratio * SHOVEL_WIDTH / BALL, 4)
    keys = {} if scale == 1.0 else {"pile__scale": scale, "pile__frame_size": round(FRAME * scale, 4)}
    return grasp("light_sphere", "corner", SHOVEL, **keys)
