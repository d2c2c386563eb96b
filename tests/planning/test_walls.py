"""Walls of the open table: their positions, and their contact with the frame."""

from itertools import product

import numpy as np
import pytest

from pilegrasp_ctrl.config import PileConfig, SupportConfig
from pilegrasp_ctrl.planning.arm_room import default_room
from pilegrasp_ctrl.planning.layout import WALL_HALF_HEIGHT, make_layout

ROOM = default_room()


def layout_of(support):
    return make_layout(SupportConfig(kind=support), PileConfig(), 0.054)


def normal_of(wall):
    return np.array([np.cos(wall.yaw), np.sin(wall.yaw)])


def test_walls_are_on_the_table_and_face_the_pile():
    assert layout_of("none").walls == ()
    (wall,) = layout_of("wall").walls
    np.testing.assert_allclose(normal_of(wall), [-1.0, 0.0], atol=1e-12)
    corner = layout_of("corner").walls
    np.testing.assert_allclose(sorted(normal_of(wall)[1] for wall in corner), [-np.sqrt(0.5), np.sqrt(0.5)])
    for layout in (layout_of("wall"), layout_of("corner")):
        half = 0.5 * layout.frame_size
        turn = np.array([[np.cos(layout.frame_yaw), -np.sin(layout.frame_yaw)],
                         [np.sin(layout.frame_yaw), np.cos(layout.frame_yaw)]])  # fmt: skip
        frame = layout.frame_center + np.array(list(product((-half, half), repeat=2))) @ turn.T
        for wall in layout.walls:
            assert wall.center[2] == wall.half_size[2] == WALL_HALF_HEIGHT
            depth = (frame - wall.center[:2]) @ normal_of(wall) - wall.half_size[0]
            assert depth.min() == pytest.approx(0.0, abs=1e-9)
            along = (frame - wall.center[:2]) @ [-normal_of(wall)[1], normal_of(wall)[0]]
            assert np.abs(along).max() <= wall.half_size[1] + 1e-9


def test_the_inner_faces_are_at_the_stated_distances():
    (wall,) = layout_of("wall").walls
    assert wall.center[0] - wall.half_size[0] == pytest.approx(ROOM.wall_distance)
    apex = np.array([ROOM.corner_distance, 0.0])
    for wall in layout_of("corner").walls:
        assert (apex - wall.center[:2]) @ normal_of(wall) == pytest.approx(wall.half_size[0])
    left, right = layout_of("corner").walls
    np.testing.assert_allclose(left.center * [1, -1, 1], right.center, atol=1e-12)
    assert left.center[1] > 0.0


def test_the_table_is_above_the_arms_base():
    base = layout_of("wall").transform_base_to_world
    np.testing.assert_array_equal(base.translation, [0.0, 0.0, -ROOM.base_below_table])
    np.testing.assert_array_equal(base.rotation, np.eye(3))
