"""Copies of an arm with a payload or with other numbers are what an arm made anew would be."""

import pickle
from copy import deepcopy
from time import perf_counter

import numpy as np
import pinocchio as pin
import pytest

from arms import ARMS, HOME, load
from pilegrasp_ctrl import ArmModel
from pilegrasp_ctrl.exceptions import ModelError, PilegraspError
from pilegrasp_ctrl.types import MassProperties, Pose

TOOL_FRAME = Pose([0.05, 0.01, 0.15], pin.rpy.rpyToMatrix(0.2, 0.4, -0.3))
TOOL = MassProperties(0.8, [0.02, -0.01, 0.09], np.diag([3e-3, 2e-3, 1e-3]))
PAYLOAD = (1.3, [0.03, 0.02, 0.1], np.array([[4e-3, 1e-4, 0.0], [1e-4, 5e-3, 2e-4], [0.0, 2e-4, 3e-3]]))
NUMBERS = ("q_lower", "q_upper", "velocity_limit", "torque_limit", "friction_coulomb", "friction_viscous")


def states(arm):
    for q in HOME[arm.name] + np.random.default_rng(0).uniform(-0.5, 0.5, (3, 7)):
        yield arm.update(q, 2.0 * q)


def assert_same(arm, other):
    for own, others in zip(states(arm), states(other), strict=True):
        for mine, theirs in zip(own[:10], others[:10], strict=True):
            np.testing.assert_allclose(mine, theirs, atol=1e-9)


@pytest.mark.parametrize("name", ARMS)
def test_a_payload_is_a_further_tool_in_the_axes_of_the_tool_frame(name):
    carrier = load(name, tool=TOOL, transform_tool_to_frame=TOOL_FRAME)
    loaded = carrier.with_payload(*PAYLOAD)
    first = load(name, tool=MassProperties(*PAYLOAD), transform_tool_to_frame=TOOL_FRAME)
    flange = load(name, transform_tool_to_frame=TOOL_FRAME)
    for with_both, with_tool, bare, state in zip(*map(states, (loaded, carrier, flange, first)), strict=True):
        # What the payload adds is what it weighs at its own place, whatever else the tool is.
        assert np.abs(with_both.M - with_tool.M).max() > 1e-2
        assert state.M.shape == bare.M.shape
    at_tool = load(name, tool=TOOL, transform_tool_to_frame=TOOL_FRAME).pinocchio_model
    frame = at_tool.frames[at_tool.getFrameId(carrier.tool_frame)]
    mass, centre, inertia = PAYLOAD
    at_tool.appendBodyToJoint(frame.parentJoint, pin.Inertia(mass, np.array(centre), inertia), frame.placement)
    assert_same(loaded, carrier.replace(model=at_tool))


@pytest.mark.parametrize("name", ARMS)
def test_a_payload_pulls_at_its_centre_of_mass(name):
    arm = load(name, transform_tool_to_frame=TOOL_FRAME)
    mass, centre, _ = PAYLOAD
    q, v = HOME[name], np.zeros(7)
    state, loaded = arm.update(q, v), arm.with_payload(mass, centre).update(q, v)
    lever = np.cross(state.rotation @ centre, [0.0, 0.0, 9.81 * mass])
    np.testing.assert_allclose(loaded.h - state.h, state.J.T @ [0.0, 0.0, 9.81 * mass, *lever], atol=1e-9)


def test_a_payload_leaves_the_arm_as_it_was_and_keeps_names_and_limits():
    arm = load("wam7")
    before = next(states(arm)).M.copy()
    loaded = arm.with_payload(2.0, [0.0, 0.0, 0.1]).with_payload(0.5, [0.0, 0.1, 0.0])
    np.testing.assert_array_equal(next(states(arm)).M, before)
    for what in NUMBERS:
        np.testing.assert_array_equal(getattr(loaded, what), getattr(arm, what))
    np.testing.assert_array_equal(loaded.joint_to_motor, arm.joint_to_motor)
    assert repr(loaded) == repr(arm)
    for copied in (deepcopy(loaded), pickle.loads(pickle.dumps(loaded))):
        np.testing.assert_array_equal(next(states(copied)).M, next(states(loaded)).M)


def test_a_payload_takes_well_under_a_millisecond():
    arm = load("panda")
    times = []
    for _ in range(50):
        start = perf_counter()
        arm.with_payload(1.0, [0.0, 0.0, 0.1])
        times.append(perf_counter() - start)
    assert min(times) < 5e-4


@pytest.mark.parametrize(
    ("payload", "words"),
    [
        ((-1.0, [0.0, 0.0, 0.0]), "mass is -1 kg; it must not be negative"),
        ((np.inf, [0.0, 0.0, 0.0]), "mass holds a value that is not finite"),
        (("heavy", [0.0, 0.0, 0.0]), "mass is 'heavy'; a number is expected"),
        ((1.0, 0.1), r"center_of_mass has shape \(\); \(3,\) is expected"),
        ((1.0, "tip"), "center_of_mass is 'tip'; an array of numbers"),
        ((1.0, [0.0, 0.0, 0.0], -np.eye(3)), "inertia is not symmetric positive semi-definite"),
        ((1e5, [0.0, 0.3, 0.5]), "joint 'panda_joint[26]' cannot carry its links"),
    ],
)
def test_a_payload_that_cannot_be_is_refused_in_a_sentence(payload, words):
    with pytest.raises(PilegraspError, match=words):
        load("panda").with_payload(*payload)


def test_replaced_numbers_are_new_and_all_others_stay():
    arm = load("wam7", base=TOOL_FRAME, tool=TOOL, transform_tool_to_frame=TOOL_FRAME)
    slow = arm.replace(velocity_limit=0.5 * arm.velocity_limit, name="slow")
    np.testing.assert_array_equal(slow.velocity_limit, 0.5 * arm.velocity_limit)
    for what in NUMBERS:
        if what != "velocity_limit":
            np.testing.assert_array_equal(getattr(slow, what), getattr(arm, what))
    np.testing.assert_array_equal(slow.motor_torque_limit, arm.motor_torque_limit)
    assert (slow.name, slow.tool_frame) == ("slow", arm.tool_frame)
    assert_same(arm, slow.replace(name=arm.name))


def test_none_takes_a_number_back_to_its_default():
    bare = load("wam7").replace(friction_coulomb=None, joint_to_motor=None, motor_torque_limit=None)
    assert not bare.friction_coulomb.any()
    assert bare.joint_to_motor is None
    np.testing.assert_array_equal(bare.friction_viscous, load("wam7").friction_viscous)


def test_gravity_armature_and_the_model_itself_can_be_replaced():
    arm = load("panda")
    q, v = HOME["panda"], np.zeros(7)
    np.testing.assert_allclose(arm.replace(gravity=(0.0, 0.0, 0.0)).update(q, v).h, np.zeros(7), atol=1e-12)
    drives = arm.replace(armature=np.full(7, 0.5)).update(q, v).M - arm.update(q, v).M
    np.testing.assert_allclose(drives, 0.5 * np.eye(7), atol=1e-12)
    model = arm.pinocchio_model
    model.gravity.linear = np.zeros(3)
    np.testing.assert_allclose(arm.replace(model=model).update(q, v).h, np.zeros(7), atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (
            {"torque_limits": np.ones(7)},
            "cannot replace 'torque_limits'; what can be replaced is model, name, gravity, q_l",
        ),
        ({"torque_limit": 50.0}, "torque_limit must be 7 numbers, one for each of j1"),
        ({"velocity_limit": np.zeros(7)}, "'j1' does not have velocity_limit > 0"),
        (
            {"torque_limit": np.full(7, 5.0)},
            "the motors give 'j2' more than its torque_limit; lower motor_torque_limit",
        ),
        ({"model": "wam7"}, "model must be a Model; it is a str"),
    ],
)
def test_a_number_that_does_not_fit_is_refused_in_a_sentence(changes, words):
    with pytest.raises(ModelError, match=words):
        load("wam7").replace(**changes)


def test_the_constructor_takes_base_gravity_and_tool_as_from_urdf_does():
    options = {"base": TOOL_FRAME, "gravity": (1.0, 0.0, -9.0), "tool": TOOL, "transform_tool_to_frame": TOOL_FRAME}
    whole = load("panda", **options)
    bare = load("panda")
    made = ArmModel(bare.pinocchio_model, "panda_hand_tcp", name="panda", **options)
    assert_same(made, whole)
    assert made.tool_frame == whole.tool_frame
