"""A bin by keys: where it stands, and the goals that follow from bin, hand and arm by one rule."""

import math

import numpy as np
import pytest

from pilegrasp_ctrl.config import build_scenario, load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError, PileError
from pilegrasp_ctrl.planning.bin_goals import HAND_CLEARANCE, LEAST_SHARE, find_bin_goals
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.sections import OrderConfig
from pilegrasp_ctrl.vectors import rotated

SMALL = {"bin_size": [0.4, 0.3, 0.12]}


def layout_of(pile=None, order=None, **support):
    scenario = build_scenario({}, {f"support.{key}": value for key, value in support.items()} | (pile or {}))
    return make_layout(scenario.support, scenario.pile, 0.054, order)


def slab(left, right, back=0.05, height=0.1):
    """Return the outline of a box-shaped hand by the yaw of its push."""
    corners = np.array([[x, y, z, 0.0] for x in (-back, 0.0) for y in (-right, left) for z in (0.0, height)])

    def turned(yaw):
        balls = corners.copy()
        turn = [[math.cos(yaw), -math.sin(yaw), 0.0], [math.sin(yaw), math.cos(yaw), 0.0], [0.0, 0.0, 1.0]]
        balls[:, :3] = rotated(turn, balls[:, :3])
        return balls

    return turned


def goals_of(outline, arm=lambda yaw, touch, end: True, **support):
    layout = layout_of(**support)
    return find_bin_goals(layout.bin, layout.walls, outline, arm, layout.start_height)


def test_a_size_alone_means_a_bin_and_the_crate_of_the_paper_is_the_default():
    assert build_scenario({"support": SMALL}).support.bin
    assert load_scenario("bin_picking").support.bin_size == (0.56, 0.38, 0.16)
    assert load_scenario("bin_picking", {"order.operator": "sees"}).config_hash() == "339e07e16dc60ac3"
    assert build_scenario({}, {"support.bin": True}).config_hash() != build_scenario({"support": SMALL}).config_hash()


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        (
            {"support.bin_size": [0.4, -0.3, 0.12]},
            r"support\.bin_size\[1\] = -0\.3 is not allowed: it must be at",
        ),
        (
            {"support.bin_size": [40.0, 0.3, 0.12]},
            r"support\.bin_size\[0\] = 40\.0 is not allowed: it must be at",
        ),
        ({"support.bin_size": [0.4, 0.3]}, r"support\.bin_size = .* must be a list of 3 numbers, such as"),
        ({"support.bin_thickness": [0.0, 0.01], "support.bin": True}, r"support\.bin_thickness\[0\] = 0\.0"),
        (
            {"support.bin": False, "support.bin_size": [0.4, 0.3, 0.12]},
            r"support\.bin_size has no effect without a bin",
        ),
        ({"support.bin_yaw_deg": 20.0}, r"support\.bin_yaw_deg has no effect without a bin"),
        ({"pile.frame_position": [0.0, 0.0]}, r"pile\.frame_position has no effect without a bin"),
        ({"order.crate_size": [0.3, 0.3, 0.1]}, r"order\.crate_size has no effect if program = 'grasp'"),
    ],
)
def test_what_is_no_bin_is_refused(keys, sentence):
    with pytest.raises(ConfigurationError, match=sentence):
        build_scenario({}, keys)


def test_walls_stand_around_the_inner_size_with_their_own_heights_and_thickness():
    layout = layout_of(**SMALL, bin_wall_heights=[0.12, 0.06, 0.12, 0.1], bin_thickness=[0.01, 0.02])
    far, near, left, right = layout.walls
    assert far.center[0] - far.half_size[0] == pytest.approx(1.0)
    assert near.center[0] + near.half_size[0] == pytest.approx(0.6)
    assert left.center[1] - left.half_size[0] == pytest.approx(0.15)
    assert [2.0 * wall.half_size[2] for wall in layout.walls] == pytest.approx([0.12, 0.06, 0.12, 0.1])
    assert [2.0 * wall.half_size[0] for wall in layout.walls] == pytest.approx([0.01, 0.01, 0.02, 0.02])
    assert right.center[2] == pytest.approx(0.05)


def test_a_turned_bin_turns_the_arm_and_stays_where_the_arm_sees_it():
    layout = layout_of(bin=True, bin_position=[0.7, 0.1], bin_yaw_deg=30.0)
    to_base = layout.transform_base_to_world.inverse()
    middle = to_base.rotation @ [*layout.bin.center, 0.0] + to_base.translation
    assert middle[:2] == pytest.approx([0.7, 0.1])
    along = to_base.rotation @ [1.0, 0.0, 0.0]
    assert along == pytest.approx([math.cos(math.radians(30.0)), 0.5, 0.0])


def test_the_floor_of_a_bin_elsewhere_tilts_about_its_far_wall():
    layout = layout_of(bin=True, bin_position=[0.65, 0.05], tilt_deg=5.0)
    assert layout.support_distance == pytest.approx(0.65 + 0.28)


def test_the_frame_is_as_wide_as_a_narrow_bin_and_stands_where_it_is_put():
    assert layout_of({"pile.count": 18}, bin_size=[0.4, 0.2, 0.12]).frame_size == 0.2
    beside = layout_of({"pile.frame_position": [-0.05, 0.03]}, bin=True)
    assert beside.frame_center == pytest.approx([0.67, 0.03])
    for keys, sentence in (
        ({"pile.frame_position": [0.2, 0.0]}, "through a wall"),
        ({"pile.frame_size": 0.35}, "does not fit into the bin's width"),
    ):
        with pytest.raises(PileError, match=sentence):
            layout_of(keys, **SMALL)


def test_the_bin_and_the_orders_crate_must_have_room():
    with pytest.raises(ConfigurationError, match="the arm's base takes 200 mm"):
        layout_of(bin_size=[1.0, 0.3, 0.12])
    with pytest.raises(ConfigurationError, match="beside or behind the arm"):
        layout_of(bin=True, bin_position=[0.1, 1.0])
    with pytest.raises(ConfigurationError, match="puts the order's crate into the bin"):
        layout_of(order=OrderConfig(crate_position=(0.7, 0.1)), bin=True)
    crate = layout_of(order=OrderConfig(), **SMALL).order_crate
    assert crate.center[1] - 0.14 - 0.0075 == pytest.approx(0.15 + 0.0075 + 0.04)


def test_the_fingertips_start_six_centimetres_above_the_highest_wall():
    assert layout_of(bin=True).start_height == pytest.approx(0.22)
    assert layout_of(bin_size=[0.5, 0.4, 0.3]).start_height == pytest.approx(0.36)


def test_every_line_to_the_far_wall_leaves_the_hand_its_clearance():
    wall = goals_of(slab(0.05, 0.08), bin=True)[0]
    assert wall.anchor == pytest.approx([1.0, 0.0])
    assert wall.lateral_range[0] == pytest.approx(-0.19 + 0.08 + HAND_CLEARANCE, abs=0.005)
    assert wall.lateral_range[1] == pytest.approx(0.19 - 0.05 - HAND_CLEARANCE, abs=0.005)
    # Back to the near wall, less the depth of the hand, its clearance, and the way that it comes from behind.
    assert wall.longest == pytest.approx(0.56 - 0.05 - HAND_CLEARANCE - 0.03, abs=0.011)


def test_corners_of_a_symmetric_hand_are_mirror_images():
    _, left, right = goals_of(slab(0.05, 0.05), bin=True)
    assert (left.name, right.name) == ("corner_left", "corner_right")
    assert left.yaw == pytest.approx(-right.yaw)
    assert left.lateral_range == pytest.approx((-right.lateral_range[1], -right.lateral_range[0]))
    assert left.longest == pytest.approx(right.longest)


def test_the_first_line_to_a_corner_meets_both_walls_at_once():
    outline, goals = slab(0.05, 0.08), goals_of(slab(0.05, 0.08), bin=True)
    for goal in goals[1:]:
        side = 1.0 if goal.name == "corner_left" else -1.0
        direction, left = np.array([math.cos(goal.yaw), math.sin(goal.yaw)]), [-math.sin(goal.yaw), math.cos(goal.yaw)]
        first = goal.lateral_range[1] if side > 0.0 else goal.lateral_range[0]
        balls = outline(goal.yaw)[:, :2] + goal.anchor + first * np.array(left)
        to_far = (1.0 - balls[:, 0].max()) / direction[0]
        to_side = (0.19 - (side * balls[:, 1]).max()) / abs(direction[1])
        assert to_far == pytest.approx(to_side, abs=1e-9)


def test_a_corner_is_met_nearest_to_its_bisector_where_the_push_is_long_enough():
    def arm(yaw, touch, end):
        return abs(yaw) < math.radians(31.0)

    goals = goals_of(slab(0.05, 0.05), arm, bin=True)
    assert [round(math.degrees(goal.yaw)) for goal in goals] == [0, 30, -30]
    assert all(goal.longest >= LEAST_SHARE * goals[0].longest for goal in goals)
    assert [goal.name for goal in goals_of(slab(0.05, 0.05), lambda yaw, *_: yaw == 0.0, bin=True)] == ["wall"]


def test_the_arm_decides_how_far_back_a_push_may_begin():
    wall = goals_of(slab(0.05, 0.05), lambda yaw, touch, end: touch[0] >= 0.75, bin=True)[0]
    assert wall.longest == pytest.approx(0.25, abs=0.011)


@pytest.mark.parametrize(
    ("hand", "support", "sentence"),
    [
        (slab(0.1, 0.1), {"bin_size": [0.4, 0.22, 0.12]}, "the hand is 200 mm wide and needs 240 mm between the walls"),
        (slab(0.05, 0.05, back=0.15), {"bin_size": [0.25, 0.3, 0.12]}, "is too short for the hand"),
    ],
)
def test_a_hand_that_does_not_fit_is_refused(hand, support, sentence):
    with pytest.raises(ConfigurationError, match=sentence):
        goals_of(hand, **support)


def test_a_bin_out_of_reach_is_refused():
    with pytest.raises(ConfigurationError, match=r"the arm cannot push in the bin .*change support\.bin_position"):
        goals_of(slab(0.05, 0.05), lambda *_: False, bin=True)


def test_a_low_near_wall_lets_the_hand_come_down_farther_back():
    usual, low = (
        goals_of(slab(0.05, 0.05, back=0.2, height=0.05), bin=True, bin_wall_heights=heights)[0].longest
        for heights in (None, [0.16, 0.02, 0.16, 0.16])
    )
    assert low >= usual
