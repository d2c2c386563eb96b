"""URDF files: read with Pinocchio after a check that names the joint or link at fault."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from math import isfinite
from xml.etree import ElementTree

import pinocchio as pin

from ..exceptions import ModelError
from .file_model import FileModel
from .frames import frame_id
from .joints import joints_to_lock, lock_joints, simple_joints
from .options import listed

_KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
"""Types of joints in a URDF."""

_KEPT = {"link": ("inertial",), "joint": ("origin", "parent", "child", "axis", "limit", "mimic", "dynamics")}
"""Elements of a URDF that say how it moves, and the parts of each that do."""

_FACTORS = (
    ("mimic", "multiplier", "1"),
    ("mimic", "offset", "0"),
    ("dynamics", "damping", "0"),
    ("dynamics", "friction", "0"),
)
"""Element, attribute and default of further numbers of a joint."""

_LIMITS = {
    "lower": ("lowerPositionLimit", "-1"),
    "upper": ("upperPositionLimit", "1"),
    "effort": ("effortLimit", "1"),
    "velocity": ("velocityLimit", "1"),
}
"""Attribute of the element limit -> the vector of `pin.Model` that holds it, and a value that no parser refuses."""


def read_urdf(
    root: ElementTree.Element,
    source: str,
    arm: str,
    tool_frame: str,
    joints: Sequence[str] | int | None,
    locked_joints: Sequence[str] | Mapping[str, float],
) -> FileModel:
    """Return what a URDF says.

    Args:
        root: The parsed file; missing limits are entered.
        source: Name of the file, for errors about its contents.
        arm: Name of the arm, for other errors.
        tool_frame: Name of the frame that carries the tool.
        joints: Names of the joints to keep, or how many of the chain's first joints to keep; None for all.
        locked_joints: Names of joints to lock at their neutral position, or a mapping from name to position.

    Raises:
        ModelError: The file is not a URDF of a tree of bodies, or an argument does not fit it.
    """
    followers = _check_tree(root, source)
    root.set("name", root.get("name") or arm)
    _reduce(root)
    limits = _take_limits(root, source)
    try:
        model = pin.buildModelFromXML(ElementTree.tostring(root, encoding="unicode"))
    except (ValueError, RuntimeError) as error:
        raise ModelError(f"{source}: not a URDF that Pinocchio can read: {' '.join(str(error).split())}") from error
    model = simple_joints(model)
    for joint, vector, value in limits:
        if model.existJointName(joint):
            getattr(model, vector)[model.joints[model.getJointId(joint)].idx_v] = value
    tool = model.frames[frame_id(model, tool_frame, arm)].parentJoint
    names = list(model.names)[1:]
    chain = [model.names[index] for index in model.supports[tool] if index > 0 and model.joints[index].nq == 1]
    locks = joints_to_lock(arm, names, chain, followers, joints, locked_joints)
    return FileModel(lock_joints(model, locks, arm), followers, {})


def _reduce(root: ElementTree.Element) -> None:
    """Take out of a URDF what says nothing about motion, above all shapes.

    The parser refuses a whole file for one number of a shape, and prints the reason to the C library's standard error.
    """
    for element in list(root):
        kept = _KEPT.get(element.tag)
        if kept is None:
            root.remove(element)
            continue
        for part in list(element):
            if part.tag not in kept:
                element.remove(part)


def without_links(root: ElementTree.Element, links: Sequence[str], source: str) -> None:
    """Take links out of a URDF, with the joints that carry them and all that they carry.

    Raises:
        ModelError: A link does not exist.
    """
    names = [link.get("name", "") for link in root.findall("link")]
    joints, gone = root.findall("joint"), list(links)
    for link in gone:
        if link not in names:
            raise ModelError(f"{source}: no link {link!r} to leave out; the links are {listed(names)}")
        gone += [_text(joint, "child", "link") for joint in joints if _text(joint, "parent", "link") == link]
    for element in [*root.findall("link"), *joints]:
        if (element.get("name") if element.tag == "link" else _text(element, "child", "link")) in gone:
            root.remove(element)


def _check_tree(root: ElementTree.Element, source: str) -> dict[str, str]:
    """Refuse what Pinocchio would misread or refuse without a name; return the joints that follow another one."""
    if any("xacro" in element.tag.rpartition("}")[0] for element in root.iter()):
        raise ModelError(f"{source}: holds xacro macros; expand it first, with the tool xacro of ROS or with xacrodoc")
    links = {link.get("name", ""): link for link in root.findall("link")}
    joints: dict[str, ElementTree.Element] = {}
    mover: dict[str, str] = {}
    for joint in root.findall("joint"):
        name, child = joint.get("name", ""), _text(joint, "child", "link")
        if name in joints:
            raise ModelError(f"{source}: two joints have the name {name!r}; rename one")
        _check_joint(joint, name, links, source)
        if child in mover:
            raise ModelError(
                f"{source}: joints {mover[child]!r} and {name!r} both carry link {child!r}, a closed loop, which an "
                "arm cannot have; take one out"
            )
        joints[name], mover[child] = joint, name
    roots = [link for link in links if link not in mover]
    if len(roots) != 1:
        what = f"no joint carries the links {listed(roots)}" if roots else f"a joint carries each of {len(links)} links"
        raise ModelError(f"{source}: {what}; a URDF is a tree, in which no joint carries just one link, the base")
    for link, element in links.items():
        below: list[str] = []
        while link in mover and link not in below:
            below.append(link)
            link = _text(joints[mover[link]], "parent", "link")
        if link in below:
            raise ModelError(f"{source}: joint {mover[link]!r} hangs on itself, a closed loop; correct its parent")
        name = element.get("name", "")
        _check_inertial(element, f"link {name!r}" + (f" on joint {mover[name]!r}" if name in mover else ""), source)
    followers = {name: _text(joint, "mimic", "joint") for name, joint in joints.items()}
    return {name: leader for name, leader in followers.items() if joints[name].find("mimic") is not None}


def _check_joint(joint: ElementTree.Element, name: str, links: Container[str], source: str) -> None:
    kind = joint.get("type", "")
    if kind not in _KINDS:
        raise ModelError(f"{source}: joint {name!r} has the type {kind!r}; the types are {', '.join(_KINDS)}")
    for end in ("parent", "child"):
        if (link := _text(joint, end, "link")) not in links:
            raise ModelError(f"{source}: the {end} link {link!r} of joint {name!r} does not exist; add the link")
    _check_origin(joint, f"joint {name!r}", source)
    for tag, key, default in _FACTORS:
        _numbers(joint, tag, key, f"joint {name!r}", source, default)
    if kind != "fixed" and not any(_numbers(joint, "axis", "xyz", f"joint {name!r}", source, "1 0 0")):
        raise ModelError(f"{source}: the axis of joint {name!r} is zero; give its direction")


def _check_inertial(link: ElementTree.Element, what: str, source: str) -> None:
    inertial = link.find("inertial")
    if inertial is None:
        return
    _check_origin(inertial, what, source)
    inertia = inertial.find("inertia")
    for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"):
        if inertia is None or key not in inertia.attrib or inertial.find("mass") is None:
            raise ModelError(f"{source}: the inertial of {what} lacks its mass or the {key} of its inertia; add them")
        _numbers(inertial, "inertia", key, what, source, "0")
    if _numbers(inertial, "mass", "value", what, source, "0")[0] < 0.0:
        raise ModelError(f"{source}: the mass of {what} is negative; correct it")


def _check_origin(element: ElementTree.Element, what: str, source: str) -> None:
    for key in ("xyz", "rpy"):
        _numbers(element, "origin", key, what, source, "0 0 0")


def _take_limits(root: ElementTree.Element, source: str) -> list[tuple[str, str, float]]:
    """Replace the limits of the joints by harmless ones; return joint, vector of `pin.Model` and value of each.

    The parser refuses a whole file for a limit that is missing, infinite or negative. Such a limit is refused later,
    with the joint's name, and only if no argument replaces it.
    """
    taken = []
    for joint in root.findall("joint"):
        name, kind = joint.get("name", ""), joint.get("type", "")
        limit = joint.find("limit")
        if kind not in ("revolute", "prismatic", "continuous") or (limit is None and kind == "continuous"):
            continue
        limit = ElementTree.SubElement(joint, "limit") if limit is None else limit
        for key, (vector, harmless) in _LIMITS.items():
            if kind != "continuous" or key in ("effort", "velocity"):
                taken.append((name, vector, _number(limit.get(key, "0"), f"limit {key} of joint {name!r}", source)))
            limit.set(key, harmless)
    return taken


def _text(parent: ElementTree.Element, tag: str, key: str) -> str:
    element = parent.find(tag)
    return "" if element is None else element.get(key, "")


def _numbers(parent: ElementTree.Element, tag: str, key: str, what: str, source: str, default: str) -> list[float]:
    """Return the finite numbers in an attribute."""
    element = parent.find(tag)
    text = default if element is None else element.get(key, default)
    values = [_number(part, f"{tag} {key} of {what}", source) for part in text.split()]
    if not all(map(isfinite, values)) or len(values) != len(default.split()):
        raise ModelError(f"{source}: the {tag} {key} of {what} is {text!r}; it must be finite numbers")
    return values


def _number(text: str, what: str, source: str) -> float:
    try:
        # Python takes 1_000 and digits of other alphabets for numbers, the parser does not.
        value = float(text) if text.isascii() and "_" not in text else float("nan")
    except ValueError:
        value = float("nan")
    if value != value:
        raise ModelError(f"{source}: the {what} is {text!r}; it must be a number")
    return value
