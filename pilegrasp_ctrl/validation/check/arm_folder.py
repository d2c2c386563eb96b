"""The folder of an arm, made from a bare URDF or MJCF: the model without its meshes, and `robot.toml`."""

from __future__ import annotations

import math
import shutil
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import mujoco
import numpy as np

from ...arm.capsule import Capsule
from ...arm.capsules import capsules_of
from ...arm.loading import read_model
from ...arm.model import ArmModel
from ...exceptions import ExportError, ModelError
from ...planning.arm_bodies import arm_bodies, bodies_beside_table
from ...planning.arm_room import ArmRoom
from ...planning.simulated_arm import DEFAULT_BASE_RADIUS
from ...programs.derived_room import SHOULDER_ABOVE_TABLE, room_between
from ...robots import path
from ...sim.hand import Hand
from ...types import Array
from .reach import Reach, ReachSearch, worth

HANDS = ("rbo_hand2", "shovel")
"""Hands for which the room is found, unless others are asked for."""

HEIGHTS = (0.0, 0.05, 0.1, 0.15, -0.05)
"""Differences of the base's height from the usual one that are tried [m]; chosen."""

GROW = 1e-3
"""Length by which a written capsule is larger than the fitted one, for the digits that are written [m]."""


_PAINT = ("materials", "textures")
"""Names of lists of a spec, to be emptied after the geoms that use them."""


class MadeFolder(NamedTuple):
    """What was written.

    Attributes:
        folder: Folder of the arm.
        left_out: Links beyond the tool frame, which are no part of the arm.
        lacking: Sentences about numbers that the model does not have.
    """

    folder: Path
    left_out: tuple[str, ...]
    lacking: tuple[str, ...]


def write_arm_folder(
    file: Path, tool_frame: str, joints: int | None, folder: Path, hands: Sequence[str] = HANDS
) -> MadeFolder:
    """Write the folder of an arm.

    Args:
        file: URDF or MJCF.
        tool_frame: Link, body or site that carries the hand.
        joints: Number of the chain's first joints to keep; None for all.
        folder: Folder to make; it must not exist, or be empty.
        hands: Hands for which the arm's room is found.

    Raises:
        ModelError: The file does not describe an arm, or no hand reaches the table.
        ExportError: The folder cannot be made.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ExportError(f"{folder}: exists already; give a folder that does not")
    is_mjcf, left_out = _root(file).tag == "mujoco", tuple(_beyond(file, tool_frame))
    read, numbers = read_model(file, tool_frame, joints, (), {}, left_out)
    arm = ArmModel(read, tool_frame, **numbers)
    capsules, lacking = _capsules(file, arm), _lacking(arm)
    if not capsules:
        lacking += ("it has no collision geometry, so its links touch nothing; state [[collision.capsules]]",)
    beside = bodies_beside_table(arm_bodies(arm, capsules), DEFAULT_BASE_RADIUS)
    room, postures = _room(file, tool_frame, joints, left_out, capsules, beside, hands)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        model = folder / f"{file.stem}{'.xml' if is_mjcf else '.urdf'}"
        model.write_text(_bare_mjcf(file, left_out) if is_mjcf else _bare_urdf(file), encoding="utf-8")
        text = _toml(file, model.name, tool_frame, () if is_mjcf else left_out, arm, lacking, capsules, room, postures)
        (folder / "robot.toml").write_text(text, encoding="utf-8")
        for gains in ("operational_space.toml", "impedance.toml"):
            shutil.copyfile(path("gains", gains), folder / gains)
    except OSError as error:
        raise ExportError(f"{folder}: cannot be written: {error.strerror}") from None
    ArmModel.load(folder)
    return MadeFolder(folder, left_out, lacking)


def _root(file: Path) -> ElementTree.Element:
    try:
        return ElementTree.parse(file).getroot()
    except (ElementTree.ParseError, LookupError, ValueError, OSError) as error:
        raise ModelError(f"{file}: not a URDF or MJCF file: {error}") from None


def _beyond(file: Path, tool_frame: str) -> list[str]:
    """Return the links that the tool frame carries, such as a gripper, which is a hand of its own."""
    root = _root(file)
    if root.tag == "mujoco":
        return [body.get("name", "") for body in root.iterfind(f".//body[@name={tool_frame!r}]/body")]
    joints = [(joint.find("parent"), joint.find("child")) for joint in root.findall("joint")]
    return [
        child.get("link", "")
        for parent, child in joints
        if parent is not None and child is not None and parent.get("link") == tool_frame
    ]


def _capsules(file: Path, arm: ArmModel) -> list[Capsule]:
    links = {frame.name for frame in arm.pinocchio_model.frames}
    try:
        return [capsule for capsule in capsules_of(file) if capsule.frame in links]
    except ModelError:
        return []


def _lacking(arm: ArmModel) -> tuple[str, ...]:
    """Return sentences about what a model does not say; other things that it lacks refuse it."""
    found = []
    if not np.isfinite(arm.velocity_limit).all():
        found.append("it has no velocity limits, so nothing limits the speed of its joints; state joints.velocity")
    if not arm.friction_coulomb.any() and not arm.friction_viscous.any():
        found.append("it has no joint friction, which every real arm has; state joints.friction_coulomb")
    if not np.any(arm.pinocchio_model.armature):
        found.append("it has no inertia of the drives (armature); state joints.armature")
    return tuple(found)


def _room(
    file: Path,
    tool_frame: str,
    joints: int | None,
    left_out: tuple[str, ...],
    capsules: list[Capsule],
    beside: tuple[str, ...],
    hands: Sequence[str],
) -> tuple[ArmRoom, list[Array]]:
    """Return the room at the height of the base that is best for the hands, and the postures in which they begin."""
    found: list[tuple[float, float, list[Reach]]] = []
    for extra in HEIGHTS:
        reaches = []
        for name in hands:
            hand = Hand.load(name)
            options: Any = {"transform_tool_to_frame": hand.transform_tool_to_flange}
            read, numbers = read_model(file, tool_frame, joints, (), options, left_out)
            arm = ArmModel(read, tool_frame, **numbers)
            height = round(max(0.0, _shoulder_height(arm) - SHOULDER_ABOVE_TABLE + extra), 3)
            reaches.append(ReachSearch(arm, hand.theta, height, capsules, beside).best())
        good = [reach for reach in reaches if reach is not None]
        if len(good) == len(hands):
            found.append((min(map(worth, good)), height, good))
    if not found:
        raise ModelError(f"{file}: no posture brings {' and '.join(hands)} onto a table; give another --tool-frame")
    _, height, best = max(found, key=lambda each: each[0])
    near, far = max(reach.near for reach in best), min(reach.far for reach in best)
    return room_between(near, far, height), [reach.start for reach in best]


def _shoulder_height(arm: ArmModel) -> float:
    model = arm.pinocchio_model
    if model.njoints < 3:
        return 0.0
    shoulder = model.jointPlacements[1] * model.jointPlacements[2]
    return float(shoulder.translation[2])


def _bare_urdf(file: Path) -> str:
    """Return a URDF without shapes, of which a simulation needs none."""
    root = _root(file)
    for link in root.findall("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(shape)
    for other in [*root.findall("material"), *root.findall("gazebo"), *root.findall("transmission")]:
        root.remove(other)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def _bare_mjcf(file: Path, left_out: Iterable[str]) -> str:
    """Return an MJCF without shapes and other files, in which every body states its inertia."""
    spec = mujoco.MjSpec.from_file(str(file))
    for name in left_out:
        spec.delete(spec.body(name))
    mj = spec.compile()
    for body in spec.bodies[1:]:
        body.explicitinertial = True
        body.mass, body.ipos = float(mj.body_mass[body.id]), np.array(mj.body_ipos[body.id])
        # The other form of an inertia; NaN stands for none.
        body.fullinertia = np.full(6, np.nan)
        body.iquat, body.inertia = np.array(mj.body_iquat[body.id]), np.array(mj.body_inertia[body.id])
    for kind in ("sensors", "keys", "pairs", "geoms", "cameras", "lights", "skins", "meshes", "hfields", *_PAINT):
        for element in list(getattr(spec, kind, [])):
            spec.delete(element)
    spec.meshdir = spec.texturedir = ""
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    spec.compile()
    text: str = spec.to_xml()
    return text


def _toml(
    file: Path,
    model: str,
    tool_frame: str,
    left_out: tuple[str, ...],
    arm: ArmModel,
    lacking: tuple[str, ...],
    capsules: list[Capsule],
    room: ArmRoom,
    postures: list[Array],
) -> str:
    key = "mjcf" if model.endswith(".xml") else "urdf"
    lines = [
        f"# Made by `pilegrasp check` from {file.name}. SI units, radians. Change what you know better, and say why.",
        *(f"# Note: {sentence}." for sentence in lacking),
        "",
        "[robot]",
        f'name = "{file.stem}"',
        f'{key} = "{model}"',
        f'flange_frame = "{tool_frame}"',
        *([f"without = [{', '.join(map(_quoted, left_out))}]"] if left_out else []),
        "",
        "[joints]    # limits, inertia and friction are those of the model; a number here takes their place",
        f"names = [{', '.join(map(_quoted, arm.joint_names))}]",
        "# position_lower, position_upper, velocity, torque_peak, armature, friction_coulomb, friction_viscous = [...]",
        "",
        "[postures]    # derived: where the search for a start posture begins",
        f"home = {_numbers(postures[0])}",
        "search = [",
        *(f"    {_numbers(posture)}," for posture in postures),
        "]",
        "",
        "[room]    # derived: where the base stands, and how far the fingertips reach on a table [m]",
        *(f"{name} = {_length(getattr(room, name))}" for name in ArmRoom.__slots__),
        "",
        "[collision]    # fitted to the model's collision geometry, in the frames of its links [m]",
        "capsules = [",
        *(
            f'    {{ link = "{each.frame}", from = {_numbers(each.start)}, to = {_numbers(each.end)}, '
            f"radius = {math.ceil(1e3 * (each.radius + GROW)) / 1e3:.3f} }},"
            for each in capsules
        ),
        "]",
    ]
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    return f'"{text}"'


def _numbers(values: Iterable[float]) -> str:
    return "[" + ", ".join(f"{value + 0.0:.3f}" for value in np.round(np.asarray(values), 3).tolist()) + "]"


def _length(value: float | tuple[float, ...]) -> str:
    return _numbers(value) if isinstance(value, tuple) else f"{value:.3f}"
