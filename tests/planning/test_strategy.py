"""The plan of an attempt: touch-down, push distance and lift."""

import numpy as np
import pytest

from pilegrasp_ctrl.planning.hand_use import HandUse
from pilegrasp_ctrl.planning.strategy import MIN_GAP, pile_extent, plan_attempt, plan_line, tool_rotation
from pilegrasp_ctrl.primitives.primitive import PrimitiveInput, Setpoint
from pilegrasp_ctrl.sections import LineConfig, StrategyConfig
from pilegrasp_ctrl.types import Pose, Reference

X = np.array([1.0, 0.0, 0.0])
HERE = Pose([0.9, 0.0, 0.0], tool_rotation(0.0, 0.8))
HAND = HandUse(0.8, 0.006, 0.0, 0.3, 2.0, 0.04, 0.0, 0.083, np.zeros((0, 4)), 0.06, 0.06, True)


def test_the_plan_places_the_hand_behind_the_pile_and_turns_with_alpha_and_beta():
    config = StrategyConfig(alpha_deg=30.0, beta_deg=-10.0, theta_deg=50.0)
    center = np.array([0.9, 0.0])
    plan = plan_attempt(config, HAND, center, 0.12, 1.0)
    direction = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6), 0.0])
    touch = plan.waypoints[1].translation
    np.testing.assert_allclose(touch, [*center, 0.0] - (0.12 + config.clearance) * direction, atol=1e-12)
    np.testing.assert_allclose(plan.primitives[1].direction, direction)
    fingers = plan.start.rotation[:, 0]
    assert np.degrees(np.arcsin(-fingers[2])) == pytest.approx(50.0)
    assert np.degrees(np.arctan2(fingers[1], fingers[0])) == pytest.approx(20.0)
    np.testing.assert_allclose(plan.start.rotation.T @ plan.start.rotation, np.eye(3), atol=1e-12)
    assert np.linalg.norm(plan.end.translation[:2]) == pytest.approx(1.0)
    assert [primitive.name for primitive in plan.primitives] == ["approach", "push", "grasp", "lift"]
    assert len(plan_attempt(config, HAND, center, 0.12, 1.0, grasp=False).primitives) == 2


def test_an_attempt_starts_above_and_behind_the_touch_down():
    plan = plan_attempt(StrategyConfig(alpha_deg=30.0), HAND, np.array([0.9, 0.0]), 0.12, 1.0)
    pre_grasp, touch = (pose.translation for pose in plan.waypoints)
    np.testing.assert_allclose(pre_grasp - touch, [0.0, 0.0, 0.06], atol=1e-12)
    np.testing.assert_allclose(plan.start.translation - touch, [*(-0.06 * plan.direction[:2]), 0.22], atol=1e-12)


@pytest.mark.parametrize("alpha_deg", [0.0, 30.0, -60.0])
def test_the_lift_leaves_the_support_by_six_centimetres_against_the_push(alpha_deg):
    plan = plan_attempt(StrategyConfig(alpha_deg=alpha_deg), HAND, np.array([0.9, 0.0]), 0.12, 1.0)
    lift = plan.primitives[-1]
    held = Setpoint(Reference(plan.end), 1.0)
    active = lift.begin(PrimitiveInput(0.0, plan.end, np.zeros(6)), held)
    away = active.path.lines[0].displacement
    np.testing.assert_allclose(away, [*(-0.06 * plan.direction[:2]), 0.06], atol=1e-12)
    assert active.path.end.translation[2] == pytest.approx(StrategyConfig().lift_height)


def test_the_hand_holds_lifted_objects_for_a_second_as_in_the_paper():
    lift = plan_attempt(StrategyConfig(), HAND, np.array([0.9, 0.0]), 0.12, 1.0).primitives[-1]
    active = lift.begin(PrimitiveInput(0.0, HERE, np.zeros(6)), Setpoint(Reference(HERE), 1.0))
    lifted = HERE.moved([0.0, 0.0, StrategyConfig().lift_height])
    for after, ends in ((0.99, False), (1.01, True)):
        inputs = PrimitiveInput(active.path.duration + after, lifted, np.zeros(6))
        assert (active.ending(inputs) is not None) == ends


def test_a_line_has_the_requested_start_and_end():
    plan = plan_line(LineConfig(start=(0.6, -0.1, 0.3), displacement=(0.0, 0.2, 0.0)), HAND)
    np.testing.assert_allclose(plan.start.translation, [0.6, -0.1, 0.3])
    np.testing.assert_allclose(plan.end.translation, [0.6, 0.1, 0.3])


def test_only_objects_in_front_of_the_four_fingers_count_for_the_extent():
    """The fingers of the RBO Hand 2 are 0.12 m wide: an object counts if its edge is less than 0.06 m off the line."""
    radius, center = 0.027, np.zeros(2)
    inside, beside = (np.array([[0.0, 0.0], [-0.1, aside]]) for aside in (0.085, 0.089))
    assert pile_extent(inside, radius, center, X[:2], 0.06) == pytest.approx(0.127)
    assert pile_extent(beside, radius, center, X[:2], 0.06) == pytest.approx(0.027)


def test_the_piles_edge_ignores_strays():
    radius, center, push = 0.027, np.zeros(2), X[:2]
    row = np.array([[-0.1, 0.0], [-0.05, 0.02], [0.0, 0.0], [0.06, 0.0]])
    assert pile_extent(row, radius, center, push, 0.06) == pytest.approx(0.127)
    behind = np.vstack([row, [-0.3, 0.0]])
    assert pile_extent(behind, radius, center, push, 0.06) == pytest.approx(0.127)
    aside = np.vstack([row, [-0.14, 0.2]])
    assert pile_extent(aside, radius, center, push, 0.06) == pytest.approx(0.127)


def test_a_gap_too_narrow_for_the_hand_belongs_to_the_pile():
    radius, center, push = 0.027, np.zeros(2), X[:2]
    narrow, wide = (np.array([[0.0, 0.0], [-2.0 * radius - gap, 0.0]]) for gap in (MIN_GAP - 0.01, MIN_GAP + 0.01))
    assert pile_extent(narrow, radius, center, push, 0.06) == pytest.approx(3.0 * radius + MIN_GAP - 0.01)
    assert pile_extent(wide, radius, center, push, 0.06) == pytest.approx(radius)
    assert pile_extent(narrow, radius, center, push, 0.06, gap=radius) == pytest.approx(radius)
