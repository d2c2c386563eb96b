"""The line of a push into a corner: both sides of the hand meet their walls at the same time."""

import numpy as np
import pytest

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.planning.arm_room import default_room
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.planning.push_line import center_between_walls, plan_push_line
from pilegrasp_ctrl.planning.strategy import tool_rotation
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sections import PileConfig, StrategyConfig, SupportConfig
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.objects import objects_of

WALL_CLEARANCE = 0.02
"""Clearance of the hand to a wall that it passes [m]; hand and arm deflect sideways by less."""

POINT = np.array([1.0, -0.02])
APEX = np.array([default_room().corner_distance, 0.0])


def walls(support):
    return make_layout(SupportConfig(kind=support), PileConfig(), 0.054).walls


def along(alpha):
    return np.array([np.cos(np.radians(alpha)), np.sin(np.radians(alpha))])


def turned(hand, alpha, beta):
    outline = hand.outline()
    outline[:, :3] = outline[:, :3] @ tool_rotation(np.radians(alpha + beta), hand.theta).T
    return outline


def gaps(outline, fingertips):
    """Distance of the hand to the left and to the right wall of the corner [m]."""
    low = outline[outline[:, 2] - outline[:, 3] < 0.16]
    normals = -np.array([along(45.0), along(-45.0)])
    return ((fingertips - APEX + low[:, :2]) @ normals.T - low[:, 3:]).min(axis=0)


def test_a_ball_between_two_walls_moves_along_their_bisector():
    ball = np.array([[0.0, 0.0, 0.0, 0.03]])
    np.testing.assert_allclose(center_between_walls(walls("corner"), ball, along(0.0), POINT), [1.0, 0.0], atol=1e-12)


def test_parts_of_the_hand_above_the_walls_do_not_count():
    balls = np.array([[0.0, 0.0, 0.0, 0.03], [0.0, -0.2, 0.2, 0.03]])
    np.testing.assert_allclose(center_between_walls(walls("corner"), balls, along(0.0), POINT), [1.0, 0.0], atol=1e-12)


@pytest.mark.parametrize("name", ["rbo_hand2", "shovel"])
@pytest.mark.parametrize("alpha", [-30.0, 0.0, 20.0])
@pytest.mark.parametrize("beta", [-20.0, 0.0])
def test_both_sides_of_the_hand_meet_their_walls_at_the_same_time(name, alpha, beta):
    outline = turned(Hand.load(name), alpha, beta)
    line = center_between_walls(walls("corner"), outline, along(alpha), POINT)
    assert (line - POINT) @ along(alpha) == pytest.approx(0.0, abs=1e-12)
    left, right = -along(45.0) @ along(alpha), -along(-45.0) @ along(alpha)
    gap = gaps(outline, line) - WALL_CLEARANCE
    assert gap[0] / left == pytest.approx(gap[1] / right)


@pytest.mark.parametrize("beta", [-20.0, 0.0, 20.0])
def test_the_thumb_keeps_clear_of_a_wall_along_the_push(beta):
    outline = turned(Hand.load("rbo_hand2"), 45.0, beta)
    line = center_between_walls(walls("corner"), outline, along(45.0), POINT)
    for distance in (-0.1, 0.0, 0.05):
        assert gaps(outline, line + distance * along(45.0))[1] == pytest.approx(WALL_CLEARANCE)


@pytest.mark.parametrize("support", ["none", "wall"])
def test_without_two_walls_the_push_line_is_not_moved(support):
    outline = turned(Hand.load("rbo_hand2"), 45.0, -20.0)
    assert center_between_walls(walls(support), outline, along(45.0), POINT) is POINT


def test_a_wall_behind_the_push_does_not_count():
    outline = turned(Hand.load("rbo_hand2"), 60.0, 0.0)
    assert center_between_walls(walls("corner"), outline, along(60.0), POINT) is POINT


def test_an_attempt_among_cylinders_in_a_corner_touches_down_beside_the_wall(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    keys = {"pile.object": "cylinder", "pile.count": 3, "support.kind": "corner"}
    keys |= {"strategy.alpha_deg": 45.0, "strategy.beta_deg": -20.0}
    plan = prepare(load_scenario("spheres_wall", keys), 0).plan
    outline = turned(Hand.load("rbo_hand2"), 45.0, -20.0)
    for pose in (plan.waypoints[1], plan.end):
        assert gaps(outline, pose.translation[:2])[1] == pytest.approx(WALL_CLEARANCE)


@pytest.mark.parametrize(("alpha", "beta"), [(0.0, 0.0), (30.0, -10.0), (45.0, -20.0)])
def test_beside_a_wall_the_push_ends_behind_the_middle_of_the_pile(alpha, beta):
    strategy = StrategyConfig(alpha_deg=alpha, beta_deg=beta)
    pile = PileConfig()
    layout = make_layout(SupportConfig(kind="wall"), pile, 0.054)
    poses = np.zeros((4, 7))
    poses[:, :2] = [[0.90, 0.0], [0.93, 0.01], [0.96, 0.05], [0.96, 0.4]]
    line = plan_push_line(strategy, Hand.load("rbo_hand2").use, layout, poses, objects_of(pile).bounding_radius)
    behind = np.array([layout.support_distance - 0.027, 0.02])
    offset = behind - line.touch(strategy)
    assert offset @ along(alpha) > 0.1
    np.testing.assert_allclose(offset - (offset @ along(alpha)) * along(alpha), 0.0, atol=1e-9)


def test_beside_a_wall_the_shovel_passes_between_the_columns_of_an_odd_number_of_balls():
    pile, columns = PileConfig(count=15), np.array([-0.085, -0.028, 0.028, 0.085])
    layout = make_layout(SupportConfig(kind="wall"), pile, 0.054)
    poses = np.zeros((15, 7))
    poses[:, 0] = 0.97 - 0.056 * (np.arange(15) // 4)
    poses[:, 1] = columns[np.arange(15) % 4]
    line = plan_push_line(StrategyConfig(), Hand.load("shovel").use, layout, poses, objects_of(pile).bounding_radius)
    assert np.abs(columns - line.touch(StrategyConfig())[1]).min() > 0.02


def test_of_two_objects_far_apart_the_push_goes_to_one():
    pile = PileConfig(count=2)
    layout = make_layout(SupportConfig(kind="wall"), pile, 0.054)
    poses = np.zeros((2, 7))
    poses[:, :2] = [[0.9, -0.2], [0.9, 0.3]]
    line = plan_push_line(StrategyConfig(), Hand.load("rbo_hand2").use, layout, poses, objects_of(pile).bounding_radius)
    assert line.touch(StrategyConfig())[1] in poses[:, 1]
