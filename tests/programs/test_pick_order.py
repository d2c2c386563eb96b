"""Orders from the bin: choice of the goal, delivery or drop, count, and one simulated order."""

import json
import math

import numpy as np
import pytest

from order_bin import BIN, CRATE, DELIVERY, HIGH, LAYOUT
from pilegrasp_ctrl import run
from pilegrasp_ctrl.config import build_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError, UnreachablePoseError
from pilegrasp_ctrl.planning.push_goal import FAILED_LINE_DISTANCE
from pilegrasp_ctrl.planning.strategy import Plan, tool_rotation
from pilegrasp_ctrl.primitives.grasp import Release
from pilegrasp_ctrl.programs.operator import BinState, SeeingOperator, TrueCounts
from pilegrasp_ctrl.programs.pick_order import PickOrder
from pilegrasp_ctrl.sections import IFCO_SIZE, ORDER_SIZE
from pilegrasp_ctrl.types import Outcome, Pose

AT_WALL, IN_CORNER = np.array([0.95, 0.03, 0.027]), np.array([0.93, 0.15, 0.027])


class World:
    """Replacement of the loop: each attempt lifts as many objects as the script says, or fails at a primitive."""

    def __init__(self, script, members=1, count=18, **order):
        self.script, self.members = list(script), members
        self.poses = np.zeros((count, 7))
        self.poses[:, :3] = AT_WALL
        self.time, self.names, self.withdrawn, self.goals, self.anchors, self.begun = 0.0, [], [], [], [], 0
        self.unreachable = set()
        scenario = build_scenario({}, BIN | {f"order.{key}": value for key, value in order.items()})
        counts = TrueCounts(CRATE, members, scenario.strategy.lift_height)
        self.sees = SeeingOperator(scenario, LAYOUT.bin, LAYOUT.goals, 0.06, counts, self.plan)
        self.order, self.counts = PickOrder(scenario, DELIVERY, counts, self.sees), counts

    def plan(self, poses, goal, posture):
        if goal.name in self.unreachable:
            raise UnreachablePoseError("out of reach")
        self.goals.append(goal.name)
        self.anchors.append(goal.anchor)
        start = Pose(HIGH, tool_rotation(goal.yaw, 0.9))
        return Plan(start, (Release(1.0, "lift"),), (), start, 0.3, np.array([1.0, 0.0, 0.0])), np.zeros(7)

    def state(self):
        return BinState(self.poses.copy(), HIGH, np.zeros(7), self.time)

    def begin(self, plan):
        self.begun += 1

    def run_primitives(self, primitives, retreating):
        outcomes = []
        for primitive in primitives:
            self.time += 1.0
            status, trigger = self.happens(primitive.name)
            self.names.append(primitive.name)
            if retreating:
                self.withdrawn.append(primitive.name)
            outcomes.append(Outcome(primitive.name, status, trigger, self.time - 1.0, self.time, 0.0, 0.0))
            if status == "failed":
                break
        return outcomes

    def happens(self, name):
        held = self.poses[:, 2] > 0.1
        if name == "lift":
            lifted = self.script.pop(0)
            if isinstance(lifted, str):
                return "failed", lifted
            lying = np.flatnonzero(self.poses[:, 0] > 0.7)[: lifted * self.members]
            self.poses[lying, :3] = HIGH
        elif name == "release":
            self.poses[held, :3] = [*CRATE.center, 0.03]
        elif name in ("drop_back", "retreat"):
            self.poses[held, :3] = AT_WALL
            if name == "retreat" and self.script[:1] == ["stuck"]:
                return "failed", "stuck"
        return "ended", "done"

    def fill(self):
        outcomes, reason = self.order.fill(self.state, self.begin, self.run_primitives)
        assert [outcome.name for outcome in outcomes] == self.names
        return reason


def test_an_order_of_four_takes_four_attempts_of_one():
    world = World([1, 1, 1, 1])
    assert world.fill() is None
    assert world.names == ["lift", "deliver", "release"] + 3 * ["return", "lift", "deliver", "release"]
    assert [attempt.delivered for attempt in world.order.attempts] == [1, 1, 1, 1]
    assert world.begun == 4
    ends = [attempt.end for attempt in world.order.attempts]
    assert [attempt.start for attempt in world.order.attempts] == [0.0, *ends[:-1]]


def test_more_objects_than_missing_are_dropped_back():
    world = World([3, 2, 1])
    assert world.fill() is None
    first, second, third = world.order.attempts
    assert (first.delivered, second.held, second.delivered, third.delivered) == (3, 2, 0, 1)
    assert second.reason == "2 held where 1 were missing: dropped back"
    assert world.counts.delivered(world.poses) == 4


def test_every_goal_is_tried_once_before_one_is_tried_again():
    world = World([1, 0, 0, 0, 0, 1, 2])
    assert world.fill() is None
    goals = [attempt.goal for attempt in world.order.attempts]
    assert goals == ["wall", "wall", "corner_left", "corner_right", "wall", "corner_left", "wall"]
    assert world.order.attempts[1].reason == "nothing was in the hand after the lift"


def test_a_goal_that_is_tried_again_is_tried_on_another_line_until_something_is_delivered():
    world = World([0, 0, 1, 3])
    world.unreachable = {"corner_left", "corner_right"}
    world.poses[:, :3] = [0.95, 0.05, 0.027]
    assert world.fill() is None
    first, second, third, fourth = (anchor[1] for anchor in world.anchors)
    apart = [abs(a - b) for a, b in ((first, second), (second, third), (first, third))]
    assert min(apart) >= FAILED_LINE_DISTANCE
    assert fourth == pytest.approx(first)


def test_the_goal_with_most_objects_before_the_hand_is_chosen():
    world = World([])
    # Objects in a row toward the corner. A push to the wall meets half of them and has no room for the others.
    world.poses[:4, :3], world.poses[4:8, :3], world.poses[8:, :3] = (
        IN_CORNER,
        [0.70, 0.017, 0.027],
        [0.95, -0.15, 0.027],
    )
    assert world.sees.plan_for(world.poses)[0].name == "corner_left"
    world.poses[8:, :3] = AT_WALL
    assert world.sees.plan_for(world.poses)[0].name == "wall"
    # Objects outside the bin do not count.
    world.poses[8:, :2] = 0.93, 0.5
    assert world.sees.plan_for(world.poses)[0].name == "corner_left"


def test_objects_too_far_right_for_the_wall_are_picked_from_the_right_corner():
    world = World([])
    world.poses[:, :3] = [0.97, -0.1, 0.025]
    line, plan, _ = world.sees.plan_for(world.poses)
    assert line.name == "corner_right"
    assert plan.start.rotation[1, 0] < 0.0


def test_a_goal_out_of_reach_is_skipped_and_the_order_ends_without_one():
    world = World([4])
    world.unreachable = {"wall"}
    assert world.sees.plan_for(world.poses)[0].name == "corner_left"
    world.unreachable = {"wall", "corner_left", "corner_right"}
    assert world.fill() == "out of reach"
    assert world.names == []


def test_a_failed_goal_is_tried_again_if_no_other_is_in_reach():
    world = World([0, 4])
    world.unreachable = {"corner_left", "corner_right"}
    assert world.fill() is None
    assert [attempt.goal for attempt in world.order.attempts] == ["wall", "wall"]


def test_a_failed_primitive_is_an_attempt_and_the_arm_retreats():
    world = World(["collision with the bin's rim", 4])
    assert world.fill() is None
    assert world.names == ["lift", "retreat", "return", "lift", "deliver", "release"]
    assert world.withdrawn == ["retreat"]
    assert world.order.attempts[0].reason == "lift: collision with the bin's rim"


def test_a_failed_retreat_ends_the_order():
    world = World(["jammed", "stuck"])
    assert world.fill() == "retreat: stuck"
    assert len(world.order.attempts) == 1


def test_an_order_ends_after_max_attempts():
    world = World([0, 1, 0, 1], max_attempts=3)
    assert world.fill() == "1 of 4 delivered after 3 attempts"
    assert len(world.order.attempts) == 3


def test_a_net_bag_counts_as_one():
    world = World([1, 1, 2], members=3, count=15)
    assert world.fill() is None
    assert [attempt.delivered for attempt in world.order.attempts] == [1, 1, 2]
    assert np.count_nonzero(CRATE.are_inside(world.poses)) == 12


def test_the_fingertips_travel_six_centimetres_above_the_rims_and_stop_short_of_the_crates_middle():
    point = DELIVERY.translation
    assert point[2] - IFCO_SIZE[2] == pytest.approx(0.06)
    assert point[2] - ORDER_SIZE[2] == pytest.approx(0.06)
    forward = DELIVERY.rotation[:2, 0]
    np.testing.assert_allclose(
        CRATE.center - point[:2], 0.25 * CRATE.inner[0] * forward / np.linalg.norm(forward), atol=1e-12
    )


def test_the_orders_crate_is_beside_the_bin():
    assert {wall.crate for wall in LAYOUT.walls} == {"bin", "order"}
    left = next(wall for wall in LAYOUT.walls if wall.name == "bin_left")
    right = next(wall for wall in LAYOUT.walls if wall.name == "order_right")
    assert right.center[1] - right.half_size[0] > left.center[1] + left.half_size[0]
    points = np.array([[*CRATE.center, 0.03], [*CRATE.center, 0.2], [0.9, 0.0, 0.03]])
    assert CRATE.are_inside(points).tolist() == [True, False, False]


@pytest.mark.parametrize(
    "keys", [{"support.bin": False}, {"hand": "shovel"}, {"pile.count": 0}], ids=["bin", "hand", "pile"]
)
def test_an_order_needs_a_bin_a_hand_that_opens_and_objects(keys):
    with pytest.raises(ConfigurationError, match=r"program = 'order' needs support\.bin = true"):
        build_scenario({}, BIN | keys)


def test_keys_without_effect_on_the_program_are_rejected():
    with pytest.raises(ConfigurationError, match=r"order\.count has no effect if program = 'grasp'"):
        build_scenario({}, {"order.count": 2})
    with pytest.raises(ConfigurationError, match=r"line\.speed has no effect if program = 'order'"):
        build_scenario({}, BIN | {"line.speed": 0.2})


@pytest.mark.slow
def test_the_object_of_an_order_of_one_ends_in_the_crate():
    result = run("bin_picking", overrides={"order.operator": "sees", "order.count": 1}, record=True)
    assert result.success, result.reason
    assert result.grasped == 1
    assert result.attempts[-1].delivered == 1
    assert [outcome.name for outcome in result.outcomes][-2:] == ["deliver", "release"]
    answer = json.loads(json.dumps(result.as_dict()))
    assert len(answer["attempts"]) == len(result.attempts)
    assert answer["attempts"][-1]["goal"] in ("wall", "corner_left", "corner_right")
    recording = result.recording
    assert recording.meta["attempts"] == answer["attempts"]
    objects = [index for index, body in enumerate(recording.bodies) if body.role == "object"]
    ends = recording.body_position[-1, objects]
    assert np.count_nonzero(CRATE.are_inside(ends)) == 1
    starts = recording.body_position[0, objects]
    assert not CRATE.are_inside(starts).any()
    assert math.isclose(result.attempts[-1].end, result.sim_time, abs_tol=0.01)


@pytest.mark.slow
def test_the_time_limit_holds_for_each_attempt(monkeypatch):
    monkeypatch.setattr("pilegrasp_ctrl.episode.TIME_LIMIT", 2.0)
    result = run("bin_picking", overrides={"order.operator": "sees", "order.max_attempts": 2, "pile.count": 1})
    assert [attempt.reason for attempt in result.attempts] == 2 * ["approach: time limit of 2 s"]
    assert [outcome.name for outcome in result.outcomes] == ["approach", "retreat", "return", "approach", "retreat"]
    assert result.outcomes[1].status == result.outcomes[4].status == "ended"
    assert result.reason == "0 of 4 delivered after 2 attempts"
    assert not result.success
    for attempt in result.attempts:
        assert 2.0 < attempt.end - attempt.start < 8.0
