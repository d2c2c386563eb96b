"""The collision limit keeps the arm off obstacles and itself, and leaves the rest of its motion alone."""

import copy
import pickle
import threading

import numpy as np
import pytest

from arms import load, random_states
from collision_scenes import SCENES, capsules, obstacles, run_to, tally
from example_arm import HOME
from pilegrasp_ctrl.arm.capsule import Capsule
from pilegrasp_ctrl.control.inverse_dynamics import InverseDynamics
from pilegrasp_ctrl.exceptions import ConfigurationError, ModelError, PilegraspError
from pilegrasp_ctrl.limits.collision_geometry import Geometry, Pair
from pilegrasp_ctrl.limits.collision_limit import CollisionLimit
from pilegrasp_ctrl.limits.obstacles import Box, Plane
from pilegrasp_ctrl.limits.standard import limits_of
from pilegrasp_ctrl.plant.arm_simulation import ArmSimulation
from pilegrasp_ctrl.tasks.frame_task import FrameTask
from pilegrasp_ctrl.tasks.posture_task import PostureTask
from pilegrasp_ctrl.types import Observation, Pose

ARMS = ("panda", "wam7")
TARGETS = 6
"""Random targets of each arm and scene [-]; `python tests/helpers/collision_scenes.py 50` tries more."""

FLANGE = {"panda": "panda_hand", "wam7": "flange"}


def make_limit(name, scene="box", **arguments):
    return CollisionLimit(load(name), capsules(name), obstacles(name, scene)[0], **arguments)


def hand_only(name, *shapes, **arguments):
    """Return a limit of one capsule at the hand, with obstacles alone."""
    capsule = Capsule(FLANGE[name], [0.0, 0.0, -0.05], [0.0, 0.05, 0.05], 0.04)
    return CollisionLimit(load(name), [capsule], shapes, self_collision=False, **arguments)


def home_state(name, v=None):
    return load(name).update(HOME[name], np.zeros(7) if v is None else v)


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("name", ARMS)
def test_no_target_behind_a_box_or_in_a_bin_takes_the_arm_into_the_margin(name, scene):
    """At a free target a pair at its margin may hold the arm short, and one arm in 6 may not come to rest."""
    found = tally(name, scene, TARGETS, free_time=1.5, time=3.0)
    assert found.depth <= 1e-3
    assert (found.lost, found.fallbacks) == (0, 0)
    assert found.moving <= 1
    assert found.short <= 1
    assert found.entered >= (2 if scene == "box" else 1)
    assert scene == "box" or found.reached >= 1


def test_a_hand_that_is_sent_through_a_box_stops_at_the_margin_and_names_the_pair():
    start = home_state("panda")
    target = start.pose.moved([0.3, 0.0, 0.0])
    limit = hand_only("panda", Box([0.2, 0.4, 0.4], start.pose.moved([0.3, 0.0, 0.0])))
    assert run_to(target, limit, "panda", 1.0, limited=False).depth > 0.05
    run = run_to(target, limit, "panda", 2.0, limited=True)
    assert run.depth < 1e-4
    assert run.speed < 1e-3
    assert "collision[panda_hand | box] lower" in run.active


@pytest.mark.parametrize("name", ARMS)
def test_the_arm_is_kept_off_itself(name):
    arm = load(name)
    limit = CollisionLimit(arm, capsules(name))
    folded = {"panda": [0.0, -1.0, 0.0, -3.0, 0.0, 0.3, 0.8], "wam7": [0.0, 1.5, 0.0, 3.0, 0.0, 1.5, 0.0]}[name]

    def least_distance(limits):
        task = PostureTask(arm, folded, weight=1.0)
        controller, least = InverseDynamics(arm, [task], limits), np.inf
        active = set()

        def torque(observation):
            output = controller.step(observation)
            active.update(output.active_limits)
            return output.command.torque

        for sample in ArmSimulation(arm, substeps=1).run(torque, HOME[name], 2.0):
            least = min(least, *limit.distances(arm.update(sample.q, sample.v)).values())
        return least, active

    assert least_distance(limits_of(arm))[0] < 0.0
    least, active = least_distance([*limits_of(arm), limit])
    assert least > limit.margin - 1e-3
    assert any(active.startswith("collision[") for active in active)


def test_shapes_that_overlap_at_the_start_separate_slowly():
    start = home_state("panda")
    limit = hand_only("panda", Box([0.2, 0.4, 0.4], start.pose.moved([0.08, 0.0, 0.0])))
    assert min(limit.distances(start).values()) < -0.03
    arm, fastest = load("panda"), 0.0
    task = FrameTask(arm)
    task.set_target(start.pose)
    controller = InverseDynamics(arm, [task, PostureTask(arm, HOME["panda"])], [*limits_of(arm), limit])
    for sample in ArmSimulation(arm).run(lambda o: controller.step(o).command.torque, HOME["panda"], 2.0):
        state = arm.update(sample.q, sample.v)
        fastest = max(fastest, float(np.linalg.norm(state.twist[:3])))
    assert fastest < 2.0 * limit.retreat
    assert min(limit.distances(state).values()) == pytest.approx(limit.margin, abs=1e-4)


@pytest.mark.parametrize("name", ARMS)
def test_a_row_is_the_rate_of_a_distance(name):
    """At rest every row of a pair's closest point must be the gradient of the distance."""
    arm, compared = load(name), 0
    limit = hand_only(name, Box([0.3, 0.3, 0.3], Pose([0.5, 0.1, 0.4])), Plane(offset=0.3), margin=0.2)
    for q, _ in random_states(arm, 30, seed=2):
        state = arm.update(q, np.zeros(7))
        bounds, distances = limit.rows(state), limit.distances(state)
        for pair, distance in distances.items():
            rows = bounds.G[[name == pair for name in bounds.names]]
            if not len(rows) or distance < 0.02:
                continue
            gradient = [
                (limit.distances(arm.update(q + step, np.zeros(7)))[pair] - distance) / 1e-6
                for step in 1e-6 * np.eye(7)
            ]
            assert np.abs(rows - gradient).max(axis=1).min() < 1e-4
            compared += 1
    assert compared >= 10


def test_a_bound_lets_the_approach_stop_within_the_deceleration():
    """The border of the allowed speeds is the parabola of the deceleration, joined to a line near the margin."""
    arm, checked = load("panda"), 0
    ball = Capsule("panda_hand", [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], 0.05)
    limit = CollisionLimit(arm, [ball], [Plane(offset=0.4)], self_collision=False, deceleration=3.0)
    for q, v in random_states(arm, 1000, seed=3, speed=0.3):
        state, T = arm.update(q, v), 2.0 / limit.rate
        for G, lower in zip(*limit.rows(state)[:2], strict=True):
            a = G * lower / (G @ G)
            ends = [arm.update(q + T * v + 0.5 * T * T * a + step * (v + T * a), v) for step in (0.0, 1e-6)]
            d, later = (min(limit.distances(end).values()) - limit.margin for end in ends)
            knee = 3.0 / limit.gain**2
            if d > 0.0 and lower < 0.0:
                allowed = np.sqrt(6.0 * d - 3.0 * knee) if d > knee else limit.gain * d
                assert (later - d) / 1e-6 == pytest.approx(-allowed, rel=0.02, abs=2e-3)
                checked += 1
    assert checked > 20


def test_an_obstacle_that_is_far_has_no_row_and_changes_nothing():
    arm = load("panda")
    state = home_state("panda", 0.1 * np.ones(7))
    limit = hand_only("panda", Plane(offset=-1.0))
    assert limit.rows(state).names == ()
    outputs = []
    for limits in (limits_of(arm), [*limits_of(arm), limit]):
        task = FrameTask(arm)
        task.set_target(state.pose.moved([0.1, 0.0, 0.0]))
        outputs.append(InverseDynamics(arm, [task], limits).step(Observation(0.0, state.q, state.v)).command.torque)
    np.testing.assert_array_equal(*outputs)


def test_the_base_on_a_floor_has_no_row():
    limit = CollisionLimit(load("panda"), capsules("panda"), [Plane(offset=0.2)], self_collision=False)
    assert not [name for name in limit.pairs if "panda_link0" in name]
    still = limit.rows(home_state("panda"))
    assert not [name for name in still.names if "panda_link1 " in name]


@pytest.mark.parametrize("name", ARMS)
def test_links_that_a_joint_joins_are_no_pair_and_far_ones_are(name):
    pairs = CollisionLimit(load(name), capsules(name)).pairs
    joined, apart = {
        "panda": ("collision[panda_link5 | panda_link6]", "collision[panda_link0 | panda_hand]"),
        "wam7": ("collision[link3 | link4]", "collision[base_link | link7]"),
    }[name]
    assert joined not in pairs
    assert apart in pairs


def test_the_rows_depend_on_the_state_alone():
    limit, fresh = make_limit("wam7"), make_limit("wam7")
    arm = load("wam7")
    for q, v in random_states(arm, 50):
        limit.rows(arm.update(q, v))
    for q, v in random_states(arm, 5, seed=9):
        for one, other in zip(limit.rows(arm.update(q, v)), fresh.rows(arm.update(q, v)), strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, lambda limit: pickle.loads(pickle.dumps(limit))])
def test_copies_and_pickles_give_the_same_rows(duplicate):
    limit = make_limit("panda")
    state = home_state("panda", 0.3 * np.ones(7))
    before = limit.rows(state)
    for one, other in zip(before, duplicate(limit).rows(state), strict=True):
        np.testing.assert_array_equal(one, other)


def test_threads_may_share_the_limit():
    limit, arm = make_limit("panda"), load("panda")
    states = [arm.update(q, v) for q, v in random_states(arm, 200)]
    expected = [limit.rows(state) for state in states]
    wrong = []

    def work():
        for state, rows in zip(states, expected, strict=True):
            found = limit.rows(state)
            if found.names != rows.names or not np.array_equal(found.lower, rows.lower):
                wrong.append(state)

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_an_active_pair_is_named_once_and_its_rows_count_together():
    start = home_state("panda")
    limit = hand_only("panda", Box([0.2, 0.4, 0.4], start.pose.moved([0.2, 0.0, 0.0])))
    arm = load("panda")
    task = FrameTask(arm)
    task.set_target(start.pose.moved([0.2, 0.0, 0.0]))
    controller = InverseDynamics(arm, [task, PostureTask(arm, HOME["panda"])], [*limits_of(arm), limit])
    *_, sample = ArmSimulation(arm).run(lambda o: controller.step(o).command.torque, HOME["panda"], 1.0)
    observation = Observation(1.0, sample.q, sample.v)
    assert controller.step(observation).active_limits.count("collision[panda_hand | box] lower") == 1
    assert controller.multipliers(observation)["collision[panda_hand | box] lower"] > 0.0


BOX = Box([0.1, 0.1, 0.1], Pose([1.0, 0.0, 0.0]))
BALL = Capsule("panda_hand", [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], 0.05)


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda arm: CollisionLimit(arm, [Capsule("hand", BALL.start, BALL.end, 0.1)], [BOX]), ModelError, "'hand'"),
        (lambda arm: Capsule("panda_hand", BALL.start, BALL.end, 0.0), PilegraspError, "radius = 0"),
        (lambda arm: Capsule("panda_hand", [0.0, 0.0], BALL.end, 0.1), PilegraspError, "start of panda_hand"),
        (lambda arm: Capsule("", BALL.start, BALL.end, 0.1), PilegraspError, "name of a link"),
        (lambda arm: Box([0.1, 0.0, 0.1], Pose(np.zeros(3))), PilegraspError, "positive"),
        (lambda arm: Box([0.1, 0.1, 0.1], np.zeros(3)), PilegraspError, "Pose"),
        (lambda arm: Plane([0.0, 0.0, 0.0]), PilegraspError, "normal of plane is zero"),
        (lambda arm: CollisionLimit(arm, [BALL], [Pose(np.zeros(3))]), ConfigurationError, "Plane or Box"),
        (lambda arm: CollisionLimit(arm, [BALL], BOX), ConfigurationError, "list of Plane or Box"),
        (lambda arm: CollisionLimit(arm, BALL, [BOX]), ConfigurationError, "list of Capsule"),
        (lambda arm: CollisionLimit(arm, [BOX], [BOX]), ConfigurationError, "Capsule"),
        (lambda arm: CollisionLimit(arm, [BALL]), ConfigurationError, "nothing to watch"),
        (lambda arm: CollisionLimit(arm, [BALL], [BOX], margin=-0.1), ConfigurationError, "margin = -0.1"),
        (lambda arm: CollisionLimit(arm, [BALL], [BOX], rate=0.0), ConfigurationError, "rate = 0.0"),
        (lambda arm: CollisionLimit(arm, [BALL], [BOX], deceleration="2"), ConfigurationError, "deceleration = '2'"),
        (lambda arm: CollisionLimit(arm, [BALL], [BOX], rate=25.0), ConfigurationError, "gain = 20"),
        (lambda arm: CollisionLimit(arm, [BALL], self_collision=[("panda_hand", "x")]), ConfigurationError, "'x'"),
        (lambda arm: CollisionLimit(arm, [BALL], self_collision=["panda_hand"]), ConfigurationError, "pairs"),
    ],
)
def test_what_cannot_be_used_is_refused_in_a_sentence(make, error, words):
    with pytest.raises(error, match=words) as refusal:
        make(load("panda"))
    assert "\n" not in str(refusal.value)


def test_a_limit_of_another_rate_is_refused():
    with pytest.raises(ConfigurationError, match="250 Hz"):
        InverseDynamics(load("panda"), [FrameTask(load("panda"))], [make_limit("panda", rate=250.0)])


@pytest.mark.parametrize("name", ARMS)
def test_pairs_are_sorted_out_by_a_distance_and_a_speed_that_they_do_not_exceed(name):
    arm, T = load(name), 1e-4
    shapes = [*obstacles(name, "box")[0], Plane([0.3, -0.2, 1.0], 0.1, "slope")]
    limit = CollisionLimit(arm, capsules(name), shapes)
    pairs = [Pair(i, k, "") for i in range(len(capsules(name))) for k in range(i + 1, len(capsules(name)) + 3)]
    geometry = Geometry(arm.pinocchio_model, limit.capsules, limit.obstacles, pairs)
    for q, v in random_states(arm, 100, seed=4):
        geometry.place(q + T * v)
        later = geometry.distances()
        geometry.place(q)
        distances, (speeds, least) = geometry.distances(), geometry.closing(v)
        assert (least <= np.maximum(distances, 0.0) + 1e-12).all()
        assert ((distances - later) / T <= speeds + 5e-3).all()
