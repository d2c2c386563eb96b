"""Orders without seeing: lines in turn, counts by weight, and no pose of an object in any decision."""

import inspect
import math

import numpy as np
import pytest

from order_bin import BIN, CRATE, DELIVERY, HIGH, LAYOUT
from pilegrasp_ctrl.config import build_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError, UnreachablePoseError
from pilegrasp_ctrl.planning.push_goal import PushGoal
from pilegrasp_ctrl.planning.strategy import Plan, tool_rotation
from pilegrasp_ctrl.primitives.guarded_motions import Approach
from pilegrasp_ctrl.primitives.primitive import PrimitiveInput, Setpoint
from pilegrasp_ctrl.primitives.weigh import REST_TIME, WEIGHING_TIME, Weigh
from pilegrasp_ctrl.programs import blind_operator, line_rules
from pilegrasp_ctrl.programs.blind_operator import BlindOperator
from pilegrasp_ctrl.programs.line_rules import SPACING, Told, alternates, bandit, fixed_lines, touch_distance
from pilegrasp_ctrl.programs.operator import BinState, TrueCounts
from pilegrasp_ctrl.programs.pick_order import PickOrder
from pilegrasp_ctrl.types import Outcome, Pose, Reference

WEIGHT = 0.6
LINES = fixed_lines(LAYOUT.goals)


def plan_line(line, posture):
    start = Pose(HIGH, tool_rotation(line.yaw, 0.9))
    return Plan(start, (), (), start, 0.3, np.array([1.0, 0.0, 0.0])), np.zeros(7)


class Bin:
    """Replacement of the loop: the hand lifts as many parts as the script says, and the wrist weighs them."""

    def __init__(self, script, rule=alternates, error=0.0, lost=0, **order):
        self.script, self.error, self.lost = list(script), error, lost
        self.load, self.time = 0, 0.0
        self.poses = np.zeros((18, 7))
        self.poses[:, :3] = [0.95, 0.0, 0.027]
        scenario = build_scenario({}, BIN | {f"order.{key}": value for key, value in order.items()})
        self.operator = BlindOperator(rule, LAYOUT.goals, plan_line, WEIGHT, 0, "mine:rule")
        self.order = PickOrder(scenario, DELIVERY, TrueCounts(CRATE, 1, 0.2), self.operator)

    def run(self, primitives, retreating):
        outcomes = []
        for primitive in (*primitives,):
            self.time += 1.0
            name = primitive.name
            if name == "weigh":
                primitive.tell(self.error - WEIGHT * self.load)
                if not outcomes or outcomes[-1].name == "return":
                    self.lift()
            if name in ("release", "drop_back"):
                where = [*CRATE.center, 0.03] if name == "release" else [0.95, 0.0, 0.027]
                held = np.flatnonzero(self.poses[:, 2] > 0.1)
                self.poses[held, :3] = where
                self.poses[held[: self.lost], :3] = [0.95, 0.0, 0.027]
                self.load = 0
            outcomes.append(Outcome(name, "ended", "done", self.time - 1.0, self.time, 0.0, 0.0))
        return outcomes

    def lift(self):
        self.load = self.script.pop(0)
        self.poses[np.flatnonzero(self.poses[:, 0] > 0.7)[: self.load], :3] = HIGH

    def fill(self):
        state = lambda: BinState(self.poses.copy(), HIGH, np.zeros(7), self.time)  # noqa: E731
        return self.order.fill(state, lambda plan: None, self.run)[1]


def test_an_order_is_filled_by_weight_alone_whatever_the_error_of_the_tool():
    world = Bin([1, 0, 2, 3, 1], error=1.7)
    assert world.fill() is None
    attempts = world.order.attempts
    assert [each.held for each in attempts] == [each.believed_held for each in attempts] == [1, 0, 2, 3, 1]
    assert [each.delivered for each in attempts] == [each.believed_delivered for each in attempts] == [1, 0, 2, 0, 1]
    assert attempts[3].reason == "3 held where 1 were missing: dropped back"
    assert attempts[1].reason == "nothing was in the hand after the lift"


def test_the_truth_judges_what_the_operator_counts():
    world = Bin([1, 1, 1, 1], lost=1)
    assert world.fill() == "the operator counted 4 or more, but 0 of 4 were delivered"
    assert [each.believed_delivered for each in world.order.attempts] == [1, 1, 1, 1]
    assert [each.delivered for each in world.order.attempts] == [0, 0, 0, 0]
    assert world.order.attempts[0].as_dict()["believed_held"] == 1


def test_no_pose_of_an_object_reaches_an_operator_without_eyes():
    for module in (blind_operator, line_rules):
        assert "poses" not in inspect.getsource(module).replace("No pose", "")
    assert not {"look", "plan_for"} & set(dir(BlindOperator))


def test_lines_cover_each_goal_from_its_middle_and_take_turns():
    names = [line.name for line in LINES]
    assert names[:3] == ["wall", "corner_left", "corner_right"]
    wall = sorted(line.anchor[1] for line in LINES if line.name == "wall")
    assert (wall[0], wall[-1]) == pytest.approx((-0.03, 0.12))
    assert np.diff(wall).max() <= SPACING + 1e-9
    assert LINES[0].anchor[1] == pytest.approx(0.045, abs=SPACING / 2 + 1e-9)
    assert touch_distance(LINES[0]) == 0.3
    told = []
    for number in range(2 * len(LINES)):
        assert alternates(LINES, told, None) == number % len(LINES)
        told.append(Told(0, 0, True, 17.0))


def test_the_bandit_prefers_what_delivered_and_leaves_what_met_nothing():
    told = [Told(2, 1, True, 18.0)] * 4 + [Told(0, 0, False, 1.0)] * 2
    drawn = [bandit(LINES, told, np.random.default_rng(seed)) for seed in range(200)]
    counts = np.bincount(drawn, minlength=len(LINES))
    assert counts.argmax() == 2
    assert counts[0] < counts[2] / 4


def test_a_line_out_of_reach_is_left_out():
    def plan(line, posture):
        if line.name == "wall":
            raise UnreachablePoseError("too far")
        return plan_line(line, posture)

    operator = BlindOperator(alternates, LAYOUT.goals, plan, WEIGHT, 0)
    assert operator.next_plan(None)[0].name == "corner_left"
    assert operator.next_plan(None)[0].name == "corner_left", "one line an attempt"
    nothing = BlindOperator(alternates, [LAYOUT.goals[0]], plan, WEIGHT, 0)
    with pytest.raises(UnreachablePoseError):
        nothing.next_plan(None)


@pytest.mark.parametrize("answer", [-1, 99, 1.5, None, True])
def test_a_rule_of_the_user_must_name_a_line(answer):
    operator = BlindOperator(lambda lines, told, random: answer, LAYOUT.goals, plan_line, WEIGHT, 0, "mine:rule")
    with pytest.raises(ConfigurationError, match=r"order\.operator = 'mine:rule' returned"):
        operator.next_plan(None)


def test_the_operator_counts_in_the_hash_unless_it_sees():
    hashes = [build_scenario({}, BIN | {"order.operator": name}).config_hash() for name in ("sees", "alternates")]
    assert hashes[0] != build_scenario({}, BIN).config_hash() == hashes[1], "the default does not see"
    with pytest.raises(ConfigurationError, match=r"order\.operator = 'looks' is not allowed"):
        build_scenario({}, BIN | {"order.operator": "looks"})


def test_weighing_averages_after_a_rest():
    read = []
    pose = Pose(np.zeros(3))
    inputs = lambda time, force: PrimitiveInput(time, pose, np.array([0.0, 0.0, force, 0.0, 0.0, 0.0]))  # noqa: E731
    active = Weigh(read.append).begin(inputs(0.0, 9.0), Setpoint(Reference(pose), 0.7))
    for time in np.arange(0.0, REST_TIME + WEIGHING_TIME + 0.01, 0.01):
        if active.ending(now := inputs(time, 9.0 if time < REST_TIME - 1e-9 else -2.0)):
            break
        assert active.setpoint(now).closure == 0.7
    assert read == [pytest.approx(-2.0)]


@pytest.mark.parametrize(("height", "ends"), [(0.002, "surface contact"), (0.05, "an object is under the hand")])
def test_a_touch_down_on_an_object_is_a_failure_for_who_does_not_see(height, ends):
    above = Pose(np.array([0.6, 0.0, 0.06]), tool_rotation(0.0, 0.9))
    approach = Approach(above, 0.06, 0.15, 0.05, 1.8, 0.3, highest_touch=0.015)
    start = PrimitiveInput(0.0, above.moved([0.0, 0.0, 0.1]), np.zeros(6))
    active = approach.begin(start, Setpoint(Reference(start.pose), 0.3))
    down = Pose(np.array([0.6, 0.0, height]), above.rotation)
    ending = active.ending(PrimitiveInput(2.0, down, np.array([0.0, 0.0, 3.0, 0.0, 0.0, 0.0])))
    assert ending.trigger.startswith(ends)
    assert ending.failed == (height > 0.015)


def test_a_goal_with_a_single_line_gives_one():
    assert len(fixed_lines([PushGoal("wall", np.array([1.0, 0.0]), math.radians(0.0), (0.0, 0.0), 0.3)])) == 1
