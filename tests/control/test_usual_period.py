"""The compiled usual period gives the bits of the small kernels, called one by one by tasks and limits."""

import numpy as np
import pytest

import pilegrasp_ctrl as pg
from arms import ARMS, HAND, HOME, nearby, quiet_states, random_states, with_friction, without_friction
from pilegrasp_ctrl.types import ControllerOutput


def calm(state):
    """A reference so near that no limit is active."""
    return pg.Reference(state.pose.moved([1e-4, 0.0, -1e-4]), 0.9 * state.twist, np.linspace(0.1, -0.1, 6))


def pairs(arm):
    """Controllers that call the compiled period, by the kind of their parts."""
    q = HOME[arm.name]
    yield "posture", lambda: pg.OperationalSpaceController(arm, posture=q)
    weights = {"mask": [1, 1, 1, 1, 0, 1], "weight": [1, 2, 3, 1, 1, 2]}
    yield "mask", lambda: pg.OperationalSpaceController(arm, **weights)
    axis = pg.AxisTask(arm, [0.0, 0.0, 1.0], [0.0, 0.1, -1.0], weight=1e-3)
    yield "more tasks", lambda: pg.OperationalSpaceController(arm, posture=q, tasks=[axis])


@pytest.mark.parametrize("make_arm", [with_friction, without_friction])
@pytest.mark.parametrize("name", ARMS)
def test_the_usual_period_and_its_parts_give_the_same_torques_to_the_bit(name, make_arm):
    arm = make_arm(name, HAND)
    counts = {"free": 0, "active": 0}
    for _, make in pairs(arm):
        usual, parts = make(), make()
        parts._usual = None
        for index, (q, v) in enumerate(
            (*quiet_states(arm, 10), *random_states(arm, 20), *random_states(arm, 10, speed=1.0))
        ):
            observation, state = pg.Observation(0.0, q, v), arm.update(q, v)
            reference = calm(state) if index % 2 else nearby(state)
            one, other = usual.step(observation, reference), parts.step(observation, reference)
            usual.reset()
            parts.reset()
            np.testing.assert_array_equal(one.command.torque, other.command.torque)
            np.testing.assert_array_equal(one.acceleration, other.acceleration)
            assert one.active_limits == other.active_limits
            found = usual._usual.solve_or_assemble(0.0, state)
            counts["free"] += isinstance(found, ControllerOutput)
            counts["active"] += bool(one.active_limits)
    assert min(counts.values()) > 10


@pytest.mark.parametrize("name", ARMS)
def test_parts_that_are_not_the_usual_ones_are_asked_themselves(name):
    arm = without_friction(name)
    q = HOME[name]

    class OwnFrameTask(pg.FrameTask):
        pass

    frame, posture, link = pg.FrameTask(arm), pg.PostureTask(arm, q), "link4" if name == "wam7" else "panda_link4"
    limits = [*pg.limits_of(arm), pg.AccelerationLimit(arm, 100.0)]
    assert pg.InverseDynamics(arm, [frame, posture])._usual is not None
    for unusual in (
        pg.InverseDynamics(arm, [posture, frame]),
        pg.InverseDynamics(arm, [OwnFrameTask(arm), posture]),
        pg.InverseDynamics(arm, [pg.FrameTask(arm, link), posture]),
        pg.InverseDynamics(arm, [frame, pg.JointTask(arm, q, pg.JointImpedance(1.0))]),
        pg.InverseDynamics(arm, [frame, posture], limits),
        pg.InverseDynamics(arm, [frame, posture], ["torque"]),
        pg.InverseDynamics(arm, [frame, posture], solver="osqp"),
    ):
        assert unusual._usual is None
