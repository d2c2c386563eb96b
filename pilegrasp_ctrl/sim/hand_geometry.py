"""What follows from the compiled bodies of a hand at rest: outline, width, heel, mass and inertia."""

from __future__ import annotations

import itertools
from collections.abc import Container
from typing import Any

import mujoco
import numpy as np

from ..types import Array, MassProperties, Pose
from ..vectors import inner, product, rotated

EDGE_DEPTH = 0.03
"""Distance behind the leading edge within which a part meets objects first [m]; chosen, about the radius of a ball."""

DECIMALS = 4
"""Decimals of a width and a heel in metres [-]; chosen: a tenth of a millimetre."""


def outline_of(model: mujoco.MjModel, tool: Pose, geoms: Container[str] | None = None) -> Array:
    """Return balls (n, 4) that span geoms of a hand at rest: centre in the tool frame and radius [m].

    Args:
        model: Compiled hand on a fixed flange.
        tool: Pose of the tool frame in the flange.
        geoms: Names of the geoms; all if absent.
    """
    data = at_rest(model)
    balls = []
    for geom in range(model.ngeom):
        if geoms is not None and model.geom(geom).name not in geoms:
            continue
        center, half, radius = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:], 0.0
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CAPSULE:
            radius = model.geom_size[geom, 0]
        corners = center + (half - radius) * np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
        corners = data.geom_xpos[geom] + rotated(data.geom_xmat[geom].reshape(3, 3), corners)
        balls.append(np.column_stack([corners, np.full(len(corners), radius)]))
    in_flange = np.vstack(balls) if balls else np.zeros((0, 4))
    return np.column_stack([rotated(tool.rotation.T, in_flange[:, :3] - tool.translation), in_flange[:, 3]])


def half_width_of(outline: Array) -> float:
    """Return half the width of the part that meets objects first [m]: within `EDGE_DEPTH` of the leading edge."""
    front = outline[:, 0] + outline[:, 3]
    near = outline[front > front.max() - EDGE_DEPTH]
    width = float((near[:, 1] + near[:, 3]).max() - (near[:, 1] - near[:, 3]).min())
    return 0.5 * round(width, DECIMALS)


def heel_of(outline: Array) -> float:
    """Return the distance from the tool frame, at the leading edge, back to the rear of the hand [m]."""
    return round(max(0.0, float((outline[:, 3] - outline[:, 0]).max())), DECIMALS)


def mass_properties_of(model: mujoco.MjModel) -> MassProperties:
    """Return mass, centre of mass and inertia of sensor and hand at rest, in the flange's axes."""
    data = at_rest(model)
    mujoco.mj_comPos(model, data)
    mass = model.body_mass[1:]
    center = rotated(data.xipos[1:].T, mass) / mass.sum()
    inertia = np.zeros((3, 3))
    for body in range(1, model.nbody):
        rotation = data.ximat[body].reshape(3, 3)
        offset = data.xipos[body] - center
        inertia += product(rotation * model.body_inertia[body], rotation.T)
        inertia += model.body_mass[body] * (inner(offset, offset) * np.eye(3) - np.outer(offset, offset))
    return MassProperties(float(mass.sum()), center, 0.5 * (inertia + inertia.T))


def at_rest(model: mujoco.MjModel) -> Any:
    """Return the state of a hand at rest, with the poses of its bodies, geoms and sites."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return data
