"""The simulated arm obeys mechanics: energy, joint friction, contact, payload and sensor noise."""

import numpy as np
import pinocchio as pin
import pytest

from arms import ARMS, HOME, load, random_states, without_friction
from pilegrasp_ctrl import ArmModel, ArmSimulation, Impedance, ImpedanceController
from pilegrasp_ctrl.exceptions import ConfigurationError, PilegraspError, SimulationError
from pilegrasp_ctrl.plant.sensor_noise import SensorNoise
from pilegrasp_ctrl.robots import description
from pilegrasp_ctrl.types import Reference
from spring_wall import SpringWall


@pytest.fixture(params=ARMS)
def arm(request):
    return load(request.param)


@pytest.fixture
def free(arm):
    return without_friction(arm.name)


def flywheel(inertia=0.5, coulomb=0.0, viscous=0.0):
    """Return an arm of one vertical joint, whose motion under friction is known."""
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "joint")
    model.appendBodyToJoint(joint, pin.Inertia(1.0, np.zeros(3), inertia * np.eye(3)), pin.SE3.Identity())
    model.addFrame(pin.Frame("tool", joint, pin.SE3(np.eye(3), np.array([1.0, 0.0, 0.0])), pin.FrameType.OP_FRAME))
    limits = {"q_lower": [-99.0], "q_upper": [99.0], "velocity_limit": [99.0], "torque_limit": [99.0]}
    return ArmModel(model, "tool", friction_coulomb=[coulomb], friction_viscous=[viscous], **limits)


def samples(simulation, torque, q, duration, **options):
    return list(simulation.run(torque if callable(torque) else lambda _: torque, q, duration, **options))


def energy(arm, sample):
    model = arm.pinocchio_model
    data = model.createData()
    potential = pin.computePotentialEnergy(model, data, sample.q)
    return potential + 0.5 * sample.v @ arm.update(sample.q, sample.v).M @ sample.v


def test_without_friction_and_torque_the_energy_error_falls_with_finer_steps(free):
    """The arm falls freely. Over a given time, the error of the midpoint rule is of second order or better."""
    drifts = []
    for substeps in (1, 2, 4):
        fall = samples(ArmSimulation(free, substeps=substeps), np.zeros(7), HOME[free.name], 1.0, rate=100.0)
        motion = max(0.5 * s.v @ free.update(s.q, s.v).M @ s.v for s in fall)
        energies = np.array([energy(free, sample) for sample in fall])
        drifts.append(np.abs(energies - energies[0]).max() / motion)
    assert drifts[2] < 1e-3
    assert drifts[1] < 0.3 * drifts[0]
    assert drifts[2] < 0.3 * drifts[1]


def test_friction_only_dissipates_energy():
    arm = load("wam7")
    fall = samples(ArmSimulation(arm), np.zeros(7), HOME["wam7"], 0.5)
    energies = [energy(arm, sample) for sample in fall]
    assert (np.diff(energies) < 1e-4).all()
    assert energies[-1] < energies[0] - 0.1


def test_joints_stick_below_the_coulomb_torque_and_slip_above():
    arm, q = load("wam7"), HOME["wam7"]
    h = arm.update(q, np.zeros(7)).h
    signs = np.array([1, -1, 1, 1, -1, 1, -1])
    stuck = samples(ArmSimulation(arm), h + 0.95 * signs * arm.friction_coulomb, q, 1.0)[-1]
    np.testing.assert_array_equal(stuck.q, q)
    np.testing.assert_array_equal(stuck.v, np.zeros(7))
    slipping = samples(ArmSimulation(arm), h + 1.05 * signs * arm.friction_coulomb, q, 0.1)[-1]
    assert (slipping.v * signs > 0.0).all()


def test_one_joint_slips_while_the_others_stick():
    arm, q = load("wam7"), HOME["wam7"]
    push = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.2 * arm.friction_coulomb[6]])
    last = samples(ArmSimulation(arm), arm.update(q, np.zeros(7)).h + push, q, 0.05)[-1]
    np.testing.assert_array_equal(last.q[:6], q[:6])
    assert last.q[6] > q[6] + 1e-3


def test_friction_holds_a_joint_or_opposes_it_with_the_full_coulomb_torque():
    """The friction's conditions hold at random states, in which some joints stick and others slip."""
    arm, rng, step, held = load("wam7"), np.random.default_rng(3), 1e-3, 0
    friction = ArmSimulation(arm).friction
    for q, v in random_states(arm, 50):
        M, v_free = arm.update(q, v).M, v * rng.uniform(0.0, 1.0) * 0.1
        v_end, f = friction.apply(M, v, v_free, step)
        momentum = M @ (v_end - v_free) + 0.5 * step * friction.viscous * (v + v_end)
        np.testing.assert_allclose(momentum, step * f, atol=1e-9)
        assert (np.abs(f) <= friction.coulomb * (1.0 + 1e-9)).all()
        np.testing.assert_allclose(f[v_end != 0.0], -(np.sign(v_end) * friction.coulomb)[v_end != 0.0], rtol=1e-6)
        held += int((v_end == 0.0).sum())
    assert 20 < held < 330


def test_a_joint_under_coulomb_friction_decelerates_uniformly_and_then_rests():
    speed, inertia, coulomb = 1.0, 0.5, 2.0
    arm = flywheel(inertia, coulomb)
    run = samples(ArmSimulation(arm), np.zeros(1), [0.0], 0.5, v=[speed])
    time, q, v = (np.array([getattr(s, name) for s in run]).squeeze() for name in ("time", "q", "v"))
    stop = speed * inertia / coulomb
    np.testing.assert_allclose(v, np.maximum(0.0, speed - coulomb / inertia * time), atol=5e-3)
    assert q[-1] == pytest.approx(0.5 * speed * stop, abs=1e-5)
    assert not v[time > stop + 1e-3].any()


def test_motion_decays_under_viscous_friction_even_a_very_large_one():
    last = samples(ArmSimulation(flywheel(0.5, viscous=2.0)), np.zeros(1), [0.0], 0.502, v=[1.0])[-1]
    assert last.v[0] == pytest.approx(np.exp(-2.0 / 0.5 * 0.5), rel=1e-4)
    stiff = samples(ArmSimulation(flywheel(1e-4, viscous=10.0)), np.zeros(1), [0.0], 0.5, v=[1.0])
    assert max(abs(s.v[0]) for s in stiff) <= 1.0


def test_a_wall_pushes_with_stiffness_times_depth_and_balances_the_controller_s_spring(free):
    """Two springs are in series: the depth is spring / (spring + wall) times the depth of the reference."""
    start = free.update(HOME[free.name], np.zeros(7)).pose
    spring, stiffness, inside = 400.0, 4000.0, 0.04
    wall = SpringWall(start.moved([0.01, 0.0, 0.0]).translation, [-2.0, 0.0, 0.0], stiffness, damping=30.0)
    controller = ImpedanceController(free, Impedance([spring] * 3 + [30.0] * 3), HOME[free.name])
    reference = Reference(start.moved([0.01 + inside, 0.0, 0.0]))
    simulation = ArmSimulation(free, environment=wall)
    last = samples(simulation, lambda o: controller.step(o, reference).command.torque, HOME[free.name], 1.5)[-1]
    depth = free.update(last.q, last.v).translation[0] - start.translation[0] - 0.01
    assert depth == pytest.approx(inside * spring / (spring + stiffness), rel=0.02)
    np.testing.assert_allclose(last.wrench, [-stiffness * depth, 0, 0, 0, 0, 0], atol=0.02)


def test_a_wall_exerts_no_force_outside_and_never_pulls():
    wall = SpringWall([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 1000.0, damping=50.0)
    start = load("panda").update(HOME["panda"], np.zeros(7)).pose
    above, below = (start.moved([0.0, 0.0, height - start.translation[2]]) for height in (0.001, -0.001))
    away = np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    assert not wall(above, -away).any()
    assert not wall(below, away).any()
    np.testing.assert_allclose(wall(below, -0.1 * away), [0, 0, 1.0 + 5.0, 0, 0, 0])


def test_the_controller_observes_the_wrench_of_the_environment(free):
    seen = []
    push = np.array([1.0, 2.0, 3.0, 0.1, 0.2, 0.3])
    simulation = ArmSimulation(free, environment=lambda pose, twist: push)
    samples(simulation, lambda o: seen.append(o.wrench) or np.zeros(7), HOME[free.name], 0.01)
    np.testing.assert_array_equal(seen, [push] * 5)


def test_a_wrench_on_the_tool_acts_on_the_joints_through_the_transposed_jacobian(free):
    state = free.update(HOME[free.name], np.zeros(7))
    push = np.array([5.0, -3.0, 8.0, 0.5, 0.2, -0.4])
    simulation = ArmSimulation(free, environment=lambda pose, twist: push)
    still = samples(simulation, state.h - state.J.T @ push, HOME[free.name], 0.1)[-1]
    np.testing.assert_allclose(still.q, HOME[free.name], atol=1e-6)


@pytest.mark.parametrize("factor", [0.9, 1.1])
def test_a_heavier_arm_needs_proportionally_more_torque_to_rest(free, factor):
    h, q = free.update(HOME[free.name], np.zeros(7)).h, HOME[free.name]
    held = samples(ArmSimulation(free, mass_factor=factor), factor * h, q, 0.2)[-1]
    np.testing.assert_allclose(held.q, q, atol=1e-9)
    assert np.abs(samples(ArmSimulation(free, mass_factor=factor), h, q, 0.2)[-1].q - q).max() > 1e-3
    plant = ArmSimulation(free, mass_factor=factor).plant.update(q, np.zeros(7))
    drives = np.diag(free.pinocchio_model.armature)
    np.testing.assert_allclose(plant.M - drives, factor * (free.update(q, np.zeros(7)).M - drives), atol=1e-9)


def test_a_payload_acts_at_the_tool_s_origin(free):
    state, q = free.update(HOME[free.name], np.zeros(7)), HOME[free.name]
    weight = np.array([0.0, 0.0, 0.5 * 9.81, 0.0, 0.0, 0.0])
    held = samples(ArmSimulation(free, payload=0.5), state.h + state.J.T @ weight, q, 0.2)[-1]
    np.testing.assert_allclose(held.q, q, atol=1e-9)


def observed(noise, seed, ticks=400):
    arm, seen = flywheel(), []
    simulation = ArmSimulation(arm, noise=noise, seed=seed)
    samples(simulation, lambda o: seen.append((o.q[0], o.v[0])) or np.zeros(1), [0.3], ticks / 500.0)
    return np.array(seen)


def test_noise_has_the_requested_size_and_repeats_with_its_seed():
    noise = SensorNoise(1e-4, 2e-2)
    first = observed(noise, 7)
    np.testing.assert_array_equal(first, observed(noise, 7))
    assert (first != observed(noise, 8)).all()
    np.testing.assert_allclose(first.std(axis=0), [1e-4, 2e-2], rtol=0.1)
    np.testing.assert_allclose(first.mean(axis=0), [0.3, 0.0], atol=5e-3)
    assert (observed(None, 7) == [0.3, 0.0]).all()


def test_noise_affects_observations_and_not_the_motion():
    simulation = ArmSimulation(flywheel(), noise=SensorNoise(1e-2, 1e-1))
    assert all(sample.q[0] == 0.3 for sample in samples(simulation, np.zeros(1), [0.3], 0.1))


def test_encoder_noise_is_that_of_differences_of_rounded_motor_angles():
    """The comparison rounds two readings one period apart in many postures, for joints that share motors."""
    matrix = np.array(description("wam7")["transmission"]["joint_to_motor"])
    rate, count = 500.0, 2.0 * np.pi / 4096
    rng = np.random.default_rng(0)
    q = rng.uniform(-1.0, 1.0, (20000, 7))
    later = q + rng.uniform(-1.0, 1.0, (20000, 7)) / rate

    def read(joints):
        return np.linalg.solve(matrix, count * np.round(joints @ matrix.T / count).T).T

    noise = SensorNoise.of_encoders(matrix, rate=rate)
    np.testing.assert_allclose(noise.position, (read(q) - q).std(axis=0), rtol=0.03)
    np.testing.assert_allclose(noise.velocity, (rate * (read(later) - read(q) - later + q)).std(axis=0), rtol=0.03)


def test_a_run_remembers_nothing(arm):
    simulation = ArmSimulation(arm, noise=SensorNoise(1e-4, 1e-2))
    torque = 0.3 * arm.torque_limit
    first, second = (samples(simulation, torque, HOME[arm.name], 0.05)[-1] for _ in range(2))
    np.testing.assert_array_equal(first.q, second.q)


def test_a_diverging_simulation_raises_an_error_with_a_remedy(free):
    start = free.update(HOME[free.name], np.zeros(7)).pose.moved([0.0, 0.0, 0.01])
    simulation = ArmSimulation(free, environment=SpringWall(start.translation, [0.0, 0.0, 1.0], 1e9))
    with pytest.raises(SimulationError, match=r"diverged at .* raise one of these"):
        samples(simulation, np.zeros(7), HOME[free.name], 1.0)


def test_an_arm_that_is_advanced_period_by_period_moves_as_in_a_run(arm):
    simulation = ArmSimulation(arm, noise=SensorNoise(1e-4, 1e-2), payload=0.5)
    run, moving = samples(simulation, pull, HOME[arm.name], 0.1), simulation.start(HOME[arm.name])
    for sample in run:
        observation = moving.observe()
        assert observation.time == sample.time
        np.testing.assert_array_equal([moving.q, moving.v], [sample.q, sample.v])
        moving.apply(pull(observation))
        moving.step()


def pull(observation):
    return -2.0 * observation.q


def test_a_command_holds_until_the_next_and_is_copied(free):
    one, other = (ArmSimulation(free).start(HOME[free.name]) for _ in range(2))
    torque = free.update(HOME[free.name], np.zeros(7)).h + 1.0
    one.apply(torque.copy())
    for _ in range(3):
        other.apply(torque.copy())
        one.step()
        other.step()
    np.testing.assert_array_equal(one.q, other.q)
    one.apply(torque)
    torque[:] = 0.0
    one.step()
    other.step()
    np.testing.assert_array_equal(one.q, other.q)


def test_a_tare_takes_the_last_wrench_as_zero(free):
    weight = np.array([0.0, 0.0, -5.0, 0.0, 0.0, 0.0])
    arm = ArmSimulation(free, environment=lambda pose, twist: weight).start(HOME[free.name])
    np.testing.assert_array_equal(arm.observe().wrench, weight)
    arm.tare()
    np.testing.assert_array_equal(arm.observe().wrench, 0.0)
    arm.tare()
    np.testing.assert_array_equal(arm.observe().wrench, 0.0)


@pytest.mark.parametrize("coulomb", [0.0, 1.0])
def test_a_torque_of_nan_raises_an_error(coulomb):
    with pytest.raises(SimulationError):
        samples(ArmSimulation(flywheel(coulomb=coulomb)), np.full(1, np.nan), [0.0], 0.1)


def test_a_wrench_of_another_shape_is_rejected(free):
    with pytest.raises(ConfigurationError, match="six numbers"):
        samples(ArmSimulation(free, environment=lambda pose, twist: np.zeros(3)), np.zeros(7), HOME[free.name], 0.1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"substeps": 0}, "substeps = 0"),
        ({"mass_factor": 0.0}, "mass_factor = 0"),
        ({"payload": -1.0}, "payload = -1"),
        ({"friction_coulomb": -0.1}, "friction_coulomb"),
        ({"friction_viscous": [0.1, 0.2]}, "friction_viscous"),
        ({"noise": SensorNoise([1e-4, 1e-4], 0.0)}, "number of joints"),
    ],
)
def test_a_plant_that_cannot_be_built_is_rejected(arguments, message):
    with pytest.raises(ConfigurationError, match=message):
        ArmSimulation(load("panda"), **arguments)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: SensorNoise(-1e-4, 0.0), "noise of position"),
        (lambda: SensorNoise(0.0, np.nan), "noise of velocity"),
        (lambda: SensorNoise.of_encoders([42.0], counts=0.0), "counts = 0"),
        (lambda: SensorNoise.of_encoders(np.zeros((2, 2))), "no inverse"),
        (lambda: SpringWall([0.0, 0.0], [0.0, 0.0, 1.0], 1.0), "three numbers"),
        (lambda: SpringWall([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], 1.0), "not zero"),
        (lambda: SpringWall([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.0), "positive stiffness"),
        (lambda: ArmSimulation(flywheel()).run(lambda o: 0.0, [0.0, 0.0], 1.0), "1 finite start positions"),
        (lambda: ArmSimulation(flywheel()).run(lambda o: 0.0, [0.0], 0.0), "duration = 0"),
        (lambda: ArmSimulation(flywheel()).run(lambda o: 0.0, [0.0], 1e-4), "hold at least one period"),
        (lambda: ArmSimulation(flywheel()).start([0.0], rate=0.0), "rate = 0"),
        (lambda: ArmSimulation(flywheel()).start([0.0]).apply([1.0, 2.0]), r"torque has shape \(2,\); \(1,\)"),
    ],
)
def test_values_that_cannot_be_used_are_rejected(make, message):
    with pytest.raises(PilegraspError, match=message):
        make()


def test_a_simulation_prints_on_one_line():
    assert repr(ArmSimulation(load("panda"))) == "ArmSimulation('panda', nv=7, substeps=2)"
    moving = ArmSimulation(load("panda")).start(HOME["panda"])
    moving.step()
    assert repr(moving) == "ArmBackend('panda', rate=500, time=0.002)"
