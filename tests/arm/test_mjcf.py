"""Arms from MuJoCo models have MuJoCo's kinematics and dynamics, and the limits of its joints and actuators."""

import re

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl import ArmModel, ArmSimulation, OperationalSpaceController, StraightLine
from pilegrasp_ctrl.exceptions import ModelError, ModelWarning
from pilegrasp_ctrl.plant.tracking import simulate_tracking
from pilegrasp_ctrl.robots import panda_urdf, path
from pilegrasp_ctrl.types import Pose
from published_arms import MUJOCO_ARMS, mujoco_arms

WAM = path("wam7", "wam7.xml")


def assert_like_mujoco(arm, model, states=100):
    """Compare inertia, bias and pose of the tool at random states; other joints stay at their positions in the file."""
    data = mujoco.MjData(model)
    joints = [model.joint(name) for name in arm.joint_names]
    q_at, v_at = [joint.qposadr[0] for joint in joints], [joint.dofadr[0] for joint in joints]
    of_body = arm.tool_frame in [model.body(i).name for i in range(model.nbody)]
    frame = data.body(arm.tool_frame) if of_body else data.site(arm.tool_frame)
    rng, inertia = np.random.default_rng(0), np.zeros((model.nv, model.nv))
    for _ in range(states):
        q, v = rng.uniform(-2.0, 2.0, (2, arm.nv))
        data.qpos[q_at], data.qvel[v_at] = q, v
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, inertia)
        state = arm.update(q, v)
        np.testing.assert_allclose(state.M, inertia[np.ix_(v_at, v_at)], atol=1e-9)
        np.testing.assert_allclose(state.h, data.qfrc_bias[v_at], atol=1e-9)
        np.testing.assert_allclose(state.translation, frame.xpos, atol=1e-9)
        np.testing.assert_allclose(state.rotation.ravel(), frame.xmat, atol=1e-9)


def random_tree(seed):
    """An MJCF with a turned base, side branches, several joints on a body, anchors, references, drives and a site."""
    rng = np.random.default_rng(seed)

    def numbers(n, scale=1.0):
        return " ".join(f"{value:.6f}" for value in scale * rng.normal(size=n))

    joints, motors = [], []

    def body(depth):
        own = []
        for _ in range(rng.integers(0, 3) if depth else 1):
            name, kind = f"j{len(joints)}", ("hinge", "slide")[int(rng.random() < 0.2)]
            joints.append(name)
            own.append(
                f'<joint name="{name}" type="{kind}" axis="{numbers(3)}" pos="{numbers(3, 0.1)}" '
                f'ref="{rng.normal():.4f}" armature="{rng.random():.4f}" damping="{rng.random():.4f}" '
                f'frictionloss="{rng.random():.4f}"/>'
            )
            motors.append(
                f'<motor joint="{name}" gear="{rng.normal():.4f}" ctrlrange="-9000 9000" ctrllimited="true" '
                f'armature="{rng.random():.4f}" damping="{rng.random():.4f}"/>'
            )
        children = "".join(body(depth + 1) for _ in range(0 if depth > 4 else 2 if depth == 1 else 1))
        return (
            f'<body name="b{rng.integers(1 << 40)}" pos="{numbers(3, 0.3)}" quat="{numbers(4)}">{"".join(own)}'
            f'<geom type="box" size="0.03 0.05 0.08" pos="{numbers(3, 0.1)}" quat="{numbers(4)}"/>'
            f'{"" if depth < 5 else f"""<site name="tip{len(joints)}" pos="{numbers(3, 0.1)}" quat="{numbers(4)}"/>"""}'
            f"{children}</body>"
        )

    tree = body(0)
    return (
        f'<mujoco><compiler angle="radian"/><option gravity="1 2 -9"/><worldbody>{tree}</worldbody>'
        f"<actuator>{''.join(motors)}</actuator></mujoco>"
    )


@pytest.mark.parametrize("seed", range(8))
def test_an_arm_has_the_inertia_the_bias_and_the_poses_that_mujoco_computes(seed):
    model = mujoco.MjModel.from_xml_string(random_tree(seed))
    for site in range(model.nsite):
        arm = ArmModel.from_mjcf(model, model.site(site).name)
        assert arm.nv == model.nv
        assert_like_mujoco(arm, model, states=15)


@pytest.mark.parametrize("seed", range(3))
def test_damping_and_friction_are_those_that_mujoco_applies(seed):
    model = mujoco.MjModel.from_xml_string(random_tree(seed))
    data = mujoco.MjData(model)
    arm = ArmModel.from_mjcf(model, model.site(0).name)
    data.qvel = np.linspace(-1.0, 1.0, model.nv)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(-arm.friction_viscous * data.qvel, data.qfrc_passive, atol=1e-12)
    np.testing.assert_array_equal(arm.friction_coulomb, model.dof_frictionloss)


def test_the_shipped_mjcf_makes_the_same_arm_as_the_urdf():
    urdf, mjcf = ArmModel.load("wam7"), ArmModel.from_mjcf(WAM, "flange")
    for what in ("q_lower", "q_upper", "torque_limit", "friction_coulomb", "friction_viscous"):
        np.testing.assert_allclose(getattr(mjcf, what), getattr(urdf, what), atol=1e-12)
    assert mjcf.joint_names == urdf.joint_names
    for q in np.random.default_rng(0).uniform(-1.0, 1.0, (5, 7)):
        for own, other in zip(mjcf.update(q, 2.0 * q)[:10], urdf.update(q, 2.0 * q)[:10], strict=True):
            np.testing.assert_allclose(own, other, atol=1e-9)


@pytest.mark.parametrize("name", [arm[0] for arm in MUJOCO_ARMS])
@pytest.mark.filterwarnings("ignore::pilegrasp_ctrl.exceptions.ModelWarning")
def test_arms_of_published_packages_are_those_that_mujoco_simulates(name):
    found = [arm for arm in mujoco_arms() if arm.name == name]
    if not found:
        pytest.skip(f"{name}: its package is not installed")
    published = found[0]
    arm, _ = published.completed()
    assert_like_mujoco(arm, mujoco.MjModel.from_xml_path(str(published.file)))


def one_joint(joint="", actuator="", more="", geom='mass="1"'):
    """An MJCF of one body on one hinge."""
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian"/><worldbody><body name="link"><joint name="hinge" axis="0 1 0" {joint}/>'
        f'<geom size="0.1" {geom}/></body>{more}</worldbody><actuator>{actuator}</actuator></mujoco>'
    )


@pytest.mark.parametrize(
    ("joint", "actuator", "limit"),
    [
        ("", '<motor joint="hinge" ctrlrange="-7 9"/>', 7.0),
        ("", '<motor joint="hinge" gear="-10" ctrlrange="-7 9"/>', 70.0),
        ("", '<motor joint="hinge" ctrlrange="-7 7" forcerange="-4 4"/>', 4.0),
        ("", '<general joint="hinge" gainprm="5" ctrlrange="-1 1"/>', 5.0),
        ("", '<position joint="hinge" kp="50" ctrlrange="-3 3" forcerange="-87 87"/>', 87.0),
        ("", '<position joint="hinge" kp="50" forcerange="-10 10" gear="3"/>', 30.0),
        ("", '<motor joint="hinge" ctrlrange="-7 7"/><motor joint="hinge" ctrlrange="-2 2"/>', 9.0),
        ('actuatorfrcrange="-5 6"', '<motor joint="hinge" ctrlrange="-7 7"/>', 5.0),
        ('actuatorfrcrange="-5 5"', '<position joint="hinge" kp="50"/>', 5.0),
        ('actuatorfrcrange="-5 5"', "", 5.0),
    ],
)
def test_torque_limits_are_those_of_the_actuators_and_the_joint(joint, actuator, limit):
    assert ArmModel.from_mjcf(one_joint(joint, actuator), "link").torque_limit.tolist() == [limit]


@pytest.mark.parametrize(
    ("actuator", "limit"),
    [
        ("", "0"),
        ('<position joint="hinge" kp="50" ctrlrange="-3 3"/>', "inf"),
        ('<motor joint="hinge"/>', "inf"),
        ('<motor joint="hinge" forcerange="0 5"/>', "0"),
    ],
)
def test_a_joint_without_a_torque_limit_needs_one_as_an_argument(actuator, limit):
    model = one_joint(actuator=actuator)
    with pytest.raises(ModelError, match=f"'hinge' has a torque_limit of {limit}; give torque_limit"):
        ArmModel.from_mjcf(model, "link")
    assert ArmModel.from_mjcf(model, "link", torque_limit=[3.0]).torque_limit.tolist() == [3.0]


def test_a_mujoco_model_limits_no_speed_unless_a_limit_is_given():
    arm = ArmModel.from_mjcf(WAM, "flange")
    assert np.isinf(arm.velocity_limit).all()
    q = np.array([0.26, 0.82, -0.01, 1.68, -0.87, 0.81, -1.03])
    line = StraightLine(arm.update(q, np.zeros(7)).pose, [0.0, 0.3, 0.1], 0.6, acceleration=3.0)
    motion = simulate_tracking(
        ArmSimulation(arm), OperationalSpaceController(arm, posture=q), line.at, q, line.duration
    )
    assert np.abs(motion.error[:, :3]).max() < 2e-3
    assert motion.active_limits() == ()
    slow = arm.replace(velocity_limit=np.full(7, 0.3))
    motion = simulate_tracking(
        ArmSimulation(slow), OperationalSpaceController(slow, posture=q), line.at, q, line.duration
    )
    assert any(name.startswith("velocity") for name in motion.active_limits())


def test_the_base_of_an_mjcf_is_where_the_file_puts_it_and_base_moves_it():
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body pos="1 0 0" euler="0 0 90"><body name="link" pos="1 0 0"><joint axis="1 0 0" '
        'actuatorfrcrange="-9 9"/><geom size="0.1" mass="1"/></body></body></worldbody></mujoco>'
    )
    np.testing.assert_allclose(ArmModel.from_mjcf(model, "link").update([0.0], [0.0]).translation, [1.0, 1.0, 0.0])
    moved = ArmModel.from_mjcf(model, "link", base=Pose([0.0, 0.0, 5.0]))
    np.testing.assert_allclose(moved.update([0.0], [0.0]).translation, [1.0, 1.0, 5.0])


def test_gravity_is_that_of_the_model():
    text = (
        '<mujoco><option gravity="0 0 -1.62">{}</option><worldbody><body name="link"><joint name="hinge" axis="0 1 0" '
        'actuatorfrcrange="-9 9"/><geom size="0.1" pos="1 0 0" mass="1"/></body></worldbody></mujoco>'
    )
    for flag, weight in (("", 1.62), ('<flag gravity="disable"/>', 0.0)):
        arm = ArmModel.from_mjcf(mujoco.MjModel.from_xml_string(text.format(flag)), "link")
        np.testing.assert_allclose(arm.update([0.0], [0.0]).h, [-weight], atol=1e-12)


SCENE = """<mujoco><worldbody>
<body name="base"><body name="link1"><joint name="j1" axis="0 0 1" actuatorfrcrange="-50 50"/><geom size="0.1"/>
  <body name="link2" pos="0.3 0 0"><joint name="j2" axis="0 1 0" actuatorfrcrange="-50 50" ref="30"/><geom size="0.1"/>
    <body name="finger1" pos="0.1 0.02 0"><joint name="f1" type="slide" axis="0 1 0"/><geom size="0.01"/></body>
    <body name="finger2" pos="0.1 -0.02 0"><joint name="f2" type="slide" axis="0 -1 0"/><geom size="0.01"/></body>
    <site name="pinch" pos="0.12 0 0"/></body></body></body>
<body name="cube" pos="1 1 1"><freejoint name="cube"/><geom size="0.1"/></body>
<body name="lamp"><joint name="lamp" type="ball"/><geom size="0.1"/></body></worldbody>
<equality><joint joint1="f2" joint2="f1"/></equality><tendon><fixed name="split" stiffness="5">
<joint joint="f1" coef="1"/><joint joint="f2" coef="1"/></fixed></tendon></mujoco>"""


def test_an_arm_in_a_scene_is_told_by_the_joints_to_keep():
    model = mujoco.MjModel.from_xml_string(SCENE)
    for joints in (2, ["j1", "j2"]):
        arm = ArmModel.from_mjcf(model, "pinch", joints=joints)
        assert arm.joint_names == ("j1", "j2")
        assert_like_mujoco(arm, model)


def test_joints_are_locked_at_their_position_in_the_file_or_at_a_value_of_qpos():
    model = mujoco.MjModel.from_xml_string(SCENE)
    data = mujoco.MjData(model)
    for locked, expected in ((["j2"], np.radians(30.0)), ({"j2": 0.7}, 0.7)):
        arm = ArmModel.from_mjcf(model, "pinch", joints=1, locked_joints=locked)
        data.qpos[:2] = 0.4, expected
        mujoco.mj_forward(model, data)
        np.testing.assert_allclose(arm.update([0.4], [0.0]).translation, data.site("pinch").xpos, atol=1e-12)


@pytest.mark.parametrize(
    ("joints", "words"),
    [
        (None, "joint 'f2' follows 'f1' (equality of joints); add it to locked_joints"),
        (["j1", "cube"], "joint 'cube' is a free joint, neither hinge nor slide; lock it"),
        (["j1", "lamp"], "joint 'lamp' is a ball joint, neither hinge nor slide; lock it"),
        (["j1", "f1"], "joint 'f1' carries the tendon 'split' with a spring"),
        (3, "joints = 3 must be a number from 1 to 2"),
        (["j1", "j9"], "no joint 'j9' to keep; the joints are j1, j2, f1, f2, cube, lamp"),
    ],
)
def test_what_a_tree_of_joints_cannot_represent_is_refused_with_the_name_of_the_joint(joints, words):
    with pytest.raises(ModelError, match=re.escape(words)):
        ArmModel.from_mjcf(
            mujoco.MjModel.from_xml_string(SCENE),
            "pinch",
            joints=joints,
            locked_joints=[] if joints else ["cube", "lamp"],
        )


def test_a_joint_of_several_coordinates_cannot_be_locked_at_a_number():
    model = mujoco.MjModel.from_xml_string(SCENE)
    with pytest.raises(ModelError, match="'lamp' has several coordinates"):
        ArmModel.from_mjcf(model, "pinch", joints=2, locked_joints={"lamp": 1.0})


LOOP = """<mujoco><worldbody>
<body name="a" pos="0 0 0"><joint name="ja" axis="0 1 0" actuatorfrcrange="-9 9"/><geom size="0.1"/>
  <body name="b" pos="1 0 0"><joint name="jb" axis="0 1 0" actuatorfrcrange="-9 9"/><geom size="0.1"/></body></body>
<body name="hand" mocap="true"/></worldbody>
<equality><{kind} body1="{one}" body2="{two}" {more}/></equality></mujoco>"""


@pytest.mark.parametrize("kind", ["connect", "weld"])
def test_a_closed_loop_is_refused_unless_its_joints_are_locked(kind):
    anchor = 'anchor="0 0 0"' if kind == "connect" else ""
    model = mujoco.MjModel.from_xml_string(LOOP.format(kind=kind, one="b", two="world", more=f'{anchor} name="pin"'))
    with pytest.raises(ModelError, match="'ja' is part of a closed loop \\(equality 'pin'\\)"):
        ArmModel.from_mjcf(model, "b")
    model = mujoco.MjModel.from_xml_string(LOOP.format(kind=kind, one="b", two="a", more=anchor))
    with pytest.raises(ModelError, match="'jb' is part of a closed loop"):
        ArmModel.from_mjcf(model, "b")
    assert ArmModel.from_mjcf(model, "b", joints=1).joint_names == ("ja",)
    model = mujoco.MjModel.from_xml_string(LOOP.format(kind=kind, one="b", two="a", more=f'{anchor} active="false"'))
    assert ArmModel.from_mjcf(model, "b").nv == 2


def test_a_weld_to_a_mocap_body_is_a_handle_and_no_closed_loop():
    model = mujoco.MjModel.from_xml_string(LOOP.format(kind="weld", one="b", two="hand", more=""))
    assert ArmModel.from_mjcf(model, "b").nv == 2


def test_a_spring_is_left_out_with_a_warning():
    model = one_joint('stiffness="5" actuatorfrcrange="-9 9"')
    with pytest.warns(ModelWarning, match="'hinge' has a spring"):
        ArmModel.from_mjcf(model, "link")


def test_a_compensated_weight_needs_gravity_as_an_argument():
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body name="link" gravcomp="1"><joint name="hinge" axis="0 1 0" actuatorfrcrange="-9 9"/>'
        '<geom size="0.1" pos="1 0 0" mass="0.5"/></body></worldbody></mujoco>'
    )
    with pytest.raises(ModelError, match=r"'link', which joint 'hinge' moves, has gravcomp = 1.*give gravity"):
        ArmModel.from_mjcf(model, "link")
    assert ArmModel.from_mjcf(model, "link", gravity=(0.0, 0.0, 0.0)).update([0.0], [0.0]).h == pytest.approx([0.0])


def test_either_format_is_read_under_either_name():
    assert ArmModel.from_urdf(WAM, "flange").joint_names == ArmModel.load("wam7").joint_names
    panda = ArmModel.from_mjcf(panda_urdf(), "panda_hand_tcp", joints=7)
    assert repr(panda) == "ArmModel('panda', nv=7, tool_frame='panda_hand_tcp')"


def test_a_mujoco_model_in_memory_is_read_too():
    spec = mujoco.MjSpec.from_file(str(WAM))
    for model in (spec, spec.compile()):
        assert repr(ArmModel.from_mjcf(model, "flange")) == "ArmModel('wam7', nv=7, tool_frame='flange')"


def test_meshes_need_not_be_there_where_bodies_have_inertials(tmp_path):
    inertial = '<inertial pos="0 0 0.1" mass="2" diaginertia="0.1 0.1 0.1"/>'
    text = (
        '<mujoco><asset><mesh name="shape" file="shape.stl"/></asset><worldbody><body name="link">'
        '<joint axis="0 1 0" actuatorfrcrange="-9 9"/>{}<geom type="mesh" mesh="shape"/></body></worldbody></mujoco>'
    )
    file = tmp_path / "arm.xml"
    file.write_text(text.format(inertial))
    assert ArmModel.from_mjcf(file, "link").update([0.0], [0.0]).M.item() == pytest.approx(0.12)
    file.write_text(text.format(""))
    with pytest.raises(ModelError, match=r"arm\.xml: not a model that MuJoCo can compile: .*shape\.stl") as refused:
        ArmModel.from_mjcf(file, "link")
    assert "\n" not in str(refused.value)


def test_a_name_that_is_no_frame_is_refused_with_the_bodies_and_the_sites():
    with pytest.raises(
        ModelError, match=r"no frame 'tcp' for the tool; the links are base_link, .*; the sites are flange"
    ):
        ArmModel.from_mjcf(WAM, "tcp")
