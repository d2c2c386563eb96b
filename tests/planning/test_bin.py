"""The bin: its walls, the goals of a push in it, and its rim, which neither arm nor hand may hit."""

import math
from dataclasses import replace
from itertools import product

import mujoco
import numpy as np
import pytest

import bins
from pilegrasp_ctrl import run
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError, PileError, UnreachablePoseError
from pilegrasp_ctrl.planning.arm_room import default_room
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.planning.push_goal import FAILED_LINE_DISTANCE, PushGoal
from pilegrasp_ctrl.planning.push_line import plan_push_line
from pilegrasp_ctrl.programs import bin_reach
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sections import IFCO_SIZE, PileConfig, SupportConfig
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.objects import objects_of
from pilegrasp_ctrl.sim.start_posture import StartPosture

EMPTY = {"pile.count": 0, "program": "push"}


def layout_of(support="wall", **pile):
    return make_layout(SupportConfig(kind=support, bin=True), PileConfig(**pile), 0.054)


@pytest.mark.parametrize("support", ["wall", "corner"])
def test_the_walls_enclose_the_crates_inner_size_and_nothing_overlaps_it(support):
    far, near, left, right = layout_of(support).walls
    length, width, height = IFCO_SIZE
    assert (length, width, height) == (0.56, 0.38, 0.16)
    assert far.center[0] - far.half_size[0] == pytest.approx(default_room().wall_distance)
    assert near.center[0] + near.half_size[0] == pytest.approx(default_room().wall_distance - length)
    assert left.center[1] - left.half_size[0] == pytest.approx(0.5 * width)
    assert right.center[1] + right.half_size[0] == pytest.approx(-0.5 * width)
    # Outer sizes of the laboratory's model.
    assert far.center[0] + far.half_size[0] - near.center[0] + near.half_size[0] == pytest.approx(0.595)
    assert left.center[1] + left.half_size[0] - right.center[1] + right.half_size[0] == pytest.approx(0.395)
    for wall in (far, near, left, right):
        assert wall.center[2] == wall.half_size[2] == 0.5 * height
        inward = np.array([default_room().wall_distance - 0.5 * length, 0.0]) - wall.center[:2]
        assert inward @ [math.cos(wall.yaw), math.sin(wall.yaw)] > 0.0


@pytest.mark.parametrize("support", ["wall", "corner"])
def test_the_frame_is_inside_the_bin_and_touches_the_support(support):
    layout = layout_of(support)
    corners = layout.frame_center + 0.5 * layout.frame_size * np.array(list(product((-1, 1), repeat=2)))
    assert corners[:, 0].max() == pytest.approx(default_room().wall_distance)
    assert np.abs(corners[:, 1]).max() <= 0.5 * IFCO_SIZE[1] + 1e-9
    assert (np.abs(corners[:, 1]).max() == pytest.approx(0.5 * IFCO_SIZE[1])) == (support == "corner")
    with pytest.raises(PileError, match="does not fit into the bin"):
        layout_of(support, frame_size=0.4)


def test_the_first_goal_is_the_one_that_was_asked_for():
    assert [goal.name for goal in bins.layout_of("wall").goals] == ["wall", "corner_left", "corner_right"]
    assert [goal.name for goal in bins.layout_of("corner").goals] == ["corner_left", "corner_right", "wall"]
    assert make_layout(SupportConfig(), PileConfig(), 0.054).goals == ()
    corner = bins.layout_of("corner").goals[0]
    np.testing.assert_allclose(corner.anchor, [default_room().wall_distance, 0.5 * IFCO_SIZE[1]])


def test_thumb_and_little_finger_have_room_between_the_long_walls_on_every_line_to_the_wall():
    goal = bins.layout_of("wall").goals[0]
    thumb, little_finger = goal.lateral_range[0] - 0.145, goal.lateral_range[1] + 0.05
    assert thumb > -0.5 * IFCO_SIZE[1] + 0.01
    assert little_finger < 0.5 * IFCO_SIZE[1] - 0.01


def test_the_push_line_has_most_objects_before_it_within_its_lateral_range():
    wall = PushGoal("wall", np.array([1.0, 0.0]), 0.0, (-0.03, 0.12))
    heap = np.array([[0.95, 0.08], [0.9, 0.09], [0.9, 0.10], [0.95, -0.15]])
    line, count = wall.best_line(heap, 0.03)
    assert count == 3
    assert line.anchor == pytest.approx([1.0, 0.09], abs=0.021)
    # The lines are 10 mm apart, so the only one within 20 mm of both objects is found.
    line, count = wall.best_line(np.array([[0.9, 0.06], [0.9, 0.10]]), 0.021)
    assert (line.anchor[1], count) == (pytest.approx(0.08), 2)
    beyond, count = wall.best_line(np.array([[0.9, 0.15], [0.9, 0.16]]), 0.06)
    assert count == 2
    assert -0.03 <= beyond.anchor[1] <= 0.12
    corner = PushGoal("corner_left", np.array([1.0, 0.19]), math.radians(30.0))
    line, count = corner.best_line(np.array([[1.0 - math.sqrt(3.0) * 0.1, 0.09], [0.9, -0.1]]), 0.05)
    np.testing.assert_allclose(line.anchor, corner.anchor)
    assert count == 1


def test_a_goal_is_tried_again_beside_its_failed_lines_unless_it_has_one_line_only():
    wall = PushGoal("wall", np.array([1.0, 0.0]), 0.0, (-0.03, 0.12))
    heap = np.array([[0.95, 0.03], [0.9, 0.04], [0.95, 0.05], [0.9, 0.06]])
    first, count = wall.best_line(heap, 0.06)
    second, _ = wall.best_line(heap, 0.06, [first])
    assert count == 4
    assert abs(second.anchor[1] - first.anchor[1]) >= FAILED_LINE_DISTANCE
    # Another line brings nothing without an object before it. Failed lines to other goals do not count.
    alone = np.array([[0.95, 0.17]])
    assert wall.best_line(alone, 0.06, 5 * [wall.best_line(alone, 0.06)[0]])[1] == 1
    assert wall.best_line(heap, 0.06, [replace(first, name="corner_left")])[0].anchor == pytest.approx(first.anchor)
    # A goal that is already on its line has no other line.
    assert first.best_line(heap[:1], 0.06, [first])[0].anchor == pytest.approx(first.anchor)


def test_the_reach_deficit_is_measured_along_the_push():
    ahead, slanting = np.array([1.0, 0.0]), np.array([math.cos(0.5), math.sin(0.5)])
    wall = PushGoal("wall", np.array([1.0, 0.0]), 0.0, longest=0.3)
    assert wall.reach_deficit(np.array([0.72, 0.1]), ahead) == 0.0
    assert wall.reach_deficit(np.array([0.68, 0.1]), ahead) == pytest.approx(0.02)
    corner = PushGoal("corner_left", np.array([1.0, 0.19]), 0.5, longest=0.3)
    assert corner.reach_deficit(corner.anchor - 0.31 * slanting, slanting) == pytest.approx(0.01)
    assert PushGoal("wall", np.zeros(2), 0.0).reach_deficit(np.array([-5.0, 0.0]), ahead) == 0.0


@pytest.mark.parametrize(("nearest_ball", "touch"), [(0.80, 0.723), (0.77, 0.70), (0.74, 0.70)])
def test_a_pile_near_the_arm_is_met_with_less_clearance(nearest_ball, touch):
    scenario = load_scenario("bin_picking")
    objects, layout = objects_of(scenario.pile), layout_of()
    goal = PushGoal("wall", np.array([1.0, 0.0]), 0.0, (-0.03, 0.12), longest=0.3)
    balls = np.zeros((5, 7))
    balls[:, :3] = np.array([np.linspace(nearest_ball, 0.97, 5), np.zeros(5), np.full(5, 0.027)]).T
    hand, radius = Hand.load("rbo_hand2").use, objects.bounding_radius
    line = plan_push_line(scenario.strategy, hand, layout, balls, radius, goal=goal)
    assert line.touch(scenario.strategy)[0] == pytest.approx(touch)


def test_a_pile_too_near_to_the_arm_for_the_wrist_is_unreachable():
    scenario = load_scenario("bin_picking")
    balls = np.zeros((5, 7))
    balls[:, :3] = np.array([np.linspace(0.73, 0.97, 5), np.zeros(5), np.full(5, 0.027)]).T
    hand, layout, radius = Hand.load("rbo_hand2").use, layout_of(), objects_of(scenario.pile).bounding_radius
    goal = PushGoal("wall", np.array([1.0, 0.0]), 0.0, (-0.03, 0.12), longest=0.3)
    with pytest.raises(UnreachablePoseError, match="hand or arm would hit a wall of the bin"):
        plan_push_line(scenario.strategy, hand, layout, balls, radius, goal=goal)


def placed(attempt, part, target):
    """Move the hand so that the centre of the geom `part` is at `target`; return the collision that is found."""
    simulation, plan = attempt.simulation, attempt.plan
    data, hand = simulation.data, Hand.load("rbo_hand2")
    search = StartPosture("wam7", hand.transform_tool_to_flange, layout_of(count=0).transform_base_to_world)
    start = search.solve(plan.start)
    data.qpos[:7] = start
    mujoco.mj_forward(simulation.scene.model, data)
    displacement = np.asarray(target) - data.geom_xpos[part]
    data.qpos[:7] = search.solve(plan.start.moved(displacement), start)
    mujoco.mj_forward(simulation.scene.model, data)
    data.time += 1.0
    return simulation.find_collision()


@pytest.fixture(scope="module")
def attempt():
    # The tip of a steeper hand cannot be put on the far rim.
    return prepare(load_scenario("bin_picking", EMPTY | {"support.tilt_deg": 0.0, "strategy.theta_deg": 50.0}), 0)


def test_fingers_may_touch_a_wall_but_not_its_rim(attempt):
    model = attempt.simulation.scene.model
    tip = int(model.body("middle_4").geomadr[0])
    assert placed(attempt, tip, [0.995, 0.0, 0.05]) is None
    assert attempt.simulation.data.ncon > 0
    verdict = placed(attempt, tip, [0.995, 0.0, 0.155])
    assert verdict.startswith("collision with the bin's rim: ")
    assert verdict.endswith("at bin_far")


def test_the_wrist_may_not_touch_a_wall(attempt):
    sensor = attempt.simulation.scene.model.geom("sensor").id
    verdict = placed(attempt, sensor, [0.7, 0.16, 0.11])
    assert verdict in {f"collision with the bin's rim: {part} at bin_left" for part in ("sensor", "link5", "link6")}


def test_an_object_that_touches_a_wall_is_not_a_collision():
    attempt = prepare(load_scenario("bin_picking", {"pile.count": 3}), 0)
    data = attempt.simulation.data
    names = {frozenset(pair) for pair in data.contact.geom.tolist()}
    assert any(attempt.simulation.scene.model.geom("bin_far").id in pair for pair in names)
    data.time = 1.0
    assert attempt.simulation.find_collision() is None


STEEP = EMPTY | {"support.tilt_deg": 15.0, "strategy.clearance": 0.2}
"""On a steeper floor the upright arm's elbow comes down on the near wall."""


def test_a_bin_in_which_the_arm_would_hit_the_rim_is_refused():
    with pytest.raises(ConfigurationError, match="the arm's links would come down on a wall; change"):
        prepare(load_scenario("bin_picking", STEEP), 0)


@pytest.mark.slow
def test_an_arm_that_hits_the_rim_ends_its_primitive(monkeypatch):
    monkeypatch.setattr(bin_reach._Reach, "clears", lambda *_: True)
    monkeypatch.setattr(bin_reach, "_found", {})
    result = run("bin_picking", overrides=STEEP)
    assert not result.success
    assert result.outcomes[-1].status == "failed"
    assert result.reason == "push: collision with the bin's rim: link4 at bin_near"


@pytest.mark.slow
@pytest.mark.parametrize("support", ["wall", "corner"])
def test_a_push_in_the_bin_reaches_its_goal_without_touching_the_rim(support):
    result = run("bin_picking", overrides=EMPTY | {"support.kind": support}, record=True)
    assert result.success, result.reason
    assert [outcome.trigger for outcome in result.outcomes] == ["surface contact", "grasp force"]
    x, y, _ = result.recording.signals["tool_position"][-1]
    assert (x > 0.965) if support == "wall" else (y > 0.09 and x > 0.88)
    # It starts above the rim.
    assert result.recording.signals["tool_position"][0, 2] > IFCO_SIZE[2] + 0.05
