"""A hand from the MJCF in its folder, mounted on the wrist sensor of a scene."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mujoco

from ..exceptions import ModelError
from ..hand_description import HandDescription
from ..model_files import read_mjcf_folder

PREFIX = "hand_"
"""Prefix of the names of a hand's elements in a scene, so that no arm has the same."""

DROPPED = ("option", "size", "visual", "statistic", "keyframe", "sensor", "contact", "custom")
"""Sections of a hand's MJCF that do not count: the scene has its own numerics, sensors and contact pairs."""

_UNWANTED = ("light", "camera")


def hand_spec(folder: Path, name: str) -> mujoco.MjSpec:
    """Return the MJCF of a hand as a spec of its own, in which every geom has a name.

    Raises:
        ModelError: The MJCF cannot be read, or it is no hand: it has a free or ball joint, or a plane.
    """
    model = read_mjcf_folder(folder, name)
    for parent in list(model.root.iter()):
        for child in list(parent):
            if child.tag in _UNWANTED or (parent is model.root and child.tag in DROPPED):
                parent.remove(child)
    try:
        spec = mujoco.MjSpec.from_string(model.text(), assets=model.assets)
    except ValueError as error:
        raise ModelError(f"{folder / name}: MuJoCo cannot read it: {_first_line(error)}") from None
    for index, geom in enumerate(spec.geoms):
        if geom.type == mujoco.mjtGeom.mjGEOM_PLANE:
            raise ModelError(f"{folder / name}: a hand has no plane; remove it, because a scene has a table")
        geom.name = geom.name or f"geom_{index}"
    for joint in spec.joints:
        if joint.type not in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
            raise ModelError(f"{folder / name}: a hand has hinges and slides; remove the free or ball joint")
    return spec


def add_mjcf_hand(spec: mujoco.MjSpec, root: Any, folder: Path, description: HandDescription) -> None:
    """Mount a hand's MJCF as the body `hand` on the outer face of the wrist sensor, whose body is `root`."""
    mount, half_turn = description.hand, 0.5 * math.radians(description.hand.mount_deg)
    body = root.add_body(
        name="hand",
        pos=[0.0, 0.0, description.sensor.top],
        quat=[math.cos(half_turn), 0.0, 0.0, math.sin(half_turn)],
    )
    spec.attach(hand_spec(folder, str(mount.mjcf)), prefix=PREFIX, frame=body.add_frame())


def _first_line(error: Exception) -> str:
    return str(error).strip().replace("\n", ", ")
