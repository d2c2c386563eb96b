"""Tracking of references into, through and out of singular postures, and of targets out of reach."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import least_squares

from arms import ARMS, HOME, load, random_states, simulate, without_friction
from khatib import least_squares_torque
from pilegrasp_ctrl.control.operational_space import DEFAULT_GAINS, OperationalSpaceController
from pilegrasp_ctrl.tasks.frame_task import FrameTask
from pilegrasp_ctrl.tasks.pose_task import pose_error
from pilegrasp_ctrl.tasks.posture_task import POSTURE_WEIGHT, PostureTask
from pilegrasp_ctrl.tasks.singular_directions import SingularDirections
from pilegrasp_ctrl.trajectories.straight_line import StraightLine
from pilegrasp_ctrl.types import Observation, Pose, Reference

SHOULDER = {"wam7": np.array([0.0, 0.0, 0.346]), "panda": np.array([0.0, 0.0, 0.333])}
REACH = {"wam7": 0.852, "panda": 0.718}
"""Distance from the shoulder to the tool with a straight elbow and the hand as at home [m]."""
# Changes of the home posture that lose a direction. Wrist: joints 5 and 7 of the WAM in line; the Panda's hand folded
# back. Shoulder: joints 1 and 3 in line, the elbow's plane across.
POSTURES = {
    "wrist": {"wam7": {4: -np.pi / 2, 5: 0.0}, "panda": {1: 0.0270930, 2: 1.8239695, 4: -np.pi / 2, 5: 3.3642635}},
    "shoulder": {"wam7": {1: 0.0, 2: np.pi / 2}, "panda": {1: 0.0, 2: np.pi / 2}},
}
CROSSED = {"wrist": 5, "shoulder": 1}


def changed(name, joints):
    q = HOME[name].copy()
    for joint, value in joints.items():
        q[joint] = value
    return q


STRETCHED = {"wam7": changed("wam7", {3: 0.3}), "panda": changed("panda", {3: -0.6})}


def smallest_singular(arm, q):
    """Return the smallest singular value of J and its direction at the tool."""
    U, sigma, _ = np.linalg.svd(arm.update(q, 0.0 * q).J)
    return sigma[-1], U[:, -1]


class Run(list):
    """A simulated run: time, error, output, velocity and tool position of each control period."""

    def __init__(self, arm, reference, q, duration, *, posture=None, friction=False, rate=500.0, **plant):
        controller = OperationalSpaceController(arm, posture=posture, friction=friction, rate=rate)

        def step(observation):
            state = arm.update(observation.q, observation.v)
            at = reference(observation.time)
            output = controller.step(observation, at, state=state)
            self.append((observation.time, pose_error(state, at), output, state.v, state.translation))
            return output.command.torque

        for _ in simulate(arm, step, q, duration, rate=rate, **plant):
            pass
        self.arm = arm
        self.time, self.error = np.array([row[0] for row in self]), np.array([row[1] for row in self])
        self.torque = np.array([row[2].command.torque for row in self])
        self.v, self.tool = np.array([row[3] for row in self]), np.array([row[4] for row in self])
        self.acceleration = rate * np.diff(self.v, axis=0)

    def flips(self):
        """Return how often a joint's acceleration changes sign between periods, beyond 2 rad/s² on both sides."""
        a = self.acceleration
        return int(((a[1:] * a[:-1] < 0.0) & (np.minimum(np.abs(a[1:]), np.abs(a[:-1])) > 2.0)).sum())

    def is_orderly(self):
        assert np.isfinite(self.torque).all()
        assert all(row[2].fallback == "" for row in self)
        assert (np.abs(self.torque) <= self.arm.torque_limit + 1e-9).all()
        assert (np.abs(self.v) <= self.arm.velocity_limit).all()

    def between(self, start, end):
        return (self.time >= start) & (self.time < end)


def in_turn(*parts):
    """Return a reference of parts in sequence, and its duration; a part is (duration, function of time)."""

    def at(time):
        for duration, part in parts[:-1]:
            if time < duration:
                return part(time)
            time -= duration
        return parts[-1][1](min(time, parts[-1][0]))

    return at, sum(duration for duration, _ in parts)


def blend(start, end, duration):
    """Return a quintic motion from rest to rest along the shortest path."""
    way, turn = end.translation - start.translation, pin.log3(end.rotation @ start.rotation.T)

    def at(time):
        x = min(time / duration, 1.0)
        s, ds = 10 * x**3 - 15 * x**4 + 6 * x**5, (30 * x**2 - 60 * x**3 + 30 * x**4) / duration
        twist = np.concatenate((way, turn))
        pose = Pose(start.translation + s * way, pin.exp3(s * turn) @ start.rotation)
        return Reference(pose, ds * twist, (60 * x - 180 * x**2 + 120 * x**3) / duration**2 * twist)

    return duration, at


def rest(pose, duration):
    return duration, lambda time: Reference(pose)


def outward(arm, pose):
    """Return direction and distance from the shoulder to the tool."""
    way = pose.translation - SHOULDER[arm.name]
    return way / np.linalg.norm(way), np.linalg.norm(way)


def beyond_reach(arm, excess):
    """Return a reference from the shoulder outwards to `excess` beyond reach, a second of rest, and back."""
    start = arm.update(HOME[arm.name], np.zeros(7)).pose
    direction, distance = outward(arm, start)
    out = StraightLine(start, (REACH[arm.name] + excess - distance) * direction, 0.25)
    back = StraightLine(out.end, -(excess + 0.25) * direction, 0.25)
    parts = (out.duration, out.at), rest(out.end, 1.0), (back.duration, back.at), rest(back.end, 1.0)
    return *in_turn(*parts), out.duration


def nearest_reachable(arm, target, q):
    """Return the pose of least energy in springs whose force allows approaches of at most 1 m/s and 3 rad/s."""
    stiffness, damping = DEFAULT_GAINS.stiffness, DEFAULT_GAINS.damping

    def residual(q):
        error = pose_error(arm.update(q, 0.0 * q), Reference(target))
        parts = []
        for part, speed in ((slice(0, 3), 1.0), (slice(3, 6), 3.0)):
            e, longest = error[part], speed * damping[part][0] / stiffness[part][0]
            size = np.linalg.norm(e)
            if size > longest:
                e = e / size * np.sqrt(2.0 * longest * size - longest**2)
            parts.append(np.sqrt(stiffness[part]) * e)
        return np.concatenate(parts)

    found = least_squares(residual, q, bounds=(arm.q_lower, arm.q_upper), xtol=1e-15, ftol=1e-15, gtol=1e-12)
    return arm.update(found.x, 0.0 * found.x).pose


@pytest.mark.slow
@pytest.mark.parametrize("preferred", [False, True], ids=["no-posture", "posture"])
@pytest.mark.parametrize("name", ARMS)
def test_a_target_out_of_reach_is_approached_and_left_without_chatter(name, preferred):
    arm, home = without_friction(name), HOME[name]
    at, duration, arrival = beyond_reach(arm, 0.15)
    run = Run(arm, at, home, duration, posture=home if preferred else None)
    run.is_orderly()
    assert np.abs(run.acceleration).max() < 100.0
    assert run.flips() <= 3
    assert np.abs(np.diff(run.torque, axis=0) / arm.torque_limit).max() < 0.08
    stretched = np.flatnonzero(run.time < arrival + 1.0)[-1]
    best = nearest_reachable(arm, at(arrival).pose, STRETCHED[name])
    assert np.linalg.norm(best.translation - at(arrival).pose.translation) > 0.1
    # The posture bends the elbow slightly, which moves the tool only to second order.
    assert np.linalg.norm(run.tool[stretched] - best.translation) < (2e-3 if preferred else 2e-5)
    assert np.abs(run.v[stretched]).max() < 0.02
    assert np.linalg.norm(run.error[-1, :3]) < 1e-4
    assert np.linalg.norm(run.error[-1, 3:]) < 1e-4


@pytest.mark.parametrize("name", ARMS)
def test_without_the_reduced_acceleration_the_stretched_arm_chatters(name, monkeypatch):
    monkeypatch.setattr(SingularDirections, "reduce", lambda self, state, wanted: wanted)
    arm = without_friction(name)
    at, _, arrival = beyond_reach(arm, 0.15)
    run = Run(arm, at, HOME[name], arrival + 1.0)
    assert run.flips() > 200
    assert np.abs(run.acceleration).max() > 300.0


@pytest.mark.parametrize("rate", [250.0, 1000.0])
def test_the_stretched_arm_is_quiet_at_other_rates(rate):
    arm = without_friction("wam7")
    at, _, arrival = beyond_reach(arm, 0.15)
    run = Run(arm, at, HOME["wam7"], arrival + 1.0, rate=rate)
    run.is_orderly()
    assert np.abs(run.acceleration).max() < 100.0
    assert run.flips() <= 3


@pytest.mark.slow
@pytest.mark.parametrize("where", POSTURES)
@pytest.mark.parametrize("name", ARMS)
def test_a_path_through_a_singular_posture_is_followed(name, where):
    arm, middle = without_friction(name), changed(name, POSTURES[where][name])
    assert smallest_singular(arm, middle)[0] < 1e-3
    q, other = middle.copy(), middle.copy()
    q[CROSSED[where]] -= 0.3
    other[CROSSED[where]] += 0.3
    A, B = arm.update(q, 0.0 * q).pose, arm.update(other, 0.0 * q).pose
    at, duration = in_turn(blend(A, B, 2.0), rest(B, 0.3), blend(B, A, 2.0), rest(A, 0.5))
    run = Run(arm, at, q, duration)
    run.is_orderly()
    assert np.abs(run.acceleration).max() < 50.0
    assert run.flips() == 0
    assert np.linalg.norm(run.error[:, :3], axis=1).max() < 8e-3
    assert np.linalg.norm(run.error[:, 3:], axis=1).max() < 1e-3
    assert np.linalg.norm(run.error[-1]) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("where", POSTURES)
@pytest.mark.parametrize("name", ARMS)
def test_the_tool_can_leave_a_singular_posture_along_its_lost_direction(name, where):
    """A preferred posture decides to which side the arm bends; without one it first has to fall to a side."""
    arm, q = without_friction(name), changed(name, POSTURES[where][name])
    _, u = smallest_singular(arm, q)
    start = arm.update(q, 0.0 * q).pose
    way = 0.1 * u / max(np.linalg.norm(u[:3]), 0.3 * np.linalg.norm(u[3:]))
    end = Pose(start.translation + way[:3], pin.exp3(way[3:]) @ start.rotation)
    at, duration = in_turn(blend(start, end, 1.0), rest(end, 0.8), blend(end, start, 1.0), rest(start, 1.0))
    for posture, largest in ((None, 0.15), (HOME[name], 2e-3)):
        run = Run(arm, at, q, duration, posture=posture)
        run.is_orderly()
        assert np.abs(run.acceleration).max() < 120.0
        assert run.flips() <= 15
        assert np.linalg.norm(run.error[:, :3], axis=1).max() < largest
        assert np.linalg.norm(run.error[-1, :3]) < 5e-4


@pytest.mark.parametrize("name", ARMS)
def test_a_step_of_one_metre_out_of_reach_and_back_ends_at_its_start(name):
    arm, home = without_friction(name), HOME[name]
    start = arm.update(home, 0.0 * home).pose
    far = start.moved(outward(arm, start)[0])
    at, duration = in_turn(rest(far, 1.5), rest(start, 1.5))
    run = Run(arm, at, home, duration, posture=home)
    run.is_orderly()
    assert run.flips() <= 30
    assert np.abs(run.v[np.flatnonzero(run.time < 1.5)[-1]]).max() < 0.02
    assert np.linalg.norm(run.error[-1]) < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("true", [0.7, 1.0, 1.3])
def test_with_joint_friction_the_stretched_arm_stays_within_its_limits(true):
    """The feed-forward divides by the same small singular values, but its velocities are bounded."""
    rubbing = load("wam7")
    arm = without_friction("wam7", friction_coulomb=rubbing.friction_coulomb, friction_viscous=rubbing.friction_viscous)
    at, duration, _ = beyond_reach(arm, 0.15)
    plant = {
        "coulomb": true * rubbing.friction_coulomb,
        "external": lambda q, v: -true * rubbing.friction_viscous * v,
    }
    run = Run(arm, at, HOME["wam7"], duration, posture=HOME["wam7"], friction=True, **plant)
    assert all(row[2].fallback == "" for row in run)
    # Friction that is modelled too large accelerates the light wrist beyond the margin of the velocity limit.
    assert (np.abs(run.v) < 1.1 * arm.velocity_limit).all()
    assert (np.abs(run.torque) < 0.6 * arm.torque_limit).all()
    assert run.flips() <= 80
    assert np.linalg.norm(run.error[-1, :3]) < (1e-3 if true <= 1.0 else 8e-3)


def test_the_friction_feed_forward_is_bounded_at_a_straight_elbow():
    arm = load("wam7")
    controllers = [OperationalSpaceController(arm, friction=on) for on in (True, False)]
    for elbow in np.linspace(0.2, 0.3, 11):
        q = changed("wam7", {3: elbow})
        state = arm.update(q, 0.0 * q)
        reference = Reference(state.pose.moved(0.3 * outward(arm, state.pose)[0]))
        on, off = (controller.step(Observation(0.0, q, 0.0 * q), reference) for controller in controllers)
        most = arm.friction_coulomb + arm.friction_viscous * arm.velocity_limit
        assert (np.abs(on.command.torque - off.command.torque) <= most + 1e-6).all()


def reduced_by_formula(state, wanted, directions):
    """Return the law in the docstring of `SingularDirections`, by a singular value decomposition."""
    U, sigma, _ = np.linalg.svd(state.J)
    y, speed = U.T @ (wanted - state.Jdot_v), U.T @ state.twist
    depth = np.where(sigma < directions.threshold, (1.0 - (sigma / directions.threshold) ** 2) ** 2, 0.0)
    squared = depth * np.maximum(np.abs(y) - directions.free, 0.0) / directions.rate**2
    share = squared / (sigma**2 + directions.posture_weight + squared)
    return state.Jdot_v + U @ ((1.0 - share) * y - share * directions.damping * speed)


@pytest.mark.parametrize("weight", [POSTURE_WEIGHT, 1e-2])
@pytest.mark.parametrize("name", ARMS)
def test_the_reduced_acceleration_follows_its_formula_and_regular_postures_are_unchanged(name, weight):
    arm, directions = load(name), SingularDirections(posture_weight=weight)
    rng = np.random.default_rng(0)
    kept = 0
    for q, v in random_states(arm, 200):
        state, wanted = arm.update(q, v), rng.normal(scale=20.0, size=6)
        answer = directions.reduce(state, wanted.copy())
        np.testing.assert_allclose(answer, reduced_by_formula(state, wanted, directions), atol=1e-9)
        if smallest_singular(arm, q)[0] > directions.threshold:
            np.testing.assert_array_equal(answer, wanted)
            kept += 1
    assert 50 < kept < 150


@pytest.mark.parametrize("weight", [POSTURE_WEIGHT, 1e-2])
def test_near_a_singular_posture_the_controller_uses_the_weight_of_its_posture_task(weight):
    arm, q = without_friction("wam7"), STRETCHED["wam7"]
    state = arm.update(q, 0.0 * q)
    reference = Reference(state.pose.moved(0.3 * outward(arm, state.pose)[0]))
    posture = PostureTask(arm, HOME["wam7"], weight=weight)
    controller = OperationalSpaceController(arm, posture=posture, limits=())
    task, default = FrameTask(arm, posture_weight=weight), FrameTask(arm)
    task.set_target(reference)
    default.set_target(reference)
    wanted, with_default = task.acceleration(state), default.acceleration(state)
    assert (np.abs(wanted - with_default).max() > 1.0) == (weight != POSTURE_WEIGHT)
    expected = least_squares_torque(state, wanted, 100.0 * (HOME["wam7"] - q), np.ones(6), weight)
    output = controller.step(Observation(0.0, q, 0.0 * q), reference)
    np.testing.assert_allclose(output.command.torque, expected, atol=1e-6)


@pytest.mark.parametrize("name", ARMS)
def test_in_an_endangered_direction_the_joints_accelerate_in_proportion_to_the_distance(name):
    arm, directions = load(name), SingularDirections()
    seen = 0
    for q, _ in random_states(arm, 200, seed=4):
        state = arm.update(q, 0.0 * q)
        sigma, u = smallest_singular(arm, q)
        if sigma < 0.3 * directions.threshold:
            for size in (10.0, 1e3, 1e5):
                y = u @ directions.reduce(state, size * u)
                assert y < 1.3 * directions.rate**2 * (sigma**2 + 1e-4) + directions.free
                seen += 1
            small = 0.99 * directions.free * u
            np.testing.assert_array_equal(directions.reduce(state, small.copy()), small)
    assert seen > 30


def test_a_free_axis_does_not_count_as_a_lost_direction():
    arm, q = load("wam7"), HOME["wam7"]
    state, wanted = arm.update(q, 0.0 * q), np.array([30.0, -20.0, 10.0, 40.0, 50.0, -60.0])
    np.testing.assert_array_equal(SingularDirections([1, 1, 1, 1, 1, 0]).reduce(state, wanted.copy()), wanted)
    stretched = changed("wam7", {3: 0.231})
    state = arm.update(stretched, 0.0 * q)
    answer = SingularDirections([1, 1, 1, 0, 0, 0]).reduce(state, wanted.copy())
    assert np.abs(answer[:3] - wanted[:3]).max() > 1.0
    np.testing.assert_array_equal(answer[3:], wanted[3:])
