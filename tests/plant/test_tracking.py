"""A controller on a simulated arm tracks its reference, and active limits are reported."""

import numpy as np
import pytest

from arms import ARMS, HOME, without_friction
from pilegrasp_ctrl import Arc, ArmSimulation, OperationalSpaceController, StraightLine
from pilegrasp_ctrl.plant.tracking import simulate_tracking


@pytest.fixture(params=ARMS)
def arm(request):
    return without_friction(request.param)


@pytest.mark.slow
@pytest.mark.parametrize("path", ["line", "arc"])
def test_without_friction_a_path_at_a_tenth_of_a_metre_per_second_is_tracked(arm, path):
    """The remaining error is the pull of the posture, which grows with the distance from it."""
    q = HOME[arm.name]
    start = arm.update(q, np.zeros(arm.nv)).pose
    if path == "line":
        motion = StraightLine(start, [0.0, 0.3, 0.0], 0.1)
    else:
        motion = Arc(start, start.moved([0.0, 0.1, 0.0]).translation, [1.0, 0.0, 0.0], -np.pi, 0.1)
    done = simulate_tracking(
        ArmSimulation(arm), OperationalSpaceController(arm, posture=q), motion.at, q, motion.duration + 0.5
    )
    errors = np.linalg.norm(done.error.reshape(-1, 2, 3), axis=2)
    assert errors[:, 0].max() < 1.5e-4
    assert errors[-1, 0] < 1e-4
    assert errors[:, 1].max() < 2e-4
    assert done.active_limits() == ()
    assert done.fallbacks == 0


def test_a_turning_arc_is_tracked(arm):
    q = HOME[arm.name]
    start = arm.update(q, np.zeros(arm.nv)).pose
    arc = Arc(start, start.moved([-0.2, 0.0, 0.0]).translation, [0.0, 0.0, 1.0], 0.6, 0.1, turning=True)
    done = simulate_tracking(ArmSimulation(arm), OperationalSpaceController(arm, posture=q), arc.at, q, arc.duration)
    assert np.abs(done.error).max() < 1.5e-4


def test_active_limits_are_reported_from_a_given_time_on():
    arm, q = without_friction("panda"), HOME["panda"]
    line = StraightLine(arm.update(q, np.zeros(7)).pose, [0.0, 0.3, 0.0], 2.0, acceleration=40.0)
    done = simulate_tracking(ArmSimulation(arm), OperationalSpaceController(arm, posture=q), line.at, q, 2.0)
    assert done.active_limits()
    assert done.active_limits(start=1.5) == ()
