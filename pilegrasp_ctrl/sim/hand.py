"""The simulated hand, with the changes of a scenario's `hand_model`."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from typing import Any

import mujoco
import numpy as np

from ..planning.hand_use import HandUse
from ..robots import description
from ..sections import HandModelConfig
from ..types import Array, MassProperties, Pose
from .contact import END_EFFECTOR_RANK, Surface
from .hand_parts import finger_directions
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
"""Numbers of `robot.toml` that each factor of `hand_model` multiplies."""

REPLACED = {"inflation_stiffness": "pneumatics.inflation_stiffness"}
"""Number of `robot.toml` that a key of `hand_model` replaces. A factor would not do, because the number can be 0."""


def vary(parameters: dict[str, Any], model: HandModelConfig) -> dict[str, Any]:
    """Return a copy of a hand's parameters with the changes of `model`."""
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
"""Functions that add a hand's bodies to a spec, by the hand's name."""


@dataclass(frozen=True)
class Hand:
    """An end-effector: its bodies for a scene, and the numbers for controller and primitives.

    Attributes:
        name: Name as in the scenario key `hand`.
        parameters: Parsed `robot.toml`, with the scenario's factors.
    """

    name: str
    parameters: dict[str, Any] = field(repr=False)

    @classmethod
    def load(cls, name: str, model: HandModelConfig | None = None) -> Hand:
        """Read a hand by name, with the changes of the scenario's `hand_model`, if any.

        Raises:
            ModelError: No hand has this name.
        """
        parameters = description(f"hands/{name}")
        return cls(name, vary(parameters, model) if model else parameters)

    def add_to(self, spec: mujoco.MjSpec, flange: Any) -> None:
        """Mount wrist sensor and hand on the site `flange` of `spec`, as the body `sensor` and its children."""
        body = flange.parent.add_body(name="sensor", pos=flange.pos, quat=flange.quat)
        _BUILDERS[self.name](spec, body, self.parameters)

    def standalone_spec(self) -> mujoco.MjSpec:
        """Return a spec of sensor and hand on a fixed flange."""
        spec = mujoco.MjSpec()
        spec.compiler.degree = False
        self.add_to(spec, spec.worldbody.add_site(name="flange"))
        return spec

    @property
    def contact_geoms(self) -> tuple[str, ...]:
        """Names of the geoms that touch objects and table: all except the shovel's bracket."""
        return tuple(geom.name for geom in self.standalone_spec().geoms if geom.name != "bracket")

    @property
    def controller(self) -> str:
        """Name of the hand's default controller."""
        return str(self.parameters["hand"]["controller"])

    @property
    def theta(self) -> float:
        """Slope of the finger bases (or the scoop's floor) against the table [rad]."""
        return math.radians(self.parameters["hand"]["theta_deg"])

    @cached_property
    def use(self) -> HandUse:
        """The hand's numbers for planning and primitives."""
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
        """Friction and restitution of the hand."""
        return Surface(**self.parameters["surface"], rank=END_EFFECTOR_RANK)

    @property
    def transform_tool_to_flange(self) -> Pose:
        """Pose of the tool frame: x along the fingers, z normal to the palm, origin in the middle of the fingertips."""
        along, normal = finger_directions(self.parameters["hand"]["finger_angle_deg"])
        rotation = np.column_stack([along, np.cross(normal, along), normal])
        return Pose(self.parameters["hand"]["tool_origin"], rotation)

    def outline(self) -> Array:
        """Return balls (n, 4) that span sensor and hand at rest: centre in the tool frame and radius [m]."""
        model = self.standalone_spec().compile()
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        balls = []
        for geom in range(model.ngeom):
            center, half, radius = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:], 0.0
            if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CAPSULE:
                radius = model.geom_size[geom, 0]
            corners = center + (half - radius) * np.array(list(product((-1.0, 1.0), repeat=3)))
            corners = data.geom_xpos[geom] + corners @ data.geom_xmat[geom].reshape(3, 3).T
            balls.append(np.column_stack([corners, np.full(len(corners), radius)]))
        in_flange = np.vstack(balls)
        tool = self.transform_tool_to_flange
        return np.column_stack([(in_flange[:, :3] - tool.translation) @ tool.rotation, in_flange[:, 3]])

    def mass_properties(self) -> MassProperties:
        """Return mass, centre of mass and inertia of sensor and hand at rest, in the flange's axes."""
        model = self.standalone_spec().compile()
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
