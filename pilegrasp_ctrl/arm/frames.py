"""Frames and bodies of a Pinocchio model: find a frame, place the base, add a tool."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin

from ..exceptions import ModelError
from ..types import MassProperties, Pose
from .options import listed


def frame_id(model: pin.Model, name: str, arm: str) -> int:
    """Return the index of a frame; a link is preferred, because a link and a joint may share a name.

    Error messages use the name of the `arm`.

    Raises:
        ModelError: No frame has this name.
    """
    named = [index for index, frame in enumerate(model.frames) if frame.name == name]
    if not named:
        links, sites = (
            listed(frame.name for frame in model.frames if frame.type == kind)
            for kind in (pin.FrameType.BODY, pin.FrameType.OP_FRAME)
        )
        raise ModelError(
            f"{arm}: no frame {name!r} for the tool; the links are {links}{f'; the sites are {sites}' if sites else ''}"
        )
    return next((index for index in named if model.frames[index].type == pin.FrameType.BODY), named[0])


def place_base(model: pin.Model, base: Pose) -> None:
    """Move the base of a model to `base`, the pose `transform_base_to_world`."""
    transform = se3(base)
    for joint in range(1, model.njoints):
        if model.parents[joint] == 0:
            model.jointPlacements[joint] = transform * model.jointPlacements[joint]
    for frame in model.frames[1:]:
        if frame.parentJoint == 0:
            frame.placement = transform * frame.placement


def add_body(model: pin.Model, frame: int, body: MassProperties) -> None:
    """Add a body to what carries the frame of index `frame`, given in the axes of that frame."""
    inertia = pin.Inertia(body.mass, np.array(body.center_of_mass), np.zeros((3, 3)))
    # The constructor refuses an inertia that is negative by rounding alone.
    inertia.inertia = np.array(body.inertia)
    model.appendBodyToJoint(model.frames[frame].parentJoint, inertia, model.frames[frame].placement)


def add_frame(model: pin.Model, parent: int, transform: Pose) -> int:
    """Add the frame `transform`, given in the frame of index `parent`, with a name of its own; return its index."""
    carrier = model.frames[parent]
    name = f"{carrier.name}_tool"
    while model.existFrame(name):
        name += "_"
    placement = carrier.placement * se3(transform)
    index: int = model.addFrame(pin.Frame(name, carrier.parentJoint, parent, placement, pin.FrameType.OP_FRAME))
    return index


def se3(pose: Pose) -> Any:
    """Return a pose in Pinocchio's type."""
    return pin.SE3(np.array(pose.rotation), np.array(pose.translation))
