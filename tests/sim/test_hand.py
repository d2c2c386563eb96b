"""Both hands: dimensions, mass, stiffness and closing."""

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.exceptions import ModelError
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.objects import OBJECT_MODELS

FINGERS = ("pinky", "ring", "middle", "index")


@pytest.fixture(scope="module")
def soft():
    hand = Hand.load("rbo_hand2")
    model = hand.standalone_spec().compile()
    model.opt.gravity[:] = 0.0
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    model.opt.timestep = 1e-3
    return hand, model


def tip(model, data, finger):
    body = data.body(f"{finger}_4")
    length = 0.083 / 4.0
    return body.xpos + body.xmat.reshape(3, 3) @ [length, 0.0, 0.0]


def settle(model, data, steps=4000):
    for _ in range(steps):
        mujoco.mj_step(model, data)


def test_dimensions_are_those_of_the_labs_collision_model(soft):
    hand, model = soft
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    tips = np.array([tip(model, data, finger) for finger in FINGERS])
    np.testing.assert_allclose(tips[:, 2], 0.178, atol=0.003)
    spacing = np.linalg.norm(np.diff(tips, axis=0), axis=1)
    np.testing.assert_allclose(spacing, [0.0275, 0.0319, 0.0308], atol=0.002)
    directions = np.array([data.body(f"{finger}_1").xmat.reshape(3, 3)[:, 0] for finger in FINGERS])
    along = directions.mean(axis=0)
    assert np.degrees(np.arccos(along[2] / np.linalg.norm(along))) == pytest.approx(32.5, abs=2.0)
    np.testing.assert_allclose(hand.transform_tool_to_flange.translation, tips.mean(axis=0), atol=0.003)
    assert hand.transform_tool_to_flange.rotation[:, 0] @ along / np.linalg.norm(along) > 0.98


@pytest.mark.parametrize(("name", "sensor", "total"), [("rbo_hand2", 0.255, 0.433), ("shovel", 0.255, 0.555)])
def test_mass_properties_are_those_of_the_compiled_model(name, sensor, total):
    hand = Hand.load(name)
    properties = hand.mass_properties()
    assert properties.mass == pytest.approx(total, abs=1e-6)
    assert hand.parameters["sensor"]["mass"] == sensor
    moments = np.linalg.eigvalsh(properties.inertia)
    assert moments[0] > 0.0
    assert moments[2] < moments[0] + moments[1]
    model = hand.standalone_spec().compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(properties.center_of_mass, data.subtree_com[model.body("sensor").id], atol=1e-9)


def test_a_finger_bends_under_load_by_its_joint_springs(soft):
    hand, model = soft
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    before = tip(model, data, "middle")
    body = data.body("middle_4")
    normal = body.xmat.reshape(3, 3)[:, 2].copy()
    force = 0.2
    data.xfrc_applied[model.body("middle_4").id, :3] = force * normal
    settle(model, data)
    # The load acts at the last segment's centre of mass; four equal springs, levers counted from there.
    lever = np.linalg.norm(
        data.xipos[model.body("middle_4").id] - np.array(hand.parameters["fingers"]["base"]["middle"])
    )
    levers = lever - np.arange(4) * 0.0207
    tip_levers = 0.0829 - np.arange(4) * 0.0207
    expected = force * (levers * tip_levers).sum() / hand.parameters["pneumatics"]["bending_stiffness"]
    assert (tip(model, data, "middle") - before) @ normal == pytest.approx(expected, rel=0.1)


def test_a_finger_yields_sideways(soft):
    _, model = soft
    data = mujoco.MjData(model)
    data.xfrc_applied[model.body("middle_4").id, :3] = [0.0, 0.2, 0.0]
    settle(model, data)
    assert 0.003 < abs(data.joint("middle_lateral").qpos[0]) < 0.1


def test_closure_bends_every_joint_alike_with_the_stated_time_constant(soft):
    hand, model = soft
    data = mujoco.MjData(model)
    constant = hand.parameters["pneumatics"]["time_constant"]
    data.ctrl[:] = 1.0
    for _ in range(round(constant / model.opt.timestep)):
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.act, 1.0 - np.exp(-1.0), atol=0.01)
    settle(model, data)
    bends = [data.joint(f"middle_bend_{i}").qpos[0] for i in range(1, 5)]
    moment, stiffness = (hand.parameters["pneumatics"][key] for key in ("closing_moment", "bending_stiffness"))
    np.testing.assert_allclose(bends, moment / stiffness, rtol=0.02)
    closed = tip(model, data, "middle")
    mujoco.mj_resetData(model, data)
    mujoco.mj_forward(model, data)
    palm_normal = hand.transform_tool_to_flange.rotation[:, 2]
    assert (closed - tip(model, data, "middle")) @ palm_normal > 0.03


def test_the_shovel_takes_one_ball_side_by_side_and_is_rigid():
    hand = Hand.load("shovel")
    model = hand.standalone_spec().compile()
    assert model.nv == 0
    floor = model.geom("scoop_floor")
    ball = 2.0 * OBJECT_MODELS["light_sphere"].half_size[0]
    thick = 2.0 * floor.size[2]
    assert ball < 2.0 * floor.size[1] - 2.0 * thick < 2.0 * ball
    assert thick <= 0.005
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    tool = hand.transform_tool_to_flange
    edge = data.geom("scoop_floor").xpos + data.geom("scoop_floor").xmat.reshape(3, 3) @ [
        floor.size[0],
        0,
        -floor.size[2],
    ]
    np.testing.assert_allclose(edge, tool.translation, atol=1e-9)


def test_the_error_names_an_unknown_hand():
    with pytest.raises(ModelError, match="gripper"):
        Hand.load("gripper")


def test_the_outline_spans_the_hand_in_its_tool_frame():
    soft, rigid = (Hand.load(name).outline() for name in ("rbo_hand2", "shovel"))
    least, greatest = (soft[:, :3] - soft[:, 3:]).min(axis=0), (soft[:, :3] + soft[:, 3:]).max(axis=0)
    # Seen from the gap between ring and middle finger, the thumb is on the right and the little finger on the left.
    assert least[1] == pytest.approx(-0.145, abs=2e-3)
    assert greatest[1] == pytest.approx(0.0485, abs=2e-3)
    assert greatest[0] == pytest.approx(0.0, abs=0.01)
    # The sensor is wider than the tray.
    assert np.abs(rigid[:, 1]).max() == pytest.approx(0.043)
