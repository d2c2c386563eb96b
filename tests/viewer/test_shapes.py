"""Shapes as three.js objects: their extent, their turn and their colours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from meshcat.geometry import Box, Cylinder

from page_parts import of_type, still
from pilegrasp_ctrl.recording import Body, Shape
from pilegrasp_ctrl.viewer.scene.commands import commands
from pilegrasp_ctrl.viewer.scene.shapes import PALETTE, body_object
from synthetic_recording import synthetic


def test_boxes_and_cylinders_are_those_of_meshcat():
    body = Body("b", "arm", (Shape("box", (0.1, 0.2, 0.3)), Shape("cylinder", (0.05, 0.4))))
    ours = body_object(body)["geometries"]
    for mine, theirs in zip(ours, (Box([0.2, 0.4, 0.6]).lower({}), Cylinder(0.8, 0.05).lower({})), strict=True):
        shared = mine.keys() & theirs.keys() - {"uuid", "radialSegments"}
        assert {key: mine[key] for key in shared} == pytest.approx({key: theirs[key] for key in shared})
        assert len(shared) >= 4


def vertices(mesh, geometry):
    """Extreme points of a round geometry in its body's frame, as three.js would place them."""
    matrix = np.reshape(mesh["matrix"], (4, 4)).T
    match geometry["type"]:
        case "SphereGeometry":
            local = geometry["radius"] * np.concatenate([np.eye(3), -np.eye(3)])
        case "LatheGeometry":
            local = np.array([[s * p["x"], p["y"], 0.0] for p in geometry["points"] for s in (-1, 1)])
            local = np.concatenate([local, local[:, [2, 1, 0]]])
        case "CylinderGeometry":
            r, h = geometry["radiusTop"], geometry["height"] / 2
            local = np.array([[r, h, 0], [-r, -h, 0], [0, h, r], [0, -h, -r]])
    return (matrix @ np.c_[local, np.ones(len(local))].T).T[:, :3]


@pytest.mark.parametrize(
    "shape",
    [
        Shape("sphere", (0.03,), (0.1, 0.2, 0.3)),
        Shape("ellipsoid", (0.01, 0.02, 0.03), (0.1, 0.0, 0.0)),
        Shape("capsule", (0.01, 0.05), (0.0, 0.1, 0.0)),
        Shape("cylinder", (0.02, 0.05), (0.0, 0.0, 0.3)),
    ],
    ids=lambda shape: shape.kind,
)
def test_round_shapes_have_the_extent_that_mujoco_gives_them(shape):
    for role in ("arm", "object"):
        drawn = body_object(Body("b", role, (shape,)))
        by_name = {geometry["uuid"]: geometry for geometry in drawn["geometries"]}
        points = np.concatenate([vertices(m, by_name[m["geometry"]]) for m in drawn["object"]["children"]])
        np.testing.assert_allclose(points.max(axis=0) - shape.position, shape.half_extents(), atol=1e-9)
        np.testing.assert_allclose(points.min(axis=0) - shape.position, -np.array(shape.half_extents()), atol=1e-9)


def test_a_shape_turns_with_its_quaternion():
    half = np.sqrt(0.5)
    lying = Shape("capsule", (0.01, 0.05), quaternion=(half, 0.0, half, 0.0))  # z of the shape onto x of the body
    drawn = body_object(Body("b", "arm", (lying,)))
    points = vertices(drawn["object"]["children"][0], drawn["geometries"][0])
    np.testing.assert_allclose(points.max(axis=0), (0.06, 0.01, 0.01), atol=1e-9)


def test_equal_shapes_share_their_geometry_and_two_tones_show_rolling():
    ball = Shape("sphere", (0.03,))
    drawn = body_object(Body("b", "object", (ball, replace(ball, position=(0.1, 0, 0)))))
    assert (len(drawn["geometries"]), len(drawn["materials"]), len(drawn["object"]["children"])) == (2, 2, 4)
    halves = [(g["phiStart"], g["phiLength"]) for g in drawn["geometries"]]
    np.testing.assert_allclose(halves, [(0.0, np.pi), (np.pi, np.pi)])


def colors(recording):
    return [c["object"]["materials"][0]["color"] for c in of_type(commands(recording), "set_object", "/Objects/")]


def test_objects_get_distinct_colours_and_one_of_several_colours_keeps_them():
    assert set(colors(synthetic(objects=9, frames=2))) == set(PALETTE[:9])
    shapes = [Shape("sphere", (0.03,), rgba=(1, 0, 0, 1)), Shape("sphere", (0.03,), rgba=(0, 0, 1, 1))]
    assert colors(still(shapes)) == [0xFF0000]
