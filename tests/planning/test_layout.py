"""The layout: the base is behind each push, and every pile of the paper's experiments is within reach."""

import numpy as np
import pytest

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.planning.arm_room import default_room
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sections import PileConfig, SupportConfig

ROOM = default_room()
SUPPORTS = ("none", "wall", "corner")


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


@pytest.mark.parametrize("support", SUPPORTS)
@pytest.mark.parametrize(
    ("length", "distance"),
    [(0.2, ROOM.max_touch_distance), (0.31, ROOM.push_end - 0.31), (0.5, ROOM.min_touch_distance)],
)
@pytest.mark.parametrize("alpha", [0.0, 0.5, -1.2])
def test_the_base_is_behind_the_push_line_and_looks_along_it(support, length, distance, alpha):
    layout = make_layout(SupportConfig(kind=support), PileConfig(), 0.054)
    direction = np.array([np.cos(alpha), np.sin(alpha)])
    touch = np.array([0.6, -0.1])
    placed = layout.with_base_behind_push(touch, touch + length * direction, np.zeros((0, 2)))
    base = placed.transform_base_to_world
    np.testing.assert_allclose(base.translation[:2], touch - distance * direction, atol=1e-12)
    np.testing.assert_allclose(base.rotation[:, 0], [*direction, 0.0], atol=1e-12)
    assert base.translation[2] == layout.transform_base_to_world.translation[2]
    np.testing.assert_allclose(placed.gravity, layout.gravity, atol=1e-12)
    assert placed.walls is layout.walls


def test_table_wall_and_corner_have_the_documented_distances():
    wall, corner = (make_layout(SupportConfig(kind=support), PileConfig(), 0.054) for support in ("wall", "corner"))
    assert wall.transform_base_to_world.translation[2] == -0.25
    assert wall.support_distance == wall.walls[0].center[0] - wall.walls[0].half_size[0] == pytest.approx(1.0)
    assert corner.support_distance == pytest.approx(1.1)
    for side in corner.walls:
        normal = np.array([np.cos(side.yaw), np.sin(side.yaw)])
        # The apex lies on the inner face of both walls.
        assert (np.array([1.1, 0.0]) - side.center[:2]) @ normal == pytest.approx(side.half_size[0])


def test_a_turned_base_is_upright_on_a_tilted_floor():
    layout = make_layout(SupportConfig(tilt_deg=5.0), PileConfig(), 0.054)
    placed = layout.with_base_behind_push(np.array([0.7, -0.2]), np.array([1.0, 0.0]), np.zeros((0, 2)))
    np.testing.assert_allclose(placed.gravity, layout.gravity, atol=1e-12)
    base = placed.transform_base_to_world.rotation
    np.testing.assert_allclose(base[:, 2], layout.transform_base_to_world.rotation[:, 2], atol=1e-12)


def test_the_base_keeps_off_every_object():
    layout = make_layout(SupportConfig(), PileConfig(), 0.054)
    touch, strays = np.array([0.45, 0.0]), np.array([[-0.2, 0.05], [-0.35, -0.1]])
    axis = layout.with_base_behind_push(touch, np.array([0.95, 0.0]), strays).transform_base_to_world.translation[:2]
    assert np.linalg.norm(strays - axis, axis=1).min() >= ROOM.base_radius
    assert axis[0] < -0.35


@pytest.mark.parametrize("support", SUPPORTS)
def test_a_wide_frame_keeps_clear_of_the_arm(support):
    for size in (0.1, 0.25, 0.33, 0.83):
        layout = make_layout(SupportConfig(kind=support), PileConfig(frame_size=size), 0.054)
        reach = size / np.sqrt(2.0) if support == "corner" else 0.5 * size
        assert layout.frame_center[0] - reach > ROOM.base_radius
        usual = make_layout(SupportConfig(kind=support), PileConfig(), 0.054)
        for wall, other in zip(layout.walls, usual.walls, strict=True):
            assert (wall.center[0] > other.center[0]) == (size > 0.8)


@pytest.mark.parametrize(
    ("support", "count"),
    [("none", 3), ("wall", 30), pytest.param("corner", 60, marks=pytest.mark.slow)],
)
def test_spheres_of_any_number_are_within_reach(support, count):
    overrides = {"support.kind": support, "pile.count": count, "pile.mass": 0.06}
    attempt = prepare(load_scenario("spheres_wall", overrides), 0)
    assert attempt.plan.primitives[1].travel > 0.1


@pytest.mark.parametrize("ratio", [0.3, 1.5])
def test_balls_of_any_size_are_within_reach_of_the_shovel(ratio):
    scale = ratio * 0.12 / 0.054
    keys = {"support.kind": "corner", "pile.scale": scale, "pile.frame_size": 0.25 * scale, "hand": "shovel"}
    assert prepare(load_scenario("spheres_wall", keys), 0).plan.primitives[1].travel > 0.15
