"""Primitives as three.js objects: geometry, colour, and two tones on the objects so that rolling can be seen."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, pi, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pilegrasp_ctrl.recording import Body, Recording, Shape
from pilegrasp_ctrl.types import rotation_matrices

Color = tuple[float, float, float, float]

# Okabe and Ito's palette for colour-blind readers (2008), without black, and three tones between.
PALETTE = (0xE69F00, 0x56B4E9, 0x009E73, 0xF0E442, 0x0072B2, 0xD55E00, 0xCC79A7, 0x9ACD5B, 0x8E7CC3, 0xB5651D)

# Half the side of a plane without end, as drawn [m].
ENDLESS = 1.5


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
    """Return a colour for each object: the palette where all are recorded in one colour, nothing otherwise."""
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
            width, height = (2 * (half or ENDLESS) for half in shape.size)
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
