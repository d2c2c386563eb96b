"""Parts that all hands share: the wrist sensor's body, the directions of the fingers, and the frame of a part."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from ..types import Array
from ..vectors import inner, norm

DARK = (0.16, 0.17, 0.19, 1.0)
"""Colour of sensor and bracket (rgba)."""


def finger_directions(angle_deg: float) -> tuple[Array, Array]:
    """Return the direction of the fingers (3,) and the palm's normal (3,), in the flange's frame.

    Args:
        angle_deg: Angle from the flange's axis to the fingers, toward the negative x axis of the flange [deg].
    """
    angle = math.radians(angle_deg)
    along = np.array([-math.sin(angle), 0.0, math.cos(angle)])
    normal = np.array([math.cos(angle), 0.0, math.sin(angle)])
    return along, normal


def frame_quaternion(x_axis: ArrayLike, z_hint: ArrayLike) -> Array:
    """Return the quaternion (wxyz) of the frame with the given x axis and the z axis nearest to `z_hint`."""
    x = np.asarray(x_axis, dtype=float) / norm(x_axis)
    z = np.asarray(z_hint, dtype=float) - inner(z_hint, x) * x
    z /= norm(z)
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.column_stack([x, np.cross(z, x), z]).ravel())
    return quaternion


def add_wrist_sensor(spec: mujoco.MjSpec, body: Any, parameters: dict[str, Any]) -> None:
    """Add the housing, the site `wrist_sensor` at the flange, and the two MuJoCo sensors to the body `sensor`.

    The MuJoCo sensors measure between flange and sensor body, so the housing is a part of the tool.
    """
    top, bottom, radius = parameters["top"], parameters["bottom"], parameters["radius"]
    body.add_geom(
        name="sensor",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[radius, (top - bottom) / 2.0, 0.0],
        pos=[0.0, 0.0, (top + bottom) / 2.0],
        mass=parameters["mass"],
        rgba=DARK,
        contype=0,
        conaffinity=0,
    )
    body.add_site(name="wrist_sensor", size=[0.005, 0.005, 0.005])
    for name, sensor_type in (
        ("wrist_force", mujoco.mjtSensor.mjSENS_FORCE),
        ("wrist_torque", mujoco.mjtSensor.mjSENS_TORQUE),
    ):
        spec.add_sensor(name=name, type=sensor_type, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="wrist_sensor")
