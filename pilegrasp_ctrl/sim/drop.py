"""The drop of a pile: the frame, the model of frame and objects, and random poses from which the objects fall."""

from __future__ import annotations

import math
from itertools import product

import mujoco
import numpy as np

from ..exceptions import PileError
from ..planning.layout import Layout
from ..types import Array
from ..vectors import norm
from .contact import SUPPORT, Rule, add_pair
from .objects import Objects
from .scene import add_objects, add_support, contact_parameters, new_spec

FRAME_HEIGHT = 0.8
"""Height of the dropping frame [m], chosen: 200 tennis balls fit into a frame of 0.25 m."""

PANEL_HALF_THICKNESS = 0.02
"""Half thickness of the frame's panels [m], chosen."""

PEDESTAL_HALF_HEIGHT = 0.1
"""Half height of the cylinder in place of the arm's base [m], chosen; its radius is the base's."""

SPACINGS = (2.08, 2.02)
"""Spacings of the grid from which objects drop, over their bounding radius [-], chosen. The second is used if the
objects do not fit with the first."""


def pile_model(
    objects: Objects, count: int, layout: Layout, rule: Rule, timestep: float, mutual: bool = True
) -> mujoco.MjModel:
    """Return the compiled frame, supports and objects, which touch one another if they are `mutual`.

    Only the frame is a mocap body, and only objects have joints.
    """
    spec = new_spec(timestep)
    supports = add_support(spec, layout)
    panels = [*_add_frame(spec, layout), _add_pedestal(spec, layout.room.base_radius)]
    names = add_objects(spec, objects, count, supports, rule, mutual)
    for name, each in zip(names, objects.assign_models(count), strict=True):
        for geom, panel in product(each.geom_names(name), panels):
            add_pair(spec, geom, panel, contact_parameters(spec, each.surface, SUPPORT, rule))
    return spec.compile()


def drop_poses(objects: Objects, count: int, layout: Layout, rng: np.random.Generator) -> Array:
    """Return random poses (count, 7) in the frame that do not overlap: a jittered grid in layers.

    The objects of a net are dropped together, upright and side by side; single objects have random orientations.

    Raises:
        PileError: The objects of a net do not fit into the frame, or the layers exceed its height.
    """
    if objects.net is None:
        return _grid_poses(objects.bounding_radius, count, layout, rng)
    radius = max(objects.net.ring_radius(objects.flank_radius) + objects.flank_radius, objects.bounding_radius)
    if 2.0 * radius > layout.frame_size:
        raise PileError(
            f"{objects.net.members} tied objects need {2000 * radius:.0f} mm side by side and do not fit into the "
            f"frame of {1000 * layout.frame_size:.0f} mm; raise pile.frame_size or lower pile.scale"
        )
    bags = _grid_poses(radius, count // objects.net.members, layout, rng)
    yaw = rng.uniform(-math.pi, math.pi, size=len(bags))
    bags[:, 3:] = np.stack([np.cos(yaw / 2.0), 0.0 * yaw, 0.0 * yaw, np.sin(yaw / 2.0)], axis=-1)
    return objects.net.object_poses(bags, objects.flank_radius)


def _grid_poses(radius: float, count: int, layout: Layout, rng: np.random.Generator) -> Array:
    """Return random poses (count, 7) of balls of `radius` [m] that do not overlap."""
    for spacing in SPACINGS:
        cell = spacing * radius
        per_side = max(1, int(layout.frame_size // cell))
        layers = math.ceil(count / per_side**2)
        if layers * cell <= FRAME_HEIGHT:
            break
    else:
        raise PileError(
            f"{count} objects need {layers} layers of {1000 * cell:.0f} mm and overflow the frame's height of "
            f"{1000 * FRAME_HEIGHT:.0f} mm; lower pile.count or raise pile.frame_size"
        )
    pitch = layout.frame_size / per_side
    slack = max(0.0, 0.5 * pitch - 1.02 * radius)
    cosine, sine = math.cos(layout.frame_yaw), math.sin(layout.frame_yaw)
    poses = np.zeros((count, 7))
    for layer in range(layers):
        cells = rng.permutation(per_side**2)
        for k in range(per_side**2):
            index = layer * per_side**2 + k
            if index >= count:
                break
            row, column = divmod(int(cells[k]), per_side)
            x = (row + 0.5) * pitch - 0.5 * layout.frame_size + rng.uniform(-slack, slack)
            y = (column + 0.5) * pitch - 0.5 * layout.frame_size + rng.uniform(-slack, slack)
            poses[index, :2] = layout.frame_center + np.array([cosine * x - sine * y, sine * x + cosine * y])
            poses[index, 2] = (layer + 0.5) * cell
            quaternion = rng.normal(size=4)
            poses[index, 3:] = quaternion / norm(quaternion)
    return poses


def _add_frame(spec: mujoco.MjSpec, layout: Layout) -> list[str]:
    """Add the four panels, whose inner faces bound the frame, as one mocap body; return their names."""
    half, thick = 0.5 * layout.frame_size, PANEL_HALF_THICKNESS
    yaw = layout.frame_yaw
    frame = spec.worldbody.add_body(
        name="frame", mocap=True, pos=[*layout.frame_center, 0.0], quat=[math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)]
    )
    panels = {
        "frame_front": ([-(half + thick), 0.0], [thick, half + 2 * thick]),
        "frame_back": ([half + thick, 0.0], [thick, half + 2 * thick]),
        "frame_left": ([0.0, half + thick], [half, thick]),
        "frame_right": ([0.0, -(half + thick)], [half, thick]),
    }
    for name, (center, size) in panels.items():
        frame.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=[*center, FRAME_HEIGHT / 2.0],
            size=[*size, FRAME_HEIGHT / 2.0],
            contype=0,
            conaffinity=0,
        )
    return list(panels)


def _add_pedestal(spec: mujoco.MjSpec, radius: float) -> str:
    """Add a cylinder in place of the arm's base, so that no object comes to rest there; return its name."""
    spec.worldbody.add_geom(
        name="pedestal",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        pos=[0.0, 0.0, PEDESTAL_HALF_HEIGHT],
        size=[radius, PEDESTAL_HALF_HEIGHT, 0.0],
        contype=0,
        conaffinity=0,
    )
    return "pedestal"
