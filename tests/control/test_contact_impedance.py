"""Control that is stiff in free motion and yields along a desired force: the law, a stiff table, a shovel's push."""

import mujoco
import numpy as np
import pytest

from arms import simulate, without_friction
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.control.contact_impedance import RAMP_TIME, YIELDING_STIFFNESS, ContactImpedanceController
from pilegrasp_ctrl.control.force_command import ForceFeedback, ForceRamp
from pilegrasp_ctrl.control.impedance import ImpedanceController
from pilegrasp_ctrl.episode import run
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.robots import path
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.simulation import Simulation
from pilegrasp_ctrl.tasks.gains import Impedance
from pilegrasp_ctrl.tasks.tool_axes import move_wrench
from pilegrasp_ctrl.types import Observation, Reference

IMPEDANCE = Impedance(stiffness=[2500.0, 2500.0, 2500.0, 120.0, 120.0, 120.0])
PRESS = np.array([0.0, 0.0, -5.0, 0.0, 0.0, 0.0])
HOME = np.array([0.26, 0.82, -0.01, 1.68, -0.87, 0.81, -1.03])


@pytest.fixture(scope="module")
def arm():
    return without_friction("wam7", tool=Hand.load("shovel").mass_properties())


def create(arm, impedance=IMPEDANCE, **arguments):
    return ContactImpedanceController.create(arm, impedance, HOME, "daqp", 500.0, **arguments)


def step(arm, controller, desired_force, pose=None, time=0.0):
    state = arm.update(HOME, np.zeros(7))
    reference = Reference(state.pose if pose is None else pose)
    return controller.step(Observation(time, HOME, np.zeros(7)), reference, state, desired_force)


def force_of(arm, torque):
    """Return the force (6,) on the tool that joint torques exert [N, N·m]."""
    state = arm.update(HOME, np.zeros(7))
    inverse = np.linalg.inv(state.M)
    return np.linalg.solve(state.J @ inverse @ state.J.T, state.J @ inverse @ (torque - state.h))


def spring_force(arm, controller, displacement, desired_force):
    """Return the force that a displaced reference adds on the tool [N, N·m], after the ramp has ended."""
    pose = arm.update(HOME, np.zeros(7)).pose
    forces = []
    for there in (pose, pose.moved(displacement)):
        step(arm, controller, desired_force)
        forces.append(force_of(arm, step(arm, controller, desired_force, there, time=1.0).command.torque))
    return forces[1] - forces[0]


def test_without_a_desired_force_the_torques_are_those_of_the_impedance_controller(arm):
    controller, plain = create(arm), ImpedanceController(arm, IMPEDANCE, HOME)
    state = arm.update(HOME, 0.1 * np.ones(7))
    observation = Observation(0.0, HOME, 0.1 * np.ones(7))
    reference = Reference(state.pose.moved([0.0, 0.01, -0.01]))
    np.testing.assert_array_equal(
        controller.step(observation, reference, state, np.zeros(6)).command.torque,
        plain.step(observation, reference, state=state).command.torque,
    )


@pytest.mark.parametrize(("force", "share"), [(np.zeros(6), 1.0), (PRESS, YIELDING_STIFFNESS)])
def test_with_a_desired_force_only_its_axis_yields(arm, force, share):
    controller = create(arm)
    for axis, stiffness in enumerate((2500.0, 2500.0, share * 2500.0)):
        displacement = 0.01 * np.eye(3)[axis]
        added = spring_force(arm, controller, displacement, force)
        np.testing.assert_allclose(added[:3], stiffness * displacement, atol=0.02 * 25.0)


@pytest.mark.parametrize(
    "directions", [[1.0, 2.0, -2.0], [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0]], [[0.0, 0.0, 2.0], [0.0, 0.0, -1.0]]]
)
def test_any_directions_of_the_world_can_yield(arm, directions):
    controller = create(arm, Impedance([2500.0, 1600.0, 900.0, 120.0, 120.0, 120.0]), force_directions=directions)
    given = np.atleast_2d(directions)
    projector = np.linalg.pinv(given) @ given
    root = np.diag([50.0, 40.0, 30.0])
    expected = root @ (np.eye(3) - (1.0 - YIELDING_STIFFNESS) * projector) @ root
    stiffness = [spring_force(arm, controller, 0.01 * axis, PRESS)[:3] / 0.01 for axis in np.eye(3)]
    np.testing.assert_allclose(stiffness, expected, atol=25.0)


@pytest.mark.parametrize("directions", [[0.0, 0.0, 0.0], [1.0, 2.0], [[np.nan, 0.0, 1.0]]])
def test_directions_that_are_zero_or_not_finite_are_rejected(arm, directions):
    with pytest.raises(ConfigurationError, match="force_directions"):
        create(arm, force_directions=directions)


def test_the_hand_presses_with_the_desired_force(arm):
    controller = create(arm)
    step(arm, controller, PRESS)
    torque = step(arm, controller, PRESS, time=1.0).command.torque
    np.testing.assert_allclose(force_of(arm, torque), PRESS, atol=0.1)


OWN = np.array([3.0, 0.0, -4.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("frame", ["world", "tool"])
def test_gains_with_a_desired_force_decide_how_hard_and_the_caller_decides_when(arm, frame):
    soft = Impedance(100.0, damping=[40.0] * 3 + [0.1] * 3, desired_force=OWN, frame=frame)
    controller = create(arm, soft, free=IMPEDANCE)
    axes = arm.update(HOME, np.zeros(7)).rotation if frame == "tool" else np.eye(3)
    np.testing.assert_allclose(force_of(arm, step(arm, controller, np.zeros(6)).command.torque), 0.0, atol=0.05)
    step(arm, controller, PRESS)
    pressing = force_of(arm, step(arm, controller, PRESS, time=1.0).command.torque)
    np.testing.assert_allclose(pressing[:3], axes @ OWN[:3], atol=0.1)
    added = spring_force(arm, controller, [0.0, 0.0, 0.01], PRESS)
    np.testing.assert_allclose(added[:3], [0.0, 0.0, 1.0], atol=0.05)
    added = spring_force(arm, controller, [0.0, 0.0, 0.01], np.zeros(6))
    np.testing.assert_allclose(added[:3], [0.0, 0.0, 25.0], atol=0.5)


def test_gains_with_a_desired_force_need_free_gains(arm):
    with pytest.raises(
        ConfigurationError, match="gains with a desired_force act only while a force is desired; give free gains"
    ):
        create(arm, Impedance(100.0, desired_force=OWN))
    with pytest.raises(ConfigurationError, match="free gains are used only beside gains with a desired_force"):
        create(arm, free=IMPEDANCE)


def switched(arm, force_ramp):
    """Return torques (n, 7) as a force is switched on and off, and the largest allowed change of the tool's force.

    The hand rests 3 mm below its reference, so that its springs are strained.
    """
    controller = create(arm, force_ramp=force_ramp)
    below = arm.update(HOME, np.zeros(7)).pose.moved([0.0, 0.0, 0.003])
    wanted = [PRESS if 0.1 <= 0.002 * tick < 0.4 else np.zeros(6) for tick in range(350)]
    torques = [step(arm, controller, force, below, 0.002 * tick).command.torque for tick, force in enumerate(wanted)]
    spring = (1.0 - YIELDING_STIFFNESS) * 2500.0 * 0.003
    return np.array(torques), 1.5 * 0.002 / RAMP_TIME * (5.0 + spring)


def test_a_force_is_switched_on_and_off_without_a_jump(arm):
    torques, bound = switched(arm, RAMP_TIME)
    forces = np.array([force_of(arm, torque)[2] for torque in torques])
    assert forces[0] == pytest.approx(7.5, abs=0.1)
    assert forces[190] == pytest.approx(-5.0 + 0.06 * 7.5, abs=0.1)
    assert forces[-1] == pytest.approx(7.5, abs=0.1)
    assert np.abs(np.diff(forces)).max() < 1.02 * bound
    # The bound also holds for joint torques, because no joint has a lever of more than a metre here.
    assert np.abs(np.diff(torques, axis=0)).max() < bound
    at_once, _ = switched(arm, 0.0)
    assert np.abs(np.diff(at_once, axis=0)).max() > 10.0 * bound


def test_a_force_changes_without_a_jump():
    force_ramp = ForceRamp(0.1)
    wanted = [PRESS] * 100 + [-2.0 * PRESS] * 150
    forces = np.array([force_ramp.update(0.002 * tick, force)[2] for tick, force in enumerate(wanted)])
    assert (forces[99], forces[-1]) == (-5.0, 10.0)
    assert np.abs(np.diff(forces)).max() < 2.5 * 0.002 / 0.1 * 10.0


def test_time_that_goes_backwards_starts_a_new_attempt():
    force_ramp, feedback = ForceRamp(0.1), ForceFeedback(5.0)
    for tick in range(200):
        force_ramp.update(0.002 * tick, PRESS)
        feedback.update(0.002 * tick, PRESS, -0.5 * PRESS)
    assert force_ramp.share == 1.0
    assert feedback.correction > 1.0
    force_ramp.update(0.0, PRESS)
    feedback.update(0.0, PRESS, -PRESS)
    assert (force_ramp.share, feedback.correction) == (0.0, 0.0)


def test_a_correction_stays_within_the_force_and_decays_without_contact():
    feedback = ForceFeedback(5.0)
    stuck = [feedback.update(0.002 * tick, PRESS, -0.2 * PRESS) for tick in range(1000)]
    np.testing.assert_allclose(stuck[-1], 2.0 * PRESS)
    for tick in range(1000, 2000):
        released = feedback.update(0.002 * tick, PRESS, np.zeros(6))
    np.testing.assert_allclose(released, PRESS, atol=1e-3)


def test_a_desired_force_that_is_not_finite_is_rejected(arm):
    with pytest.raises(ConfigurationError, match="desired_force must be six finite numbers"):
        step(arm, create(arm), np.full(6, np.nan))


def test_gains_whose_force_no_program_asks_for_are_rejected_before_the_simulation():
    gains = str(path("hands/shovel", "impedance.toml"))
    for settings in ({"hand": "rbo_hand2", "controller.kind": "impedance"}, {"hand": "shovel", "program": "line"}):
        with pytest.raises(ConfigurationError, match="desired_force has no effect, because"):
            prepare(load_scenario("push_wall", settings | {"controller.gains": gains}), seed=0)


def test_an_inertia_too_small_for_the_wrist_sensor_is_rejected_before_the_simulation(tmp_path):
    file = tmp_path / "light.toml"
    file.write_text("[impedance]\nstiffness = 30\ninertia = [0.01, 0.01, 0.01, 0.3, 0.3, 0.3]\n")
    with pytest.raises(ConfigurationError, match=r"inertia\[\d\] = 0.01 is too small for a wrench 21.9 ms late"):
        prepare(load_scenario("push_wall", {"hand": "shovel", "controller.gains": str(file)}), seed=0)


def test_a_wrench_can_be_moved_to_another_point():
    force, lever = np.array([1.0, 2.0, 3.0]), np.array([0.1, -0.2, 0.3])
    moved = move_wrench(np.concatenate((force, [0.5, 0.0, 0.0])), lever)
    np.testing.assert_allclose(moved, np.concatenate((force, np.cross(lever, force) + np.array([0.5, 0.0, 0.0]))))


def test_the_published_gains_of_the_shovel_push_to_the_grasp_force(tmp_path, monkeypatch):
    """They are far softer than the shipped ones: at the wall the reference goes on until its lead overcomes friction.

    The stalled hand builds up 17 N by the desired force and the dampers, which is just F_grasp. An arm that differs
    from its model needs some newtons more, and the spring has 20 N/m.
    """
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    gains = str(path("hands/shovel", "impedance.toml"))
    result = run("push_wall", record=True, overrides={"hand": "shovel", "controller.gains": gains})
    assert (result.success, result.outcomes[-1].trigger) == (True, "grasp force")
    error, turn = (np.max(result.recording.signals[name]) for name in ("tracking_error", "orientation_error"))
    print(f"the hand lags by {1e3 * error:.0f} mm and turns by {np.degrees(turn):.1f} degrees")
    assert error < 0.25


def test_the_desired_force_is_kept_while_sliding_along_a_stiff_table(arm):
    controller = create(arm)
    start = arm.update(HOME, np.zeros(7)).pose
    table, speed, stiffness, damping = start.translation[2], 0.05, 2e4, 200.0
    forces = []

    def contact(q, v):
        state = arm.update(q, v)
        force = max(0.0, stiffness * (table - state.translation[2]) - damping * state.twist[2])
        forces.append(force)
        return state.J.T @ [-0.3 * force, 0.0, force, 0.0, 0.0, 0.0]

    def torque(observation):
        reference = Reference(start.moved([speed * observation.time, 0.0, 0.0]), np.array([speed, 0, 0, 0, 0, 0.0]))
        state = arm.update(observation.q, observation.v)
        return controller.step(observation, reference, state, PRESS).command.torque

    for _ in simulate(arm, torque, HOME, 2.0, external=contact):
        pass
    settled = np.array(forces[len(forces) // 4 :])
    assert settled.mean() == pytest.approx(5.0, abs=0.25)
    assert settled.min() > 3.0


@pytest.fixture(scope="module")
def slide(tmp_path_factory):
    """Return the mean contact force (3,) of the shovel's push over the bare table, and the sensor's mean force (3,)."""
    contact_forces, read = [], []
    step, observe = mujoco.mj_step, Simulation.observe

    def step_and_record(model, data, steps=1):
        force = np.zeros(6)
        for _ in range(steps):
            step(model, data)
            total = np.zeros(3)
            for contact in range(data.ncon):
                mujoco.mj_contactForce(model, data, contact, force)
                total += data.contact.frame[contact].reshape(3, 3).T @ force[:3]
            contact_forces.append((data.time, *total))

    def read_wrench(self):
        observation = observe(self)
        read.append((observation.time, *observation.wrench[:3]))
        return observation

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        patch.setattr(mujoco, "mj_step", step_and_record)
        patch.setattr(Simulation, "observe", read_wrench)
        push = run("push_wall", overrides={"hand": "shovel"}).outcomes[1]
    sliding = (
        np.array([row for row in rows if push.start + 0.5 < row[0] < push.end - 0.1]) for rows in (contact_forces, read)
    )
    return [rows[:, 1:].mean(axis=0) for rows in sliding]


def test_the_shovel_presses_on_the_table_with_the_desired_force(slide):
    force, _ = slide
    assert force[2] == pytest.approx(5.0, abs=0.5)
    assert force[0] == pytest.approx(-0.5 * force[2], rel=0.1)


def test_the_wrist_sensor_s_mean_is_the_force_of_the_table(slide):
    force, wrench = slide
    np.testing.assert_allclose(wrench, force, atol=0.5)
