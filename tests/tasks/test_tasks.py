"""Tasks ask for the accelerations of their laws, and gains are checked before they are used."""

import numpy as np
import pinocchio as pin
import pytest

from arms import ARMS, HOME, load, nearby, random_states
from pilegrasp_ctrl.exceptions import ArgumentError, ConfigurationError, GainsError
from pilegrasp_ctrl.tasks.frame_task import FrameTask
from pilegrasp_ctrl.tasks.gains import Impedance, MotionGains, load_gains
from pilegrasp_ctrl.tasks.impedance_law import ImpedanceLaw
from pilegrasp_ctrl.tasks.pose_task import pose_error
from pilegrasp_ctrl.tasks.posture_task import PostureTask
from pilegrasp_ctrl.types import Pose, Reference


@pytest.fixture(params=ARMS)
def arm(request):
    return load(request.param)


def at_home(arm, v=None):
    return arm.update(HOME[arm.name], np.zeros(arm.nv) if v is None else v)


def test_the_pose_error_moves_the_tool_onto_its_reference(arm):
    state = at_home(arm)
    shift, turn = np.array([0.03, -0.02, 0.01]), np.array([0.2, -0.4, 0.1])
    reference = Reference(Pose(state.translation + shift, pin.exp3(turn) @ state.rotation))
    np.testing.assert_allclose(pose_error(state, reference), np.concatenate((shift, turn)), atol=1e-12)


@pytest.mark.parametrize("angle", [179.0, 179.999, 180.0, 180.001, 181.0])
@pytest.mark.parametrize("axis", [[0, 0, 1], [1, 0, 0], [-1, 2, 2], [0, -1, 1]])
def test_the_rotation_error_is_the_shortest_and_changes_its_sense_beyond_half_a_turn(angle, axis):
    state, axis = at_home(load("panda")), np.array(axis) / np.linalg.norm(axis)
    reference = Reference(Pose(state.translation, pin.exp3(np.radians(angle) * axis) @ state.rotation))
    turn = pose_error(state, reference)[3:]
    assert np.linalg.norm(turn) == pytest.approx(np.radians(min(angle, 360.0 - angle)), abs=1e-9)
    np.testing.assert_allclose(pin.exp3(turn) @ state.rotation, reference.pose.rotation, atol=1e-9)
    if angle != 180.0:
        assert turn @ axis > 0.0 if angle < 180.0 else turn @ axis < 0.0


def test_a_rotation_with_round_off_still_gives_an_error_vector():
    """After many products a pose may be off by 1e-6, and the logarithm is most sensitive at half a turn."""
    state, rng = at_home(load("panda")), np.random.default_rng(0)
    for angle in (0.0, 1e-8, np.pi - 1e-8, np.pi):
        for _ in range(20):
            axis = rng.normal(size=3)
            rotation = pin.exp3(angle * axis / np.linalg.norm(axis)) @ state.rotation + rng.uniform(-2e-7, 2e-7, (3, 3))
            turn = pose_error(state, Reference(Pose(state.translation, rotation)))[3:]
            assert np.linalg.norm(turn) == pytest.approx(angle, abs=1e-5)


def following(arm, target, **arguments):
    """A task of the tool with a target."""
    task = FrameTask(arm, **arguments)
    task.set_target(target)
    return task


def test_rows_are_the_weighted_difference_from_the_wanted_acceleration(arm):
    q, v = next(random_states(arm, 1))
    state, a = arm.update(q, v), np.linspace(-1.0, 2.0, arm.nv)
    weight = np.array([1.0, 1.0, 4.0, 0.25, 0.25, 0.25])
    task = following(arm, nearby(state), weight=weight, mask=[1, 1, 1, 1, 1, 0])
    rows = task.rows(state)
    cost = np.sum(weight[:5] * (state.J @ a + state.Jdot_v - task.acceleration(state))[:5] ** 2)
    assert np.sum((rows.A @ a - rows.b) ** 2) == pytest.approx(cost)


def test_the_motion_law_feeds_acceleration_and_velocity_forward(arm):
    v = 0.1 * np.ones(arm.nv)
    state = at_home(arm, v)
    acceleration = np.arange(6.0)
    task = following(
        arm, Reference(state.pose, state.twist, acceleration), gains=MotionGains([100.0] * 3 + [400.0] * 3, 0.5)
    )
    np.testing.assert_allclose(task.acceleration(state), acceleration, atol=1e-9)
    task.set_target(Reference(state.pose.moved([0.01, 0.0, 0.0]), state.twist + np.eye(6)[3], acceleration))
    extra = task.acceleration(state) - acceleration
    np.testing.assert_allclose(extra, [100.0 * 0.01, 0, 0, 2 * 0.5 * 20.0, 0, 0], atol=1e-9)


def away(state, error):
    """A target at rest with this error (6,)."""
    return Reference(Pose(state.translation + error[:3], pin.exp3(error[3:]) @ state.rotation))


def test_a_large_error_asks_for_a_speed_rather_than_for_an_acceleration(arm):
    state = at_home(arm)
    gains = MotionGains([100.0, 100.0, 400.0, 900.0, 900.0, 900.0], damping_ratio=0.5)
    near = np.array([0.02, -0.03, 0.01, 0.02, 0.01, -0.02])
    task, rates = following(arm, away(state, near), gains=gains), gains.stiffness / gains.damping
    np.testing.assert_allclose(task.acceleration(state), gains.stiffness * near, atol=1e-9)
    for size in (3.0, 30.0):
        far = np.concatenate((size * near[:3] / np.linalg.norm(near[:3]), near[3:]))
        task.set_target(away(state, far))
        speed = task.acceleration(state) / gains.damping
        assert np.linalg.norm(speed[:3]) == pytest.approx(1.0)
        np.testing.assert_allclose(np.cross(speed[:3], rates[:3] * far[:3]), 0.0, atol=1e-9)
        np.testing.assert_allclose(speed[3:], rates[3:] * near[3:], atol=1e-9)
    far = np.concatenate((near[:3], 3.0 * near[3:] / np.linalg.norm(near[3:])))
    task.set_target(away(state, far))
    speed = task.acceleration(state) / gains.damping
    np.testing.assert_allclose(speed[:3], rates[:3] * near[:3], atol=1e-9)
    assert np.linalg.norm(speed[3:]) == pytest.approx(3.0)


def test_the_error_of_a_free_axis_does_not_slow_the_others(arm):
    state = at_home(arm)
    far = np.array([0.02, -0.01, 5.0, 0.01, 0.0, 0.0])
    task = following(arm, away(state, far), gains=MotionGains(400.0), mask=[1, 1, 0, 1, 1, 1])
    np.testing.assert_allclose(task.acceleration(state)[:2], [400.0 * 0.02, -400.0 * 0.01], atol=1e-9)


def test_the_posture_rows_are_a_damped_spring_and_can_be_retargeted(arm):
    target, other = np.linspace(0.0, 1.0, 7), np.linspace(1.0, 0.0, 7)
    q, v = np.linspace(-0.5, 0.5, 7), np.linspace(0.3, -0.3, 7)
    state = arm.update(q, v)

    def rows(task, instead=None):
        with task.instead(instead):
            objective, velocity = task.rows(state), task.velocity(0.0)
        np.testing.assert_allclose(objective.A, np.sqrt(task.weight) * np.eye(7))
        return np.array([velocity, objective.b]) / np.sqrt(task.weight)

    gains = {"stiffness": 25.0, "damping_ratio": 0.8, "weight": 1e-3}
    expected = [25.0 / 8.0 * (target - q), 25.0 * (target - q) - 8.0 * v]
    np.testing.assert_allclose(rows(PostureTask(arm, target, **gains)), expected, atol=1e-12)
    np.testing.assert_allclose(rows(PostureTask(arm, other, **gains), instead=target), expected, atol=1e-12)
    free = PostureTask(arm, None, **gains)
    np.testing.assert_allclose(rows(free, instead=target), expected, atol=1e-12)
    np.testing.assert_allclose(rows(free), [np.zeros(7), -8.0 * v], atol=1e-12)


def test_impedance_damping_gives_every_mode_the_same_ratio(arm):
    """The roots of Lambda s² + D s + K come from its companion matrix."""
    ratio = 0.7
    task = ImpedanceLaw(Impedance([300.0, 500.0, 200.0, 20.0, 30.0, 10.0], damping_ratio=ratio))
    state = at_home(arm)
    mobility = state.J @ np.linalg.inv(state.M) @ state.J.T
    K, D = np.diag(task.impedance.stiffness), task.damping(mobility)
    np.testing.assert_allclose(D, D.T, atol=1e-9)
    companion = np.block([[np.zeros((6, 6)), np.eye(6)], [-mobility @ K, -mobility @ D]])
    roots = np.linalg.eigvals(companion)
    frequencies = np.sqrt(np.linalg.eigvals(mobility @ K).real)
    np.testing.assert_allclose(sorted(np.abs(roots)), sorted(np.repeat(frequencies, 2)), rtol=1e-5)
    np.testing.assert_allclose(-roots.real / np.abs(roots), ratio, rtol=1e-5)


def test_an_axis_without_a_spring_is_damped_only_by_its_explicit_damper(arm):
    task = ImpedanceLaw(Impedance([300.0, 0.0, 300.0, 20.0, 20.0, 0.0], damping=[0, 40.0, 0, 0, 0, 2.0]))
    state = at_home(arm)
    D = task.damping(state.J @ np.linalg.inv(state.M) @ state.J.T)
    np.testing.assert_allclose(D[1], 40.0 * np.eye(6)[1], atol=1e-12)
    np.testing.assert_allclose(D[5], 2.0 * np.eye(6)[5], atol=1e-12)
    free = ImpedanceLaw(Impedance(0.0, damping=[40.0] * 3 + [2.0] * 3))
    np.testing.assert_allclose(free.damping(np.eye(6)), np.diag([40.0] * 3 + [2.0] * 3))


def test_a_stretched_straight_arm_still_has_finite_damping():
    arm = load("wam7")
    state = arm.update(np.zeros(7), 0.1 * np.ones(7))
    task = ImpedanceLaw(Impedance([500.0] * 3 + [30.0] * 3))
    reference = Reference(Pose(state.translation + 0.01, state.rotation))
    mobility = state.J @ np.linalg.inv(state.M) @ state.J.T
    wanted = task.acceleration(state, reference, pose_error(state, reference), np.zeros(6), np.zeros(6), mobility)
    assert np.isfinite(wanted).all()
    assert np.abs(wanted).max() < 1e4


def test_a_shaped_inertia_replaces_the_inertia_of_the_arm():
    arm = load("panda")
    state = at_home(arm)
    task = ImpedanceLaw(Impedance([100.0] * 6, inertia=[20.0, 20.0, 5.0, 0.3, 0.3, 0.3]))
    reference = Reference(state.pose.moved([0.0, 0.0, 0.1]))
    wrench = np.array([4.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    unused = np.zeros((6, 6))
    wanted = task.acceleration(state, reference, pose_error(state, reference), np.zeros(6), wrench, unused)
    np.testing.assert_allclose(wanted, [4.0 / 20.0, 0.0, 100.0 * 0.1 / 5.0, 0.0, 0.0, 0.0], atol=1e-9)


def test_gains_of_the_wrong_kind_are_rejected():
    with pytest.raises(GainsError, match=r"MotionGains in 1/s², not Impedance"):
        FrameTask(load("panda"), gains=Impedance(500.0))
    with pytest.raises(GainsError, match=r"Impedance in N/m.*not MotionGains"):
        ImpedanceLaw(MotionGains(500.0))


@pytest.mark.parametrize("weight", [-1.0, np.nan, 0.0, np.inf])
def test_unusable_weights_are_rejected(weight):
    with pytest.raises(ArgumentError, match="weight"):
        FrameTask(load("panda"), weight=weight)


@pytest.mark.parametrize("argument", ["stiffness", "damping_ratio", "weight"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, np.inf])
def test_unusable_posture_gains_are_rejected(argument, value):
    with pytest.raises(ConfigurationError, match=argument):
        PostureTask(load("panda"), np.zeros(7), **{argument: value})


def test_gains_take_a_number_or_six_and_are_read_only():
    gains = MotionGains(400.0)
    np.testing.assert_array_equal(gains.stiffness, [400.0] * 6)
    np.testing.assert_array_equal(gains.damping, [40.0] * 6)
    with pytest.raises(ValueError, match="read-only"):
        gains.stiffness[0] = 1.0
    with pytest.raises(AttributeError):
        gains.damping_ratio = 2.0


@pytest.mark.parametrize(
    ("gains_type", "arguments", "message"),
    [
        (MotionGains, {"stiffness": 0.0}, "stiffness.*positive"),
        (MotionGains, {"stiffness": [1.0, 2.0]}, "one number or six"),
        (MotionGains, {"stiffness": np.nan}, "finite"),
        (MotionGains, {"stiffness": 1.0, "damping_ratio": -1.0}, "damping_ratio"),
        (MotionGains, {"stiffness": 1.0, "damping_ratio": np.inf}, "damping_ratio"),
        (Impedance, {"stiffness": -1.0}, "stiffness.*not negative"),
        (Impedance, {"stiffness": [0.0, 1, 1, 1, 1, 1]}, "neither stiffness nor damping"),
        (Impedance, {"stiffness": 1.0, "inertia": 0.0}, "inertia.*positive"),
        (Impedance, {"stiffness": 1.0, "desired_force": [1.0]}, "desired_force"),
        (Impedance, {"stiffness": 1.0, "dead_band": [-1.0, 0.0]}, "dead_band"),
    ],
)
def test_unusable_gains_are_rejected(gains_type, arguments, message):
    with pytest.raises(ConfigurationError, match=message):
        gains_type(**arguments)


def test_gains_are_read_from_a_file(tmp_path):
    file = tmp_path / "gains.toml"
    file.write_text("[motion]\nstiffness = [900, 900, 900, 1600, 1600, 1600]\ndamping_ratio = 0.9\n")
    gains = load_gains(file)
    assert isinstance(gains, MotionGains)
    assert (gains.stiffness[5], gains.damping_ratio) == (1600.0, 0.9)
    file.write_text("[impedance]\nstiffness = 10\ninertia = [20, 20, 5, 0.3, 0.3, 0.3]\ndead_band = [2.5, 0.5]\n")
    impedance = load_gains(file)
    assert isinstance(impedance, Impedance)
    assert (impedance.inertia[2], impedance.dead_band) == (5.0, (2.5, 0.5))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"\[motion\] in 1/s² or \[impedance\] in N/m"),
        ("stiffness = 400", "one table is expected"),
        ("[motion]\nstiffness = 400\n[impedance]\nstiffness = 10", "one table is expected"),
        ("[motion]\nstifness = 400", "unknown key 'stifness'; valid keys are stiffness, damping_ratio"),
        ("[motion]\ndamping_ratio = 1", "'stiffness' is missing"),
        ("[motion]\nstiffness = 'high'", r"gains\.toml: \[motion\]"),
        ("[motion]\nstiffness = 400\ndamping_ratio = 'high'", "damping_ratio"),
        ("[impedance]\nstiffness = -3", r"\[impedance\]: stiffness"),
        ("[motion", "not valid TOML"),
    ],
)
def test_an_unusable_file_of_gains_is_rejected(tmp_path, text, message):
    file = tmp_path / "gains.toml"
    file.write_text(text)
    with pytest.raises(ConfigurationError, match=message):
        load_gains(file)


def test_an_error_names_a_missing_file_of_gains(tmp_path):
    with pytest.raises(ConfigurationError, match=r"none\.toml: no such file"):
        load_gains(tmp_path / "none.toml")
    with pytest.raises(ConfigurationError, match="cannot be read"):
        load_gains(tmp_path)
