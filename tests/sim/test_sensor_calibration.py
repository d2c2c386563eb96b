"""Range, steps, offset, drift, tare and tool-mass error of the wrist sensor, in the engine and in whole attempts."""

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl import run
from pilegrasp_ctrl.config import SensorConfig, build_scenario, load_scenario
from pilegrasp_ctrl.primitives.primitive import Setpoint
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.simulation import Simulation
from pilegrasp_ctrl.sim.wrist_sensor import CALIBRATIONS, CHANNELS, WristSensor
from pilegrasp_ctrl.trajectories.straight_line import StraightLine

GRAVITY = 9.81
IDEAL = {"calibration": "SI-65-5", "force_noise": 0.0, "torque_noise": 0.0, "cutoff": 1e3, "bias": 0.0, "drift": 0.0}
TOOL_SIDE = 0.049
"""Height of the sensor's tool side over the flange [m]; the sensor measures there."""
UPRIGHT, LYING = (0.0, 0.0, 0.0), (0.0, np.pi / 2.0, 0.0)


class Bench:
    """The rigid shovel and its sensor on a flange that keeps its orientation."""

    def __init__(self, seed=0, turned=UPRIGHT, period=0.002, **config):
        self.hand = Hand.load("shovel")
        spec = mujoco.MjSpec()
        spec.compiler.degree = False
        mount = spec.worldbody.add_body(name="mount", mocap=True)
        self.hand.add_to(spec, mount.add_site(name="flange"))
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        config = SensorConfig(**(IDEAL | config))
        self.sensor = WristSensor(self.model, self.hand.mass_properties(), config, period, seed)
        self.turn(turned)

    def turn(self, rotation_vector):
        angle = float(np.linalg.norm(rotation_vector))
        axis = np.array(rotation_vector) / angle if angle else np.array([1.0, 0.0, 0.0])
        mujoco.mju_axisAngle2Quat(self.data.mocap_quat[0], axis, angle)
        mujoco.mj_forward(self.model, self.data)

    def read(self, force=(0, 0, 0), torque=(0, 0, 0)):
        """Return the reading under a force at the middle of the tool side and a torque, both in world axes."""
        face = self.data.site("wrist_sensor").xpos + TOOL_SIDE * self.axis
        body = self.model.body("sensor").id
        lever = face - self.data.xipos[body]
        self.data.xfrc_applied[body] = [*force, *(np.array(torque) + np.cross(lever, force))]
        mujoco.mj_forward(self.model, self.data)
        return self.sensor.read(self.data).copy()

    @property
    def axis(self):
        return self.data.site("wrist_sensor").xmat.reshape(3, 3)[:, 2]


# --- the table --------------------------------------------------------------------------------------------------------


def test_the_three_calibrations_are_those_of_the_vendor():
    assert list(CALIBRATIONS) == ["SI-32-2.5", "SI-65-5", "SI-130-10"]
    for name, calibration in CALIBRATIONS.items():
        assert name == f"SI-{calibration.range[0]:g}-{calibration.range[3]:g}" == calibration.name
        assert (calibration.range[:2] == calibration.range[0]).all()
        assert (calibration.range[3:] == calibration.range[3]).all()
        # A 16-bit reading: several thousand steps either way.
        assert (calibration.limits() > 2000).all()
        assert (calibration.limits() < 2**15).all()
    np.testing.assert_allclose(1.0 / CALIBRATIONS["SI-65-5"].resolution[:3], [80, 80, 40])


def test_noise_follows_the_calibration_unless_it_is_given():
    for name, calibration in CALIBRATIONS.items():
        config = SensorConfig(calibration=name)
        assert config.force_noise == pytest.approx(calibration.range[0] / 1300)
        assert config.torque_noise == pytest.approx(calibration.range[3] / 2500)
    assert (SensorConfig().force_noise, SensorConfig().torque_noise) == (0.1, 0.004)
    given = build_scenario({}, {"sensor.calibration": "SI-130-10", "sensor.force_noise": 0.0}).sensor
    assert (given.force_noise, given.torque_noise) == (0.0, 0.004)


# --- steps and range --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CALIBRATIONS)
@pytest.mark.parametrize("channel", range(6))
def test_a_channel_moves_in_whole_steps(name, channel):
    step = CALIBRATIONS[name].resolution[channel]
    bench = Bench(calibration=name)
    pushes = np.linspace(0.0, 6.0 * step, 61)
    readings = np.array([bench.read(*np.reshape(np.eye(6)[channel] * push, (2, 3))) for push in pushes])
    steps = (readings[:, channel] - readings[0, channel]) / step
    # A low-pass of 1 kHz still keeps 4e-6 of the reading before.
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-4)
    assert set(np.round(steps).astype(int)) in (set(range(6)), set(range(7)))
    np.testing.assert_allclose(steps, pushes / step, atol=1.0 + 1e-4)


@pytest.mark.parametrize("name", CALIBRATIONS)
@pytest.mark.parametrize("channel", range(6))
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_channel_beyond_its_range_is_reported_and_limited(name, channel, sign):
    end = CALIBRATIONS[name].range[channel]
    bench = Bench(calibration=name)
    weight = bench.hand.mass_properties().mass * GRAVITY
    slack = weight + 0.01 * end if channel < 3 else 0.2 * end
    below, above = (np.reshape(np.eye(6)[channel] * sign * load, (2, 3)) for load in (end - slack, end + slack))
    inside = bench.read(*below)
    assert bench.sensor.saturated is None
    assert inside[channel] == pytest.approx(sign * (end - slack), abs=CALIBRATIONS[name].resolution[channel])
    held = bench.read(*above)
    unit = "N" if channel < 3 else "N·m"
    assert bench.sensor.saturated == f"{CHANNELS[channel]} beyond {end:g} {unit} of {name}"
    assert abs(held[channel]) < abs(above).max()


def test_saturation_is_reported_until_the_next_tare():
    bench = Bench(calibration="SI-32-2.5")
    bench.read((40.0, 0.0, 0.0))
    bench.read((0.0, 40.0, 0.0))
    bench.read()
    assert bench.sensor.saturated == "Fx beyond 32 N of SI-32-2.5"
    bench.sensor.tare(bench.data)
    bench.read()
    assert bench.sensor.saturated is None


def test_the_tools_weight_uses_a_part_of_the_range():
    """On a level hand, Fx carries the tool: its range of 32 N is smaller downwards and larger upwards."""
    weight = Hand.load("shovel").mass_properties().mass * GRAVITY
    push = 32.0 - 0.5 * weight
    up, down = (Bench(turned=LYING, calibration="SI-32-2.5") for _ in range(2))
    up.read((0.0, 0.0, push))
    down.read((0.0, 0.0, -push))
    assert up.sensor.saturated is None
    assert down.sensor.saturated == "Fx beyond 32 N of SI-32-2.5"


def test_the_torque_range_counts_about_the_tool_side():
    """60 N through the flange's origin are 2.9 N·m about the tool side; the wrench is stated at the flange."""
    bench = Bench(calibration="SI-65-5")
    wrench = bench.read((60.0, 0.0, 0.0), (0.0, -TOOL_SIDE * 60.0, 0.0))
    np.testing.assert_allclose(wrench[3:], 0.0, atol=0.002)
    narrow = Bench(calibration="SI-65-5")
    narrow.read((60.0, 0.0, 0.0), (0.0, -5.2, 0.0))
    assert narrow.sensor.saturated == "Ty beyond 5 N·m of SI-65-5"


# --- offset, drift, tare, tool mass -----------------------------------------------------------------------------------

TILTS = [LYING, (np.pi, 0, 0), (np.pi / 2, 0, 0), (1.0, 0.5, -0.3), (-0.7, 1.9, 0.4)]


def test_the_offset_is_drawn_within_its_bounds_by_the_seed():
    span = CALIBRATIONS["SI-65-5"].range
    drawn = np.array([Bench(seed=seed, bias=0.02).read() - Bench(seed=seed).read() for seed in range(40)])
    # Torques are stated at the flange, which adds the lever of the lateral forces.
    assert (np.abs(drawn[:, :3]) <= 0.02 * span[:3] + 0.03).all()
    assert (np.abs(drawn[:, :3]).max(axis=0) > 0.016 * span[:3]).all()
    assert (np.ptp(drawn[:, 3:], axis=0) > 0.02 * span[3:]).all()
    np.testing.assert_array_equal(Bench(seed=3, bias=0.02).read(), Bench(seed=3, bias=0.02).read())
    assert len({*drawn[:, 0]}) > 30


@pytest.mark.parametrize("tilt", TILTS)
def test_the_tare_removes_the_offset_at_any_tilt(tilt):
    bench = Bench(seed=5, turned=(0.4, 1.1, -0.2), bias=0.02)
    assert np.abs(bench.read()).max() > 0.3
    bench.sensor.tare(bench.data)
    bench.turn(tilt)
    # The rounding of two readings remains.
    np.testing.assert_allclose(bench.read(), 0.0, atol=0.03)
    np.testing.assert_allclose(bench.read((3.0, -2.0, 1.0))[:3], [3.0, -2.0, 1.0], atol=0.03)


def test_the_drift_is_linear_in_time_and_continues_after_a_tare():
    bench, calm = Bench(seed=5, drift=0.05, period=0.02), Bench(seed=5, period=0.02)
    bench.sensor.tare(bench.data)
    calm.sensor.tare(calm.data)
    per_minute = round(60.0 / 0.02)
    readings = np.array([bench.read() for _ in range(per_minute)])
    half, full = readings[per_minute // 2, :3], readings[-1, :3]
    span = CALIBRATIONS["SI-65-5"].range[:3]
    assert (np.abs(full) <= 0.05 * span + 0.03).all()
    assert np.abs(full).max() > 0.3
    np.testing.assert_allclose(half, full / 2.0, atol=0.03)
    np.testing.assert_allclose([calm.read() for _ in range(100)], 0.0, atol=1e-9)
    bench.sensor.tare(bench.data)
    np.testing.assert_allclose(bench.read()[:3], 0.0, atol=0.03)


def test_the_noise_is_the_same_with_and_without_an_offset():
    noisy = {"force_noise": 0.5, "torque_noise": 0.0}
    plain, biased = (Bench(seed=2, bias=bias, **noisy) for bias in (0.0, 0.02))
    apart = np.array([biased.read() - plain.read() for _ in range(600)])[:, 0]
    assert np.ptp(apart) <= CALIBRATIONS["SI-65-5"].resolution[0] + 1e-9


@pytest.mark.parametrize("error", [-0.1, 0.05])
def test_a_wrong_tool_mass_reads_as_weight_and_the_tare_removes_it_at_one_tilt_only(error):
    bench = Bench(tool_mass_error=error)
    weight = bench.hand.mass_properties().mass * GRAVITY
    np.testing.assert_allclose(bench.read()[:3], [0.0, 0.0, error * weight], atol=0.03)
    bench.sensor.tare(bench.data)
    np.testing.assert_allclose(bench.read()[:3], 0.0, atol=0.03)
    bench.turn((np.pi, 0.0, 0.0))
    np.testing.assert_allclose(bench.read()[:3], [0.0, 0.0, 2.0 * error * weight], atol=0.03)


# --- attempts ---------------------------------------------------------------------------------------------------------


@pytest.fixture(autouse=True, scope="module")
def own_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


PUSHES = [(17.0, 0.0, 0.0), (0.0, -17.0, 0.0), (-10.0, 8.0, -12.0)]


@pytest.fixture(scope="module", params=["shovel", "rbo_hand2"])
def readings_in_motion(request):
    """Readings of the pushes while the arm moves along a line, with all the sensor's faults, after the tare at rest."""
    attempt = prepare(load_scenario("free_space_line", {"hand": request.param, "sensor.bias": 0.03}), seed=1)
    simulation, arm, plan = attempt.simulation, attempt.arm, attempt.plan
    path = StraightLine(plan.start, np.array([0.0, 0.3, 0.0]), 0.1)
    hand, readings, speeds = simulation.scene.model.body("sensor").id, [], []

    def tick(setpoint):
        observation = simulation.observe()
        state = arm.update(observation.q, observation.v)
        simulation.apply(attempt.control(observation, setpoint, state).command.torque, plan.closure)
        simulation.step()
        return observation, state

    for _ in range(500):
        tick(Setpoint(path.at(0.0), plan.closure))
    simulation.tare()
    for count in range(round(path.duration / attempt.period)):
        time = count * attempt.period
        which, since = divmod(time, 0.8)
        push = PUSHES[min(int(which), 2)]
        simulation.data.xfrc_applied[hand, :3] = push
        observation, state = tick(Setpoint(path.at(time), plan.closure))
        if since > 0.5 and which < 3:
            readings.append((int(which), observation.wrench[:3].copy()))
            speeds.append(np.linalg.norm(state.twist[:3]))
    assert not observation.saturated
    assert min(speeds) > 0.05
    return [np.mean([wrench for which, wrench in readings if which == index], axis=0) for index in range(3)]


@pytest.mark.slow
@pytest.mark.parametrize("index", range(3))
def test_a_known_push_is_read_within_two_percent_while_the_arm_moves(readings_in_motion, index):
    error = readings_in_motion[index] - PUSHES[index]
    assert np.linalg.norm(error) < 0.02 * np.linalg.norm(PUSHES[index])


def press(calibration):
    settings = {"hand": "shovel", "strategy.grasp_force": 45.0, "sensor.calibration": calibration}
    return run("push_wall", overrides=settings, record=True)


def test_a_saturated_sensor_ends_the_primitive_as_failed_and_is_recorded():
    result = press("SI-32-2.5")
    push = result.outcomes[-1]
    assert (push.name, push.status) == ("push", "failed")
    assert push.trigger == "wrist sensor saturated: Ty beyond 2.5 N·m of SI-32-2.5"
    assert not result.success
    assert result.reason == f"push: {push.trigger}"
    flags = result.recording.signals["sensor_saturated"]
    assert flags[-1] == 1.0
    assert not flags[:-1].any()


def test_a_wider_calibration_completes_the_same_push():
    result = press("SI-65-5")
    assert [outcome.trigger for outcome in result.outcomes] == ["surface contact", "grasp force"]
    assert not result.recording.signals["sensor_saturated"].any()


def test_an_attempt_begins_with_a_tared_sensor():
    result = run("free_space_line", overrides={"sensor.bias": 0.1}, record=True)
    assert np.abs(result.recording.signals["wrench"][:, :3]).max() < 1.0


def test_an_impact_before_the_start_fails_the_first_primitive(monkeypatch):
    """The tare clears the sensor's saturation, but its zero is wrong."""
    step = Simulation.step

    def struck(simulation):
        hand = simulation.scene.model.body("sensor").id
        simulation.data.xfrc_applied[hand, 0] = 300.0 if 0.1 < simulation.data.time < 0.11 else 0.0
        step(simulation)

    monkeypatch.setattr(Simulation, "step", struck)
    result = run("push_wall", overrides={"sensor.calibration": "SI-32-2.5"}, record=True)
    assert [(outcome.name, outcome.status) for outcome in result.outcomes] == [("approach", "failed")]
    assert result.outcomes[0].trigger.startswith("wrist sensor saturated: ")
    assert not result.recording.signals["sensor_saturated"].any()
