"""What a scenario's `hand_model` does to the numbers of a hand's `robot.toml`."""

from __future__ import annotations

import copy
from typing import Any

from ..sections import HandModelConfig

SCALED = {
    "bending_stiffness": ("pneumatics.bending_stiffness",),
    "lateral_stiffness": ("pneumatics.lateral_stiffness",),
    "damping": ("pneumatics.bending_damping", "pneumatics.lateral_damping"),
    "closing_moment": ("pneumatics.closing_moment", "pneumatics.thumb_closing_moment"),
    "time_constant": ("pneumatics.time_constant",),
    "fingertip_radius": ("fingers.radius_tip",),
    "preshape": ("use.preshape",),
    "friction": ("surface.lateral",),
    "restitution": ("surface.restitution",),
    "sensor_mass": ("sensor.mass",),
}
"""Which numbers each factor multiplies."""

REPLACED = {"inflation_stiffness": "pneumatics.inflation_stiffness"}
"""Which number stands where a factor would have nothing to multiply."""


def varied(parameters: dict[str, Any], model: HandModelConfig) -> dict[str, Any]:
    """Return the parameters of a hand with those changed that `model` names; the argument stays as it is."""
    result = copy.deepcopy(parameters)
    for change in model.changed():
        value = getattr(model, change)
        for name in SCALED.get(change, ()):
            table, _, key = name.partition(".")
            result[table][key] *= value
        if change in REPLACED:
            table, _, key = REPLACED[change].partition(".")
            result[table][key] = value
    return result
