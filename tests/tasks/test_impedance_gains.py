"""Gains of an impedance: allowed values, the axes along which they act, and stability of the sampled loop."""

import numpy as np
import pinocchio as pin
import pytest

from arms import ARMS, HOME, load, without_friction
from pilegrasp_ctrl.control.impedance import ImpedanceController
from pilegrasp_ctrl.control.sampled_data import stiffness_margin, tool_mobility
from pilegrasp_ctrl.exceptions import ConfigurationError, SimulationError
from pilegrasp_ctrl.robots import path
from pilegrasp_ctrl.tasks.gains import Impedance, MotionGains, load_gains
from pilegrasp_ctrl.tasks.impedance_law import ImpedanceLaw
from pilegrasp_ctrl.types import Observation, Pose, Reference
from touch import LAG, home, run

PRESET = path("hands/shovel", "impedance.toml")
STIFF = Impedance([2500.0] * 3 + [120.0] * 3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("stiffness = true", r"\[impedance\]: stiffness = True must be one number or six"),
        ("stiffness = [true, 1, 1, 1, 1, 1]", "stiffness = .* must be one number or six"),
        ("stiffness = '5'", "stiffness = '5' must be one number or six"),
        ("stiffness = [[1], [2, 3]]", "stiffness = .* must be one number or six"),
        ("stiffness = 1\ndamping_ratio = true", "damping_ratio = True must be a .*number"),
        ("stiffness = 1\ndead_band = [1, true]", "dead_band = .* must be two numbers"),
        ("stiffness = 1\ndead_band = [1, nan]", "dead_band = .* must be finite and not negative"),
        ("stiffness = 1\ndesired_force = 'x'", "desired_force = 'x' must be six numbers"),
        ("stiffness = 1\nframe = 'hand'", "frame = 'hand' must be one of 'world', 'tool'"),
        ("stiffness = 1\nframe = 3", "frame = 3 must be one of"),
        ("stiffness = 1\nforce_gain = -1", "force_gain = -1 must be a finite number that is not negative"),
        ("stiffness = 1\nforce_gain = inf", "force_gain = inf must be"),
        ("stiffness = 1\ndamping_ratio = 0", "damping_ratio = 0 needs damping on every axis"),
        (f"stiffness = 1{'0' * 400}", "stiffness = 1000"),
    ],
)
def test_an_error_names_the_value_that_is_not_a_gain(tmp_path, text, message):
    file = tmp_path / "gains.toml"
    file.write_text(f"[impedance]\n{text}\n", encoding="utf-8")
    with pytest.raises(ConfigurationError, match=message):
        load_gains(file)


def test_booleans_are_rejected_as_motion_gains():
    for arguments in ({"stiffness": True}, {"stiffness": 1.0, "damping_ratio": True}):
        with pytest.raises(ConfigurationError, match="True must be"):
            MotionGains(**arguments)


def test_the_preset_holds_the_published_numbers_under_our_names_of_the_axes():
    gains = load_gains(PRESET)
    # The published axes are x down the fingers, y to the thumb, z along the push; ours are x along the push, y, z up.
    ours_to_theirs = np.array([[0, 0, -1.0], [0, 1, 0], [1, 0, 0]])
    assert np.linalg.det(ours_to_theirs) == pytest.approx(1.0)
    turn = np.kron(np.eye(2), ours_to_theirs)
    for ours, published in (
        (gains.inertia, [20, 20, 5, 0.3, 0.3, 0.3]),
        (gains.damping, [120, 120, 120, 2, 2, 2]),
        (gains.stiffness, [10, 10, 20, 0, 0, 0]),
    ):
        np.testing.assert_allclose(turn @ np.diag(ours) @ turn.T, np.diag(published))
    np.testing.assert_allclose(turn @ gains.desired_force, [5.0, 0, 5.0, 0, 0.005, 0])
    assert (gains.dead_band, gains.damping_ratio, gains.frame) == ((2.5, 0.5), 0.0, "tool")


def motion(inertia, damping, stiffness, force, times):
    """Return the overdamped x(t) of inertia x'' + damping x' + stiffness x = force from rest."""
    root = np.sqrt(damping**2 - 4.0 * inertia * stiffness)
    slow, fast = (-damping + root) / (2.0 * inertia), (-damping - root) / (2.0 * inertia)
    if stiffness == 0.0:
        return force / damping * (times - (1.0 - np.exp(fast * times)) * inertia / damping)
    return force / stiffness * (1.0 + (fast * np.exp(slow * times) - slow * np.exp(fast * times)) / (slow - fast))


@pytest.mark.slow
@pytest.mark.parametrize("axis", range(6))
@pytest.mark.parametrize("name", ARMS)
def test_the_preset_moves_as_its_mass_damper_and_spring_along_the_tool_s_axes(name, axis):
    arm, gains = without_friction(name), load_gains(PRESET)
    start = home(arm)
    R, reference = start.rotation, Reference(start.pose)
    push = np.zeros(6)
    push[axis] = 6.0 if axis < 3 else 0.9
    controller = ImpedanceController(arm, gains, HOME[name])

    def control(observation, state):
        return controller.step(observation, reference, state=state, desired_force=np.zeros(6))

    world = np.concatenate((R @ push[:3], R @ push[3:]))
    times, _, states = run(arm, control, lambda pose, twist: world, 1.5)
    moved = np.array(
        [np.concatenate((R.T @ (s.translation - start.translation), pin.log3(R.T @ s.rotation))) for s in states]
    )
    force = push[axis] - gains.dead_band[axis // 3]
    expected = motion(gains.inertia[axis], gains.damping[axis], gains.stiffness[axis], force, times)
    np.testing.assert_allclose(moved[:, axis], expected, atol=0.02 * expected[-1])


@pytest.mark.parametrize("name", ARMS)
def test_without_a_damping_ratio_only_explicit_damping_acts(name):
    arm = without_friction(name)
    task = ImpedanceLaw(Impedance(400.0, damping_ratio=0.0, damping=[120.0] * 3 + [2.0] * 3))
    mobility = tool_mobility(arm, task.impedance, HOME[name])
    np.testing.assert_allclose(task.damping(mobility), np.diag([120.0] * 3 + [2.0] * 3), atol=1e-9)
    moving = arm.update(HOME[name], np.full(arm.nv, 0.1))
    wanted = task.acceleration(moving, Reference(moving.pose), np.zeros(6), np.zeros(6), np.zeros(6), mobility)
    np.testing.assert_allclose(np.linalg.solve(mobility, wanted), -task.impedance.damping * moving.twist, atol=1e-6)


def spring_force(arm, controller, displacement):
    """Return the force (6,) on the tool for a displaced reference."""
    state = home(arm)
    observation = Observation(0.0, state.q, state.v)
    torques = [
        controller.step(observation, Reference(pose)).command.torque
        for pose in (state.pose, state.pose.moved(displacement))
    ]
    inverse = np.linalg.inv(state.M)
    return np.linalg.solve(state.J @ inverse @ state.J.T, state.J @ inverse @ (torques[1] - torques[0]))


@pytest.mark.parametrize("frame", ["world", "tool"])
@pytest.mark.parametrize("name", ARMS)
def test_springs_act_along_the_axes_of_their_frame(name, frame):
    arm = without_friction(name)
    axes = home(arm).rotation if frame == "tool" else np.eye(3)
    stiffness = np.array([900.0, 300.0, 100.0])
    controller = ImpedanceController(arm, Impedance([*stiffness, 30.0, 30.0, 30.0], frame=frame), HOME[name])
    for axis in range(3):
        force = spring_force(arm, controller, 0.01 * axes[:, axis])
        np.testing.assert_allclose(force[:3], 0.01 * stiffness[axis] * axes[:, axis], atol=0.02)


@pytest.mark.parametrize("frame", ["world", "tool"])
def test_a_mask_frees_an_axis_of_the_frame(frame):
    arm, gains = without_friction("panda"), Impedance([400.0] * 3 + [30.0] * 3, frame=frame)
    state = home(arm)
    axes = state.rotation if frame == "tool" else np.eye(3)
    reference = Reference(state.pose.moved(0.01 * axes[:, 0]))

    def acceleration(mask):
        controller = ImpedanceController(arm, gains, HOME["panda"], mask=mask)
        output = controller.step(Observation(0.0, state.q, state.v), reference)
        return axes.T @ (state.J @ output.acceleration)[:3]

    controlled, freed = acceleration([True] * 6), acceleration([False] + [True] * 5)
    np.testing.assert_allclose(freed[1:], controlled[1:], atol=1e-3)
    assert abs(freed[0] - controlled[0]) > 0.1


@pytest.mark.parametrize("name", ARMS)
def test_springs_act_on_the_joints_through_the_transposed_jacobian(name):
    """A push at the tool and the spring's answer therefore cancel in every joint."""
    arm = without_friction(name)
    state, gains = home(arm), Impedance([400.0] * 3 + [30.0] * 3)
    controller = ImpedanceController(arm, gains, HOME[name], limits=())
    turn = pin.exp3(np.array([0.02, 0.0, -0.01]))
    reference = Reference(Pose(state.translation + np.array([0.01, -0.02, 0.01]), turn @ state.rotation))
    output = controller.step(Observation(0.0, state.q, state.v), reference)
    force = gains.stiffness * np.array([0.01, -0.02, 0.01, 0.02, 0.0, -0.01])
    here = controller.step(Observation(0.0, state.q, state.v), Reference(state.pose))
    np.testing.assert_allclose(output.command.torque - here.command.torque, state.J.T @ force, atol=0.02)


def test_a_torque_on_the_light_wrist_is_resisted_without_moving_the_shoulder():
    """The torque is 0.5 N·m at the bare flange: 1000 rad/s² for the last joint alone, and far within its limit."""
    arm = without_friction("wam7")
    start = home(arm)
    controller = ImpedanceController(arm, Impedance([400.0] * 3 + [30.0] * 3), HOME["wam7"])
    twist = np.concatenate((np.zeros(3), 0.5 * start.rotation[:, 2]))
    outputs = []

    def control(observation, state):
        outputs.append(controller.step(observation, Reference(start.pose), state=state))
        return outputs[-1]

    *_, states = run(arm, control, lambda pose, velocity: twist, 1.0)
    turned = pin.log3(states[-1].rotation @ start.rotation.T)
    np.testing.assert_allclose(turned, twist[3:] / 30.0, atol=1e-3)
    assert max(np.abs(output.command.torque[0] - states[0].h[0]) for output in outputs) < 2.0
    assert np.abs(states[-1].v).max() < 1e-3


@pytest.mark.parametrize("make", [without_friction, load])
@pytest.mark.parametrize("name", ARMS)
def test_a_target_out_of_reach_exceeds_no_limit(name, make):
    """Stiff springs pull half a metre away, into the limits of speed, of torque and, on the WAM, of position."""
    arm = make(name)
    start, outputs = home(arm), []
    controller = ImpedanceController(arm, Impedance([4000.0] * 3 + [80.0] * 3), HOME[name])
    reference = Reference(start.pose.moved([-0.5, -0.5, 0.4]))

    def control(observation, state):
        outputs.append(controller.step(observation, reference, state=state))
        return outputs[-1]

    *_, states = run(arm, control, None, 1.5)
    assert {limit.partition("[")[0] for output in outputs for limit in output.active_limits} >= {"torque", "velocity"}
    for output, state in zip(outputs, states, strict=True):
        assert (np.abs(output.command.torque) <= arm.torque_limit).all()
        assert (np.abs(state.v) <= arm.velocity_limit).all()
        assert ((arm.q_lower <= state.q) & (state.q <= arm.q_upper)).all()
    assert np.linalg.norm(states[-1].translation - reference.pose.translation) < 0.06


@pytest.mark.parametrize(("share", "diverges"), [(0.95, False), (1.05, True)])
@pytest.mark.parametrize("name", ARMS)
def test_the_sampled_loop_diverges_beyond_the_stiffness_margin(name, share, diverges):
    arm = without_friction(name)
    start = home(arm)
    gains = Impedance(share * stiffness_margin(arm, STIFF, HOME[name]) * STIFF.stiffness)
    # Without a posture the gains are not checked, and only the springs' dampers act.
    controller = ImpedanceController(arm, gains, limits=())
    reference = Reference(start.pose.moved([5e-4, 0.0, 0.0]))

    def oscillation():
        *_, states = run(arm, lambda o, s: controller.step(o, reference, state=s), None, 0.5)
        return np.abs(states[-1].v).max()

    if diverges:
        with pytest.raises(SimulationError, match="diverged"):
            oscillation()
    else:
        assert oscillation() < 1e-3


@pytest.mark.parametrize("ratio", [0.5, 1.0, 1.4])
def test_the_damping_ratio_determines_the_largest_stable_frequency(ratio):
    arm = without_friction("panda")
    gains = Impedance(STIFF.stiffness, ratio)
    mobility = tool_mobility(arm, gains, HOME["panda"])
    fastest = np.sqrt(np.linalg.eigvals(mobility @ np.diag(gains.stiffness)).real.max())
    margin = stiffness_margin(arm, gains, HOME["panda"], 500.0)
    assert np.sqrt(margin) * fastest == pytest.approx(500.0 * min(1.0 / ratio, 4.0 * ratio), rel=1e-5)
    assert stiffness_margin(arm, gains, HOME["panda"], 1000.0) == pytest.approx(4.0 * margin, rel=1e-5)


def test_dampers_alone_have_their_own_stability_limit():
    arm = without_friction("panda")
    viscous = Impedance(0.0, damping=[40.0] * 3 + [2.0] * 3)
    assert stiffness_margin(arm, viscous, HOME["panda"]) == np.inf
    assert stiffness_margin(arm, Impedance(1.0, damping=1e5), HOME["panda"]) == 0.0


def test_springs_too_stiff_for_the_rate_are_rejected_and_the_suggested_stiffness_is_accepted():
    """These are the shipped springs on the bare flange, whose last joint has the inertia of a few coins."""
    arm = load("wam7")
    with pytest.raises(ConfigurationError, match=r"too stiff for wam7 at 500 Hz.*take at most 0\.791 of its stiffness"):
        ImpedanceController(arm, STIFF, HOME["wam7"])
    ImpedanceController(arm, Impedance(0.791 * STIFF.stiffness), HOME["wam7"])
    ImpedanceController(arm, STIFF, HOME["wam7"], rate=1000.0)
    with pytest.raises(ConfigurationError, match=r"too strongly damped.*take less damping"):
        ImpedanceController(arm, Impedance(1.0, damping=1e5), HOME["wam7"])


@pytest.mark.parametrize(
    ("stiffness", "message"),
    [(np.eye(3), "shape"), (np.triu(np.ones((6, 6))), "symmetric"), (-np.eye(6), "eigenvalue")],
)
def test_an_unusable_stiffness_matrix_is_rejected(stiffness, message):
    with pytest.raises(ConfigurationError, match=message):
        ImpedanceController(load("panda"), STIFF, stiffness=stiffness)


def test_a_force_gain_needs_the_controller_with_a_memory():
    with pytest.raises(ConfigurationError, match="force_gain needs a memory: use ContactImpedanceController"):
        ImpedanceController(load("panda"), Impedance(400.0, force_gain=2.0))


def test_the_preset_s_inertia_is_large_enough_for_the_simulated_sensor():
    for name in ARMS:
        ImpedanceController(load(name), load_gains(PRESET), HOME[name], wrench_lag=LAG)
