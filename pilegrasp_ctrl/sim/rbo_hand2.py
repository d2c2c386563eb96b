"""The RBO Hand 2 as MuJoCo bodies: fingers are chains of sprung joints, and inflation is a moment in all of them.

A PneuFlex finger bends with constant curvature under pressure; equal moments in equal springs give the same shape. One
hinge at the base models the finger's sideways compliance, another one its torsion. If inflation stiffens the finger,
the moment decreases with the finger's total bend, like the pressure of an enclosed mass of air. The soft part of the
palm that carries the thumb bends about one hinge, and is not inflated.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from ..types import Array
from ..vectors import in_order, norm
from .hand_parts import finger_directions, frame_quaternion

SILICONE = (0.93, 0.80, 0.62, 1.0)
"""Colour of fingers and palm (rgba)."""

SCAFFOLD = (0.35, 0.37, 0.42, 1.0)
"""Colour of the rigid part of the palm (rgba)."""

LATERAL_RANGE = 0.35
"""Largest sideways angle of a finger at its base in both directions [rad]; chosen."""

TWIST_RANGE = 0.6
"""Largest twist of a finger at its base in both directions [rad]; chosen."""

BEND_RANGE = (-0.9, 1.6)
"""Range of each bending joint [rad], chosen."""

PALM_RANGE = (-0.5, 1.2)
"""Range of the hinge of the palm's web [rad], chosen."""

JOINT_ARMATURE = 2e-5
"""Inertia added to every finger joint [kg·m²], chosen: the bare 5 g fingertip is too light for contacts at 1 ms."""


def add_rbo_hand2(spec: mujoco.MjSpec, root: Any, parameters: dict[str, Any]) -> None:
    """Add the hand to the sensor's body `root` in the flange's frame, with the numbers of `robot.toml`."""
    fingers, thumb, pneumatics = parameters["fingers"], parameters["thumb"], parameters["pneumatics"]
    along, palm_normal = finger_directions(parameters["hand"]["finger_angle_deg"])
    web, hinge = _add_palm(root, parameters["palm"], along, pneumatics)
    for name in fingers["base"]:
        _add_finger(spec, root, name, fingers, fingers["base"][name], fingers["tip"][name], palm_normal, pneumatics)
        _add_inflation(spec, name, fingers["segments"], pneumatics["closing_moment"], pneumatics)
    base, tip = thumb["base"] - hinge, thumb["tip"] - hinge
    _add_finger(spec, web, "thumb", thumb, base, tip, thumb["bend_toward"], pneumatics)
    _add_inflation(spec, "thumb", thumb["segments"], pneumatics["thumb_closing_moment"], pneumatics)


def _add_palm(root: Any, palm: dict[str, Any], along: Array, pneumatics: dict[str, Any]) -> tuple[Any, Array]:
    """Add the palm; return the body `palm_web`, which carries the thumb, and the position of its hinge.

    The hinge is parallel to the fingers, at the edge of the web. Its angle grows as the thumb approaches them.
    """
    hinge = np.array(palm["web_center"]) - [0.0, palm["web_half_size"][1], 0.0]
    rigid, web = root.add_body(name="palm"), root.add_body(name="palm_web", pos=hinge)
    _add_hinge(web, "palm_bend", along, "bending", PALM_RANGE, pneumatics)
    volumes = {part: math.prod(palm[f"{part}_half_size"]) for part in ("scaffold", "pad", "web")}
    for part, volume in volumes.items():
        body, origin = (web, hinge) if part == "web" else (rigid, np.zeros(3))
        body.add_geom(
            name=f"palm_{part}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=palm[f"{part}_center"] - origin,
            size=palm[f"{part}_half_size"],
            mass=palm["mass"] * volume / in_order(volumes.values()),
            rgba=SCAFFOLD if part == "scaffold" else SILICONE,
            contype=0,
            conaffinity=0,
        )
    return web, hinge


def _add_finger(
    spec: mujoco.MjSpec,
    root: Any,
    name: str,
    shape: dict[str, Any],
    base: ArrayLike,
    tip: ArrayLike,
    bend_toward: Any,
    pneumatics: dict[str, Any],
) -> None:
    """Add the chain `{name}_1..n`: joints `{name}_lateral` and `{name}_twist` at the base, and `{name}_bend_i`.

    The bending angles are positive when closing.
    """
    count = shape["segments"]
    direction = np.subtract(tip, base)
    length = norm(direction) / count
    radii = np.linspace(shape["radius_base"], shape["radius_tip"], count)
    parent = root
    for i in range(count):
        first, last = i == 0, i == count - 1
        placement = (
            {"pos": base, "quat": frame_quaternion(direction, bend_toward)} if first else {"pos": [length, 0, 0]}
        )
        body = parent.add_body(name=f"{name}_{i + 1}", **placement)
        if first:
            _add_hinge(body, f"{name}_lateral", [0, 0, 1], "lateral", (-LATERAL_RANGE, LATERAL_RANGE), pneumatics)
            _add_hinge(body, f"{name}_twist", [1, 0, 0], "twist", (-TWIST_RANGE, TWIST_RANGE), pneumatics)
        _add_hinge(body, f"{name}_bend_{i + 1}", [0, -1, 0], "bending", BEND_RANGE, pneumatics)
        body.add_geom(
            name=f"{name}_{i + 1}",
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=[0.0, 0.0, 0.0, length - (radii[i] if last else 0.0), 0.0, 0.0],
            size=[radii[i], 0.0, 0.0],
            mass=shape["mass"] / count,
            rgba=SILICONE,
            contype=0,
            conaffinity=0,
        )
        parent = body


def _add_hinge(
    body: Any, name: str, axis: ArrayLike, mode: str, limits: tuple[float, float], pneumatics: dict[str, Any]
) -> None:
    """Add a sprung hinge with the stiffness and damping of `mode`: "bending", "lateral" or "twist"."""
    joint = body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis, range=limits, limited=True)
    joint.stiffness[0] = pneumatics[f"{mode}_stiffness"]
    joint.damping[0] = pneumatics[f"{mode}_damping"]
    joint.armature = JOINT_ARMATURE


def _add_inflation(spec: mujoco.MjSpec, name: str, segments: int, moment: float, pneumatics: dict[str, Any]) -> None:
    """Add the actuator `{name}`: closure in [0, 1], first-order in time, the same moment in every bending joint.

    At inflation a and mean joint angle q the moment is `a (M (1 + r) - r k q)`. M is `moment`, k is the joint's spring,
    and r is the share that inflation adds to the spring. In free space, full inflation bends each joint by M / k for
    every r.
    """
    tendon = spec.add_tendon(name=name)
    for i in range(segments):
        tendon.wrap_joint(f"{name}_bend_{i + 1}", 1.0)
    actuator = spec.add_actuator(
        name=name,
        target=name,
        trntype=mujoco.mjtTrn.mjTRN_TENDON,
        dyntype=mujoco.mjtDyn.mjDYN_FILTEREXACT,
        gaintype=mujoco.mjtGain.mjGAIN_AFFINE,
        biastype=mujoco.mjtBias.mjBIAS_NONE,
        ctrllimited=True,
        ctrlrange=(0.0, 1.0),
    )
    actuator.dynprm[0] = pneumatics["time_constant"]
    share = pneumatics["inflation_stiffness"]
    actuator.gainprm[:2] = [moment * (1.0 + share), -share * pneumatics["bending_stiffness"] / segments]
