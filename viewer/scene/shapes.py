"""Bodies as three.js objects: two tones on objects, which show that they roll, and soft fingers as bent tubes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise
from math import cos, pi, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.recording_parts import Body, Shape
from pilegrasp_ctrl.types import rotation_matrices

PALETTE = (0xE69F00, 0x56B4E9, 0x009E73, 0xF0E442, 0x0082D6, 0xD55E00, 0xB04FD0, 0x9ACD5B, 0xFFC27A, 0xB5651D)
"""Colours of objects [0xRRGGBB]: Okabe and Ito's palette for colour-blind readers (2008) without black and pink, its
blue lighter, and four colours that stay as far from hand, table, wall and outline."""

HAND_COLOR, PALM_COLOR = 0xEAE5DA, 0xB9B2A4
"""Colours of the hand and of its parts in another recorded colour [0xRRGGBB]; chosen: ivory, and darker."""

ARM_COLOR, DARK_COLOR = 0x8FA3B5, 0x2B3138
"""Colours of the arm and of its dark parts [0xRRGGBB]; chosen: steel blue and almost black."""

TABLE_COLOR, WALL_COLOR = 0x3F474F, 0x737C86
"""Colours of table and walls [0xRRGGBB]; chosen dark, so that hand and objects stand out, also for the colour-blind."""

WALL_OPACITY = 0.8
"""Least opacity of a wall that was recorded as glass [-]; chosen. The page fades walls that hide the fingers."""

DARK = 0.4
"""Largest mean of red, green and blue of a dark part of the arm [-]; chosen."""

TONE = 0.3
"""Share of white in the lighter half of an object [-]; chosen: enough to see it roll, too little to look like another
object."""

ENDLESS_PLANE = 1.5
"""Half the side of the square that is drawn for an endless plane [m]; chosen."""

_NUMBERED = re.compile(r"(.+)_(\d+)")


def column_major(
    position: Sequence[float], rotation: NDArray[np.float64], scale: Sequence[float] = (1.0, 1.0, 1.0)
) -> list[float]:
    """Return a homogeneous transform as the 16 numbers of a three.js matrix."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation * np.asarray(scale)
    matrix[:3, 3] = position
    return [float(x) for x in matrix.T.flat]


def hex_color(rgba: Sequence[float]) -> int:
    """Return 0xRRGGBB."""
    red, green, blue = (round(255 * c) for c in rgba[:3])
    return red << 16 | green << 8 | blue


def body_looks(recording: Recording) -> list[list[int]]:
    """Return the colour of each shape of each body [0xRRGGBB].

    Roles have colours of their own, which stay apart for colour-blind readers. Objects have the palette's colours in
    turn; an object of several colours keeps them.
    """
    looks, number = [], 0
    hand = [shape.rgba for body in recording.bodies if body.role == "hand" for shape in body.shapes]
    brightest = max((sum(rgba[:3]) for rgba in hand), default=0.0)
    for body in recording.bodies:
        match body.role:
            case "object":
                several = len({shape.rgba for shape in body.shapes}) > 1
                paint = PALETTE[number % len(PALETTE)]
                looks.append([hex_color(shape.rgba) if several else paint for shape in body.shapes])
                number += 1
            case "hand":
                looks.append(
                    [HAND_COLOR if sum(shape.rgba[:3]) > brightest - 0.1 else PALM_COLOR for shape in body.shapes]
                )
            case "support":
                looks.append([WALL_COLOR if is_wall(shape) else TABLE_COLOR for shape in body.shapes])
            case _:
                looks.append([DARK_COLOR if sum(shape.rgba[:3]) < 3 * DARK else ARM_COLOR for shape in body.shapes])
    return looks


def paint_of(recording: Recording) -> dict[str, str]:
    """Return the colour of each object's first shape, as CSS, by the object's name."""
    looks = zip(recording.bodies, body_looks(recording), strict=True)
    return {body.name: f"#{paint[0]:06x}" for body, paint in looks if body.role == "object" and paint}


def is_wall(shape: Shape) -> bool:
    """Return whether a shape of a support stands rather than lies: it is higher than it is thick."""
    extents = np.abs(rotation_matrices(shape.quaternion)) @ shape.half_extents()
    return bool(extents[2] > min(extents[:2])) and shape.kind != "plane"


def _lighter(color: int) -> int:
    return hex_color([(1.0 - TONE) * (color >> shift & 255) / 255 + TONE for shift in (16, 8, 0)])


def _geometry(shape: Shape, part: int, parts: int) -> dict[str, Any]:
    """Return three.js's description of the shape, or of one of `parts` equal sectors about its axis.

    three.js 0.132, which meshcat 0.3.2 bundles, has no capsule: it is turned on a lathe.
    """
    start, length = 2 * pi * part / parts, 2 * pi / parts
    segments = 24 // parts
    match shape.kind:
        case "sphere" | "ellipsoid":
            return {
                "type": "SphereGeometry",
                "radius": 1.0,
                "widthSegments": segments,
                "heightSegments": 16,
                "phiStart": start,
                "phiLength": length,
            }
        case "cylinder":
            return {
                "type": "CylinderGeometry",
                "radiusTop": shape.size[0],
                "radiusBottom": shape.size[0],
                "height": 2 * shape.size[1],
                "radialSegments": 32 // parts,
                "thetaStart": start,
                "thetaLength": length,
            }
        case "capsule":
            radius, half = shape.size
            steps = 5
            turns = [-pi / 2 + pi / 2 * k / steps for k in range(steps + 1)]
            lower = [(radius * cos(a), radius * sin(a) - half) for a in turns]
            profile = lower + [(x, -y) for x, y in reversed(lower)]
            return {
                "type": "LatheGeometry",
                "points": [{"x": x, "y": y} for x, y in profile],
                "segments": 16 // parts,
                "phiStart": start,
                "phiLength": length,
            }
        case "mesh":
            return _mesh_geometry(shape, part, parts)
        case "plane":
            width, height = (2 * (half or ENDLESS_PLANE) for half in shape.size)
            return {"type": "PlaneGeometry", "width": width, "height": height}
    width, height, depth = (2 * half for half in shape.size)
    return {"type": "BoxGeometry", "width": width / parts, "height": height, "depth": depth}


def _mesh_geometry(shape: Shape, part: int, parts: int) -> dict[str, Any]:
    """Return the triangles of a mesh whose middle lies in one of `parts` equal slices across its longest side.

    The triangles have corners of their own, so that each face is flat.
    """
    corners = np.array(shape.vertices)[np.array(shape.faces)]
    axis = int(np.argmax(np.ptp(np.array(shape.vertices), axis=0)))
    middle = corners.mean(axis=1)[:, axis]
    low, high = (float(bound) for bound in (middle.min(), middle.max()))
    slices = np.clip(((middle - low) / (high - low or 1.0) * parts).astype(int), 0, parts - 1)
    corners = corners[slices == part]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.repeat((normals / np.where(lengths > 0.0, lengths, 1.0))[:, None, :], 3, axis=1)
    attributes = {
        name: {"itemSize": 3, "type": "Float32Array", "array": np.round(values, 5).ravel().tolist()}
        for name, values in (("position", corners), ("normal", normals))
    }
    return {"type": "BufferGeometry", "data": {"attributes": attributes}}


def _matrix(shape: Shape, part: int, parts: int) -> list[float]:
    rotation = rotation_matrices(shape.quaternion)
    if shape.kind == "box" and parts > 1:
        # A box is cut across its x axis.
        along = shape.size[0] * (2 * part + 1 - parts) / parts
        return column_major([float(x) for x in shape.position + along * rotation[:, 0]], rotation)
    if shape.kind in ("capsule", "cylinder"):
        # three.js turns its round bodies about y, a recording about z.
        rotation = rotation @ np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    scale = shape.half_extents() if shape.kind in ("sphere", "ellipsoid") else (1.0, 1.0, 1.0)
    return column_major(shape.position, rotation, scale)


def material(identifier: str, color: int, opacity: float = 1.0, **more: Any) -> dict[str, Any]:
    """Return a shaded three.js material; `more` overrides or adds properties."""
    # 2 is three.js's DoubleSide: the sectors of a two-tone body are open.
    plain = {"uuid": identifier, "type": "MeshPhongMaterial", "color": color, "shininess": 20, "side": 2}
    return plain | ({"opacity": opacity, "transparent": True} if opacity < 1.0 else {}) | more


def body_object(body: Body, colors: Sequence[int] | None = None) -> dict[str, Any]:
    """Return the body as a three.js group; an object's shapes are halved into two tones.

    Identifiers count from zero, so equal bodies give equal bytes; three.js needs them distinct within one object only.

    Args:
        body: Body.
        colors: Colour of each shape [0xRRGGBB]; by default the recorded ones.
    """
    geometries: dict[str, dict[str, Any]] = {}
    materials: dict[tuple[Any, ...], dict[str, Any]] = {}
    children = []
    for number, shape in enumerate(body.shapes):
        main = hex_color(shape.rgba) if colors is None else colors[number]
        halved = body.role == "object" and shape.kind != "plane"
        tones = (main, _lighter(main)) if halved else (main,)
        opacity = shape.rgba[3]
        # Faces of supports that lie in one plane would flicker, so each is moved a little away from the camera.
        offset: dict[str, Any] = {}
        if body.role == "support":
            opacity = max(opacity, WALL_OPACITY) if 0.0 < opacity < 1.0 and colors is not None else opacity
            offset = {"polygonOffset": True, "polygonOffsetFactor": number, "polygonOffsetUnits": number}
        for part, tone in enumerate(tones):
            geometry = _geometry(shape, part, len(tones))
            geometries.setdefault(str(geometry), geometry | {"uuid": f"g{len(geometries)}"})
            look = (tone, opacity, *offset.values())
            materials.setdefault(look, material(f"m{len(materials)}", tone, opacity, **offset))
            children.append(
                {
                    "type": "Mesh",
                    "geometry": geometries[str(geometry)]["uuid"],
                    "material": materials[look]["uuid"],
                    "matrix": _matrix(shape, part, len(tones)),
                    "castShadow": body.role != "support" and shape.rgba[3] == 1.0,
                    "receiveShadow": True,
                }
            )
    return group(children, list(geometries.values()), list(materials.values()))


def group(
    children: list[dict[str, Any]], geometries: list[dict[str, Any]], materials: list[dict[str, Any]]
) -> dict[str, Any]:
    """Return a three.js document of one group, the `object` of a `set_object` command."""
    return {
        "metadata": {"version": 4.5, "type": "Object"},
        "geometries": geometries,
        "materials": materials,
        "object": {"type": "Group", "children": children},
    }


def fingers(bodies: tuple[Body, ...]) -> list[list[int]]:
    """Return the body indices of each finger's segments, from base to tip.

    A finger is a run of at least two bodies of the hand that have one capsule each and are numbered under one name, as
    in `index_1`, `index_2`.
    """
    found: list[list[int]] = []
    last: tuple[str, int] | None = None
    for index, body in enumerate(bodies):
        match = _NUMBERED.fullmatch(body.name)
        if body.role != "hand" or len(body.shapes) != 1 or body.shapes[0].kind != "capsule" or match is None:
            last = None
            continue
        stem, number = match[1], int(match[2])
        if last == (stem, number - 1):
            found[-1].append(index)
        else:
            found.append([index])
        last = (stem, number)
    return [chain for chain in found if len(chain) > 1]


def _ends(body: Body) -> NDArray[np.float64]:
    """Return the two ends (2, 3) of the capsule's axis in the body's frame [m]."""
    shape = body.shapes[0]
    axis = shape.size[1] * rotation_matrices(shape.quaternion)[:, 2]
    return np.asarray(shape.position) + np.stack([-axis, axis])


def tubes(recording: Recording, paths: list[str]) -> list[dict[str, Any]]:
    """Return the tubes that the page draws for the fingers, given the bodies' paths in the scene tree.

    Each finger has a `color` and `segments`. A segment has its `path`, its `radius` [m] and the two `ends` of its axis
    in its own frame [m], the one nearer to the base first.
    """
    result = []
    for chain in fingers(recording.bodies):
        ends = [_ends(recording.bodies[index]) for index in chain]
        placed = [
            recording.body_position[0, index] + axis @ rotation_matrices(recording.body_quaternion[0, index]).T
            for index, axis in zip(chain, ends, strict=True)
        ]
        middles = [points.mean(axis=0) for points in placed]
        # The far end of a segment is the one nearer to the next; the tip's is the one farther from the one before.
        turned = [
            np.linalg.norm(points[0] - after) < np.linalg.norm(points[1] - after)
            for points, (_, after) in zip(placed, pairwise(middles), strict=False)
        ]
        turned.append(np.linalg.norm(placed[-1][1] - middles[-2]) < np.linalg.norm(placed[-1][0] - middles[-2]))
        segments = [
            {
                "path": paths[index],
                "radius": round(recording.bodies[index].shapes[0].size[0], 5),
                "ends": np.round(axis[::-1] if backward else axis, 5).tolist(),
            }
            for index, axis, backward in zip(chain, ends, turned, strict=True)
        ]
        result.append({"color": HAND_COLOR, "segments": segments})
    return result
