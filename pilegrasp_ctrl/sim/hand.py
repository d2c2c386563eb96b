"""A hand as the simulation sees it, and what a scenario's `hand_model` changes in it."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import mujoco
import numpy as np

from ..planning.hand_use import HandUse
from ..robots import description
from ..sections import HandModelConfig
from ..types import Array, MassProperties, Pose
from .contact import Surface
from .rbo_hand2 import add_rbo_hand2
from .shovel import add_shovel

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


_BUILDERS: dict[str, Callable[[mujoco.MjSpec, Any, dict[str, Any]], None]] = {
    "rbo_hand2": add_rbo_hand2,
    "shovel": add_shovel,
}


@dataclass(frozen=True)
class Hand:
    """What the scene, the controller and the primitives need to know of an end-effector.

    Attributes:
        name: as in the scenario key `hand`.
        parameters: the parsed `robot.toml`, with the scenario's factors.
    """

    name: str
    parameters: dict[str, Any]

    @classmethod
    def load(cls, name: str, model: HandModelConfig | None = None) -> Hand:
        """Read a hand by name, and multiply the numbers that the scenario varies, if any.

        Raises:
            ModelError: where there is no such hand.
        """
        parameters = description(f"hands/{name}")
        return cls(name, varied(parameters, model) if model else parameters)

    def add_to(self, spec: mujoco.MjSpec, flange: Any) -> None:
        """Mount the wrist sensor and the hand on the site `flange` of `spec`, as the body `sensor` and its children."""
        body = flange.parent.add_body(name="sensor", pos=flange.pos, quat=flange.quat)
        _BUILDERS[self.name](spec, body, self.parameters)

    def alone(self) -> mujoco.MjSpec:
        """Return a spec of sensor and hand on a fixed flange."""
        spec = mujoco.MjSpec()
        spec.compiler.degree = False
        self.add_to(spec, spec.worldbody.add_site(name="flange"))
        return spec

    @property
    def contact_geoms(self) -> tuple[str, ...]:
        """Names of the geoms that touch objects and table: all but the shovel's bracket."""
        return tuple(geom.name for geom in self.alone().geoms if geom.name != "bracket")

    @property
    def controller(self) -> str:
        """The controller that suits the hand, unless the scenario names one."""
        return str(self.parameters["hand"]["controller"])

    @property
    def theta(self) -> float:
        """Slope of the finger bases (or the scoop's floor) against the table [rad]."""
        return math.radians(self.parameters["hand"]["theta_deg"])

    @cached_property
    def use(self) -> HandUse:
        """What planning and primitives must know of the hand."""
        numbers = self.parameters["use"]
        return HandUse(
            theta=self.theta,
            press_depth=numbers["press_depth"],
            normal_force=numbers["normal_force"],
            preshape=numbers["preshape"],
            closing_time=numbers["closing_time"],
            advance=numbers["advance"],
            scoop_angle=math.radians(self.parameters["hand"].get("scoop_angle_deg", 0.0)),
            heel=numbers["heel"],
            outline=self.outline(),
        )

    @property
    def surface(self) -> Surface:
        """Friction and restitution of the hand's skin."""
        return Surface(**self.parameters["surface"], rank=2)

    @property
    def transform_tool_to_flange(self) -> Pose:
        """The tool frame: x along the fingers, z normal to the palm, origin in the middle of the fingertips."""
        angle = math.radians(self.parameters["hand"]["finger_angle_deg"])
        along = np.array([-math.sin(angle), 0.0, math.cos(angle)])
        normal = np.array([math.cos(angle), 0.0, math.sin(angle)])
        rotation = np.column_stack([along, np.cross(normal, along), normal])
        return Pose(self.parameters["hand"]["tool_origin"], rotation)

    def outline(self) -> Array:
        """Return balls that span sensor and hand at rest (n, 4): middle in the tool frame and radius [m]."""
        model = self.alone().compile()
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        balls = []
        for geom in range(model.ngeom):
            middle, half, radius = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:], 0.0
            if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CAPSULE:
                radius = model.geom_size[geom, 0]
            corners = middle + (half - radius) * np.array(list(product((-1.0, 1.0), repeat=3)))
            corners = data.geom_xpos[geom] + corners @ data.geom_xmat[geom].reshape(3, 3).T
            balls.append(np.column_stack([corners, np.full(len(corners), radius)]))
        in_flange = np.vstack(balls)
        tool = self.transform_tool_to_flange
        return np.column_stack([(in_flange[:, :3] - tool.translation) @ tool.rotation, in_flange[:, 3]])

    def mass_properties(self) -> MassProperties:
        """Return mass, centre of mass and inertia of sensor and hand at rest, in the flange's axes."""
        model = self.alone().compile()
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mass = model.body_mass[1:]
        center = mass @ data.xipos[1:] / mass.sum()
        inertia = np.zeros((3, 3))
        for body in range(1, model.nbody):
            rotation = data.ximat[body].reshape(3, 3)
            offset = data.xipos[body] - center
            inertia += rotation @ np.diag(model.body_inertia[body]) @ rotation.T
            inertia += model.body_mass[body] * (offset @ offset * np.eye(3) - np.outer(offset, offset))
        return MassProperties(float(mass.sum()), center, 0.5 * (inertia + inertia.T))
