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

PALETTE = (0xE69F00, 0x56B4E9, 0x009E73, 0xF0E442, 0x0072B2, 0xD55E00, 0xCC79A7, 0x9ACD5B, 0x8E7CC3, 0xB5651D)
"""Okabe and Ito's palette for colour-blind readers (2008), without black, and three tones between."""

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


def object_colors(recording: Recording) -> dict[str, int]:
    """Return a palette colour for each object if all were recorded in one colour; otherwise nothing."""
    objects = [body for body in recording.bodies if body.role == "object"]
    if len({shape.rgba for body in objects for shape in body.shapes}) > 1:
        return {}
    return {body.name: PALETTE[index % len(PALETTE)] for index, body in enumerate(objects)}


def _lighter(color: int) -> int:
    return hex_color([0.5 * (color >> shift & 255) / 255 + 0.5 for shift in (16, 8, 0)])


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
        case "plane":
            width, height = (2 * (half or ENDLESS_PLANE) for half in shape.size)
            return {"type": "PlaneGeometry", "width": width, "height": height}
    width, height, depth = (2 * half for half in shape.size)
    return {"type": "BoxGeometry", "width": width / parts, "height": height, "depth": depth}


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


def body_object(body: Body, color: int | None = None) -> dict[str, Any]:
    """Return the body as a three.js group; an object's shapes are halved into two tones.

    Identifiers count from zero, so equal bodies give equal bytes; three.js needs them distinct within one object only.
    """
    geometries: dict[str, dict[str, Any]] = {}
    materials: dict[tuple[int, float], dict[str, Any]] = {}
    children = []
    for shape in body.shapes:
        main = hex_color(shape.rgba) if color is None else color
        halved = body.role == "object" and shape.kind != "plane"
        tones = (main, _lighter(main)) if halved else (main,)
        for part, tone in enumerate(tones):
            geometry = _geometry(shape, part, len(tones))
            geometries.setdefault(str(geometry), geometry | {"uuid": f"g{len(geometries)}"})
            look = (tone, shape.rgba[3])
            materials.setdefault(look, material(f"m{len(materials)}", *look))
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
        result.append({"color": hex_color(recording.bodies[chain[0]].shapes[0].rgba), "segments": segments})
    return result
