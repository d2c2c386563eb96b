"""The torques equal those of TSID, an independent implementation, on the same problem."""

from importlib.util import find_spec

import numpy as np
import pytest

import tsid_problem

ARMS = tuple(tsid_problem.FRAMES)

AGREEMENT = 1e-6
"""Largest allowed difference of a torque [N·m]; measured differences are below 1e-9."""


@pytest.mark.parametrize("name", ARMS)
def test_torques_equal_the_recorded_ones_of_tsid(name):
    controller = tsid_problem.our_controller(name)
    for case in tsid_problem.recorded()[name]:
        output = controller.step(case.observation, case.reference)
        np.testing.assert_allclose(output.command.torque, case.torque, rtol=0.0, atol=AGREEMENT)
        assert output.fallback == ""


@pytest.mark.parametrize("name", ARMS)
def test_the_recorded_cases_include_both_limits_and_none(name):
    """Agreement would mean little without active limits."""
    controller, active = tsid_problem.our_controller(name), []
    for case in tsid_problem.recorded()[name]:
        active.append(controller.step(case.observation, case.reference).active_limits)
    kinds = {limit.partition("[")[0] for limits in active for limit in limits}
    assert kinds == {"torque", "velocity"}
    assert sum(not limits for limits in active) >= 10
    assert sum(len(limits) >= 2 for limits in active) >= 5


@pytest.mark.parametrize("name", ARMS)
def test_the_recorded_torques_resolve_the_regularisation_of_tsid(name):
    """The files distinguish programs that differ by 1/10,000 of the smallest weight."""
    without = tsid_problem.our_controller(name, regularisation=0.0)
    differences = [
        np.abs(without.step(case.observation, case.reference).command.torque - case.torque).max()
        for case in tsid_problem.recorded()[name]
    ]
    assert max(differences) > 10.0 * AGREEMENT


@pytest.mark.skipif(find_spec("tsid") is None, reason="tsid is not installed; the recorded torques replace it")
@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("demand", [0.3, 3.0, 20.0])
def test_torques_equal_those_of_the_installed_tsid(name, demand):
    from pilegrasp_ctrl.validation.bench.tsid import TsidController

    arm, ours = tsid_problem.load_arm(name), tsid_problem.our_controller(name)
    frame, posture = tsid_problem.FRAMES[name], tsid_problem.posture_task(name)
    theirs = TsidController(arm, frame, posture, tsid_problem.GAINS, tsid_problem.RATE)
    rng = np.random.default_rng(1)
    for _ in range(50):
        observation, reference = tsid_problem.draw(arm, rng, demand)
        torque = ours.step(observation, reference).command.torque
        np.testing.assert_allclose(torque, theirs.step(observation, reference), rtol=0.0, atol=AGREEMENT)
