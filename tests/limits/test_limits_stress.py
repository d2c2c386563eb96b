"""Each simulated arm stays within its limits for hundreds of random starts and targets."""

import os

import numpy as np
import pytest

from arms import load, without_friction
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.limits.motion_limits import PositionLimit
from pilegrasp_ctrl.limits.torque_limit import TorqueLimit
from pilegrasp_ctrl.plant.arm_simulation import ArmSimulation
from pilegrasp_ctrl.types import MassProperties, Reference

RATE = 500.0
FACTOR = int(os.environ.get("STRESS", "1"))
"""How many times as many starts as usual."""
STARTS = 150 * FACTOR
DURATION = 0.24
BORDER_STARTS = 30 * FACTOR
BORDER_DURATION = 0.6
HAND = MassProperties(0.6, np.array([0.0, 0.0, 0.08]), 0.0012 * np.eye(3))
LOAD = MassProperties(2.25, np.zeros(3), 0.002 * np.eye(3))
"""Load beside the Panda's own hand, up to the arm's rating."""
ARMS = {
    "wam7": lambda: without_friction("wam7"),
    "panda": lambda: without_friction("panda"),
    "wam7 with friction and hand": lambda: load("wam7", tool=HAND),
    "panda with load": lambda: without_friction("panda", tool=LOAD),
}


def start(arm, rng, kind):
    """Return a start at rest, in motion that can be stopped, or with some joints out of range and others too fast.

    "moving" starts can be stopped in any posture; "border" starts are within 95 % of the speeds that the position limit
    allows in this one.
    """
    span = arm.q_upper - arm.q_lower
    q = arm.q_lower + span * rng.uniform(0.02, 0.98, arm.nv)
    v = np.zeros(arm.nv)
    if kind == "moving":
        gain = PositionLimit(arm, RATE).gain
        up = np.minimum(gain * (arm.q_upper - q), arm.velocity_limit)
        down = np.minimum(gain * (q - arm.q_lower), arm.velocity_limit)
        v = rng.uniform(-0.9 * down, 0.9 * up)
    if kind == "border":
        # At rest, the bounds over the horizon are the speeds from which the joints can stop.
        limit = PositionLimit(arm, RATE)
        bounds = limit.rows(arm.update(q, v))
        speeds = limit.horizon * np.stack((bounds.lower, bounds.upper))
        v = rng.uniform(*(0.95 * np.clip(speeds, -arm.velocity_limit, arm.velocity_limit)))
    if kind == "outside":
        beyond, high = rng.random((2, arm.nv)) < [[0.3], [0.5]]
        excess = rng.uniform(0.0, 0.15, arm.nv)
        q = np.where(beyond, np.where(high, arm.q_upper + excess, arm.q_lower - excess), q)
        fast = (rng.random(arm.nv) < 0.2) & ~beyond
        v = np.where(fast, arm.velocity_limit * rng.uniform(1.0, 1.3, arm.nv) * rng.choice([-1, 1], arm.nv), 0.0)
        q = np.where(fast, arm.q_lower + 0.5 * span, q)
    return q, v


def excess(arm, q, v):
    """Excess (periods, 2 nv) of each joint over its range [rad] and over its speed [rad/s]; negative within."""
    beyond = np.maximum(q - arm.q_upper, arm.q_lower - q)
    return np.hstack((beyond, np.abs(v) - arm.velocity_limit))


def run_starts(arm, rng, kinds, count, duration):
    """Simulate starts of the kinds in turn, assert that no limit is exceeded, and return the limits that were hit."""
    plant, torque_limit = ArmSimulation(arm), TorqueLimit(arm)
    span, hit = arm.q_upper - arm.q_lower, set()
    for index in range(count):
        kind = kinds[index % len(kinds)]
        q, v = start(arm, rng, kind)
        goal = arm.q_lower + span * rng.uniform(-0.1, 1.1, arm.nv)
        controller = OperationalSpaceController(arm, posture=goal, rate=RATE)
        reference = Reference(arm.update(goal, np.zeros(arm.nv)).pose)

        def torque(observation, controller=controller, reference=reference):
            output = controller.step(observation, reference)
            assert output.fallback == ""
            hit.update(active.partition("[")[0] for active in output.active_limits)
            return output.command.torque

        samples = list(plant.run(torque, q, duration, v=v, rate=RATE))
        beyond = excess(arm, np.array([sample.q for sample in samples]), np.array([sample.v for sample in samples]))
        # An excess may be what it was at the start, or the least that it has been since, but never more.
        allowed = np.minimum.accumulate(np.maximum(beyond, 0.0))
        allowed = np.vstack((allowed[:1], allowed[:-1]))
        # While joints out of range return, coupling disturbs the others slightly: by 0.06 degrees and 5 mrad/s.
        slack = np.repeat([0.0, 0.0] if kind != "outside" else [1e-3, 5e-3], arm.nv)
        assert (beyond <= allowed + slack).all(), f"{kind} start {index}"
        torques = np.array([sample.torque for sample in samples])
        # The limit cuts by a product in each period; one product for all periods would round in another way.
        rows = torques if torque_limit.matrix is None else np.array([torque_limit.matrix @ row for row in torques])
        assert (np.abs(rows) <= torque_limit.limit).all()
        assert (np.abs(torques) <= arm.torque_limit).all()
    return hit


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_no_limit_is_exceeded_and_an_initial_excess_only_shrinks(name):
    rng = np.random.default_rng(7)
    arm = ARMS[name]()
    hit = run_starts(arm, rng, ("still", "moving", "outside"), STARTS, DURATION)
    assert hit >= {"torque", "velocity", "position"}
    assert ("motor" in hit) == (arm.joint_to_motor is not None)


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_a_joint_stops_from_every_speed_that_the_position_limit_allows(name):
    rng = np.random.default_rng(8)
    hit = run_starts(ARMS[name](), rng, ("border",), BORDER_STARTS, BORDER_DURATION)
    assert hit >= {"torque", "velocity", "position"}


def test_every_joint_outside_its_range_is_back_within_a_second():
    arm = without_friction("wam7")
    q = np.where(np.arange(arm.nv) % 2 == 0, arm.q_upper + 0.1, arm.q_lower - 0.1)
    controller = OperationalSpaceController(arm, rate=RATE)
    reference = Reference(arm.update(q, np.zeros(arm.nv)).pose)
    *_, last = ArmSimulation(arm).run(lambda o: controller.step(o, reference).command.torque, q, 1.0, rate=RATE)
    assert (last.q <= arm.q_upper).all()
    assert (last.q >= arm.q_lower).all()
