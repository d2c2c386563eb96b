"""The rig on which contacts are measured: a hand and an object that are fixed, and one object that moves."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from ...planning.layout import make_layout
from ...sections import PileConfig, SimulationConfig, SupportConfig
from ...sim.contact import Rule
from ...sim.hand import Hand
from ...sim.object_model import ObjectModel
from ...sim.scene import add_surroundings, new_spec
from ...types import STANDARD_GRAVITY, Array, Pose

SHIPPED_STEP, SHIPPED_RULE = SimulationConfig().timestep, SimulationConfig().contact_rule
"""Physics step [s] and contact rule of the shipped scenarios."""

GRAVITY = -STANDARD_GRAVITY[2]
"""Gravity [m/s²]."""

TOOL = Pose(np.array([0.5, 0.0, 0.8]))
"""Pose of the tool frame [m]: in the air, the palm or the scoop's floor facing up; chosen."""

FIXED_OBJECT = np.array([0.7, -0.4, 0.5])
"""Position (3,) of the fixed object [m]; chosen clear of hand and wall."""


@dataclass(frozen=True, slots=True)
class Spot:
    """A point on a surface.

    Attributes:
        geom: Name of the geom.
        point: (3,) Position [m].
        normal: (3,) Outward unit normal.
    """

    geom: str
    point: Array
    normal: Array


SIDE_WALLS = {"scoop_left", "scoop_right"}
"""Parts of a hand without contacts: they would catch a wide object before it comes to the floor between them."""


@dataclass(frozen=True, slots=True, eq=False)
class ContactRig:
    """A scene with one moving object, made by the functions that make an attempt's scene.

    Attributes:
        object_model: Model of both objects; `object_0` is fixed, `object_1` is the only body that moves.
        hand: Hand, fixed in the air with its joints removed.
        model: Compiled model; each measurement sets its gravity.
        spots: Spots by name: "table", "wall", "object", and those of the hand.
    """

    object_model: ObjectModel
    hand: Hand
    model: mujoco.MjModel
    spots: dict[str, Spot]

    @classmethod
    def build(
        cls, object_model: ObjectModel, hand: Hand, timestep: float = SHIPPED_STEP, rule: Rule = SHIPPED_RULE
    ) -> ContactRig:
        """Compile the rig for an object and a hand at a physics step [s]."""
        spec = new_spec(timestep)
        flange = TOOL @ hand.transform_tool_to_flange.inverse()
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, flange.rotation.ravel())
        hand.add_to(spec, spec.worldbody.add_site(name="flange", pos=flange.translation, quat=quaternion))
        for movable in (*spec.actuators, *spec.tendons, *spec.joints):
            spec.delete(movable)
        # A net would tie the two objects together.
        object_model = replace(object_model, net=None)
        layout = make_layout(SupportConfig(), PileConfig(count=2), object_model.diameter)
        add_surroundings(spec, hand, object_model, 2, layout, rule)
        for pair in [pair for pair in spec.pairs if {pair.geomname1, pair.geomname2} & SIDE_WALLS]:
            spec.delete(pair)
        spec.delete(spec.body("object_0").joints[0])
        spec.body("object_0").pos = FIXED_OBJECT
        # A sleeping body would not notice that gravity turns.
        spec.option.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        model = spec.compile()
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        vertical = np.array([0.0, 0.0, 1.0])
        spots = {
            "table": Spot("table", np.array([0.6, 0.3, 0.0]), vertical),
            "wall": Spot("wall", np.array([layout.support_distance, 0.0, 0.08]), np.array([-1.0, 0.0, 0.0])),
            "object": Spot("object_0", FIXED_OBJECT + extent(object_model, 2) * vertical, vertical),
            **(_shovel_spots(hand) if hand.use.scoop_angle > 0.0 else _palm_spots(data)),
        }
        return cls(object_model, hand, model, spots)

    def place(self, spot: Spot, height: float, axis: int = 2) -> mujoco.MjData:
        """Return a state with the object at rest over a spot, and turn gravity toward the spot.

        Args:
            spot: Spot on which the object would land.
            height: Gap between object and surface [m].
            axis: Axis of the object that is normal to the surface: 2, or 0 for an object on its side.
        """
        normal = spot.normal
        self.lean(spot, 0.0)
        data = mujoco.MjData(self.model)
        data.qpos[:3] = spot.point + (height + extent(self.object_model, axis)) * normal
        along = tangent(spot)
        across = np.cross(along, normal)
        # An object on its side has its axis 2 across the slope, so that it can roll down.
        rotation = np.column_stack([across, along, normal] if axis == 2 else [normal, along, -across])
        mujoco.mju_mat2Quat(data.qpos[3:7], np.ascontiguousarray(rotation).ravel())
        return data

    def lean(self, spot: Spot, slope: float) -> None:
        """Tilt gravity from the normal of a spot by `slope` [rad] along `tangent(spot)`."""
        self.model.opt.gravity[:] = GRAVITY * (math.sin(slope) * tangent(spot) - math.cos(slope) * spot.normal)


def tangent(spot: Spot) -> Array:
    """Return a unit vector (3,) along the surface, horizontal."""
    along = np.cross(spot.normal, [1.0, 0.0, 0.0] if abs(spot.normal[0]) < 0.9 else [0.0, 0.0, 1.0])
    return np.asarray(along / np.linalg.norm(along))


def extent(model: ObjectModel, axis: int) -> float:
    """Return the distance [m] from an object's centre to its surface along its axis 0 or 2."""
    if model.shape == "cylinder":
        return model.half_size[0] if axis == 0 else model.half_size[1]
    return model.half_size[min(axis, len(model.half_size) - 1)]


def bouncing(model: ObjectModel, restitution: float) -> ObjectModel:
    """Return the object model with another restitution."""
    return replace(model, surface=replace(model.surface, restitution=restitution))


def bouncing_hand(hand: Hand, restitution: float) -> Hand:
    """Return the hand with another restitution."""
    surface = {**hand.parameters["surface"], "restitution": restitution}
    return replace(hand, parameters={**hand.parameters, "surface": surface})


def _shovel_spots(hand: Hand) -> dict[str, Spot]:
    scoop = hand.parameters["scoop"]
    length, thickness = scoop["length"], scoop["thickness"]
    floor = TOOL.translation + TOOL.rotation @ [-0.5 * length, 0.0, thickness]
    back = TOOL.translation + TOOL.rotation @ [thickness - length, 0.0, 0.7 * scoop["back_height"]]
    return {
        "shovel floor": Spot("scoop_floor", floor, TOOL.rotation[:, 2]),
        "shovel back": Spot("scoop_back", back, TOOL.rotation[:, 0]),
    }


def _palm_spots(data: Any) -> dict[str, Spot]:
    pad, finger = data.geom("palm_pad"), data.geom("middle_3")
    axes, along = pad.xmat.reshape(3, 3), finger.xmat.reshape(3, 3)[:, 2]
    size = data.model.geom("palm_pad").size
    # 4 mm off the middle, so that a ball is clear of the fingers.
    palm = pad.xpos + axes @ [0.004, 0.0, size[2]]
    normal = TOOL.rotation[:, 2] - along * along.dot(TOOL.rotation[:, 2])
    normal /= np.linalg.norm(normal)
    radius = data.model.geom("middle_3").size[0]
    return {
        "palm": Spot("palm_pad", palm, axes[:, 2]),
        "finger": Spot("middle_3", finger.xpos + radius * normal, normal),
    }
