"""A torque limit that binds for long ends an attempt; one that binds for a moment does not."""

import numpy as np
import pytest

from pilegrasp_ctrl.control.saturation_monitor import SATURATION_TIME, SaturationMonitor
from pilegrasp_ctrl.types import Command, ControllerOutput


def output(*active, fallback=""):
    return ControllerOutput(Command(np.zeros(7)), np.zeros(7), active, 0.0, fallback)


def first_report(period, outputs):
    saturation = SaturationMonitor(period)
    for tick, item in enumerate(outputs):
        if reason := saturation.update(item):
            return tick * period, reason
    return None


@pytest.mark.parametrize("period", [0.001, 0.002, 0.01])
@pytest.mark.parametrize("name", ["torque[2] upper", "motor[1] lower"])
def test_a_torque_limit_that_binds_for_too_long_is_named(period, name):
    ticks = round(1.0 / period)
    time, reason = first_report(period, [output()] * ticks + [output(name, "velocity[0] upper")] * 3 * ticks)
    assert time - 1.0 == pytest.approx(SATURATION_TIME, abs=2 * period)
    assert name in reason


def test_limits_that_bind_for_a_moment_are_not_reported():
    a, b = output("torque[0] upper"), output("torque[1] upper")
    assert first_report(0.002, ([a] * 450 + [output()]) * 5) is None
    assert first_report(0.002, ([a] * 450 + [b] * 450) * 3) is None
    assert first_report(0.002, [output("velocity[3] upper", "position[2] lower")] * 2000) is None


def test_a_solver_that_keeps_failing_is_reported_with_its_reason():
    time, reason = first_report(0.002, [output(fallback="daqp found none")] * 1000)
    assert time == pytest.approx(SATURATION_TIME, abs=0.01)
    assert "daqp found none" in reason
