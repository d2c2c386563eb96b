"""The compiled code gives the torques of the Python code, or leaves the period to it."""

import sys

import numpy as np
import pytest

from arms import ARMS, HOME, load, random_states
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.control.operational_space import OperationalSpaceController
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.types import MassProperties, Observation, Pose, Reference

pytest.importorskip("numba", reason="compiled control is the optional extra 'fast'")
AGREEMENT = 1e-9
"""Largest allowed difference of a torque [N·m]; sums are taken in another order."""


@pytest.fixture(params=ARMS)
def arm(request):
    return load(request.param, tool=MassProperties(0.6, np.array([0.0, 0.0, 0.08]), 0.0012 * np.eye(3)))


def both(arm, **arguments):
    return (OperationalSpaceController(arm, compiled=compiled, **arguments) for compiled in (False, True))


def runs_compiled(controller, state, reference):
    return controller._compiled.step(state, reference) is not None


def reference_near(state, rng, size):
    pose = state.pose
    turn = rng.normal(size=3) * size
    angle = np.linalg.norm(turn)
    x, y, z = turn / angle
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    rotation = (np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K) @ pose.rotation
    return Reference(
        Pose(pose.translation + rng.normal(size=3) * 0.3 * size, rotation), rng.normal(size=6) * 0.1, rng.normal(size=6)
    )


@pytest.mark.slow
@pytest.mark.parametrize("friction", [True, False])
@pytest.mark.parametrize(("mask", "weight"), [(None, 1.0), ([1, 1, 1, 0, 1, 1], [1.0, 2.0, 0.5, 1.0, 1.0, 3.0])])
def test_the_torques_are_those_of_the_python_code(arm, friction, mask, weight):
    plain, compiled = both(arm, posture=HOME[arm.name], friction=friction, mask=mask, weight=weight)
    rng = np.random.default_rng(5)
    count = 0
    for size in (1e-7, 1e-4, 3e-3, 3e-2):
        for q, v in random_states(arm, 60, seed=int(1e4 * size), speed=0.2):
            state = arm.update(q, v)
            reference = reference_near(state, rng, size)
            observation = Observation(0.0, q, v)
            expected, output = plain.step(observation, reference), compiled.step(observation, reference)
            np.testing.assert_allclose(output.command.torque, expected.command.torque, rtol=0.0, atol=AGREEMENT)
            np.testing.assert_allclose(output.acceleration, expected.acceleration, rtol=1e-9, atol=1e-6)
            assert output.active_limits == expected.active_limits
            count += runs_compiled(compiled, state, reference)
    assert count > 50, "the comparison must be of the compiled period"


@pytest.mark.parametrize("limits", [(), ("torque",), ("velocity", "position")])
def test_limits_that_are_left_out_are_left_out_in_compiled_code_too(arm, limits):
    plain, compiled = both(arm, limits=limits)
    q = HOME[arm.name]
    state = arm.update(q, np.zeros(arm.nv))
    reference = Reference(state.pose.moved([0.01, 0.0, 0.0]))
    observation = Observation(0.0, q, np.zeros(arm.nv))
    assert runs_compiled(compiled, state, reference)
    expected, output = plain.step(observation, reference), compiled.step(observation, reference)
    np.testing.assert_allclose(output.command.torque, expected.command.torque, rtol=0.0, atol=AGREEMENT)


def test_an_unusual_period_is_left_to_the_python_code(arm):
    _, compiled = both(arm)
    q, still = HOME[arm.name], np.zeros(arm.nv)
    state = arm.update(q, still)
    assert runs_compiled(compiled, state, Reference(state.pose))
    far = Reference(state.pose.moved([0.5, 0.0, 0.0]))
    assert not runs_compiled(compiled, state, far)
    half_a_turn = Reference(Pose(state.translation, np.diag([1.0, -1.0, -1.0]) @ state.rotation))
    assert not runs_compiled(compiled, state, half_a_turn)
    nan = Reference.trusted(state.pose, np.full(6, np.nan), np.zeros(6))
    assert not runs_compiled(compiled, state, nan)
    fast = arm.update(q, 0.99 * arm.velocity_limit)
    assert not runs_compiled(compiled, fast, Reference(fast.pose, fast.twist))
    stretched = arm.update(np.where(np.arange(arm.nv) == 3, 0.0 if arm.name == "wam7" else arm.q_upper[3], 0.0), still)
    assert not runs_compiled(compiled, stretched, Reference(stretched.pose.moved([0.0, 0.0, 0.02])))


def test_a_whole_motion_ends_at_the_same_pose():
    scenario = {"line.displacement": [0.0, 0.05, 0.0]}
    import pilegrasp_ctrl as pg

    ends = []
    for compiled in (False, True):
        result = pg.run(load_scenario("free_space_line", {**scenario, "controller.compiled": compiled}), record=True)
        ends.append(result.recording.signals["tool_position"][-1])
        assert result.success
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-6)


def test_compiled_impedance_control_is_rejected():
    scenario = load_scenario("push_wall", {"controller.compiled": True, "controller.kind": "impedance"})
    with pytest.raises(ConfigurationError, match="operational_space"):
        prepare(scenario, 0)


def test_without_numba_the_remedy_is_named(arm, monkeypatch):
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.delitem(sys.modules, "pilegrasp_ctrl.control.compiled_kernels", raising=False)
    with pytest.raises(ConfigurationError, match=r"pip install pilegrasp\[fast\]"):
        OperationalSpaceController(arm, compiled=True)
