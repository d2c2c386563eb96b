"""Sign, frame, tool weight, low-pass and noise of the wrist sensor."""

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.sections import SensorConfig
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.wrist_sensor import WristSensor

GRAVITY = 9.81
SILENT = SensorConfig(force_noise=0.0, torque_noise=0.0, cutoff=1e3, bias=0.0, drift=0.0)


def mounted(hand_name, rotation_vector, payload=0.0):
    """A hand on a fixed flange in any orientation; the payload is a point mass 0.12 m along the flange axis."""
    hand = Hand.load(hand_name)
    spec = mujoco.MjSpec()
    angle = float(np.linalg.norm(rotation_vector))
    quaternion = np.zeros(4)
    mujoco.mju_axisAngle2Quat(quaternion, np.array(rotation_vector) / max(angle, 1e-12), angle)
    flange = spec.worldbody.add_site(name="flange", pos=[0.1, 0.2, 1.0], quat=quaternion)
    spec.compiler.degree = False
    hand.add_to(spec, flange)
    if payload:
        spec.body("sensor").add_geom(
            name="payload", size=[0.001, 0, 0], pos=[0, 0, 0.12], mass=payload, contype=0, conaffinity=0
        )
    return hand, spec.compile()


def settled_reading(hand, model, config=SILENT, push=None):
    sensor = WristSensor(model, hand.mass_properties(), config, 0.002, seed=0)
    data = mujoco.MjData(model)
    if push is not None:
        data.xfrc_applied[model.body("sensor").id, :3] = push
    for _ in range(3000):
        mujoco.mj_step(model, data)
    return sensor.read(data), data


TILTS = [
    [0, 0, 0], [np.pi, 0, 0], [np.pi / 2, 0, 0], [0, np.pi / 2, 0], [-np.pi / 2, 0, 0],
    [0, -np.pi / 2, 0], [1.0, 0.5, -0.3], [-0.7, 1.9, 0.4], [0.2, -2.2, 0.9], [2.5, 0.1, 1.0],
]  # fmt: skip


@pytest.mark.parametrize("hand_name", ["rbo_hand2", "shovel"])
@pytest.mark.parametrize("tilt", TILTS)
def test_one_kilogram_reads_its_weight_at_any_tilt(hand_name, tilt):
    hand, model = mounted(hand_name, tilt, payload=1.0)
    wrench, data = settled_reading(hand, model)
    np.testing.assert_allclose(wrench[:3], [0.0, 0.0, -GRAVITY], atol=0.01 * GRAVITY)
    arm = data.site("flange").xmat.reshape(3, 3) @ [0.0, 0.0, 0.12]
    # Soft fingers sag, which moves the hand's centre of mass by a few millimetres.
    np.testing.assert_allclose(wrench[3:], np.cross(arm, [0.0, 0.0, -GRAVITY]), atol=0.02)


@pytest.mark.parametrize("hand_name", ["rbo_hand2", "shovel"])
def test_an_empty_hand_reads_zero(hand_name):
    hand, model = mounted(hand_name, [0.4, 1.1, -0.2])
    wrench, _ = settled_reading(hand, model)
    np.testing.assert_allclose(wrench[:3], 0.0, atol=0.03)


def test_a_push_is_read_as_the_force_on_the_hand():
    hand, model = mounted("shovel", [0.3, 0.2, 0.1])
    wrench, _ = settled_reading(hand, model, push=[-17.0, 2.0, 1.8])
    np.testing.assert_allclose(wrench[:3], [-17.0, 2.0, 1.8], atol=0.05)


def test_low_pass_reaches_63_percent_after_its_time_constant():
    hand, model = mounted("shovel", [0, 0, 0])
    period, cutoff = 0.002, 8.0
    sensor = WristSensor(
        model, hand.mass_properties(), SensorConfig(force_noise=0, torque_noise=0, cutoff=cutoff), period, 0
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    start = sensor.read(data)[2]
    data.xfrc_applied[model.body("sensor").id, 2] = 10.0
    mujoco.mj_forward(model, data)
    samples = round(1.0 / (2.0 * np.pi * cutoff) / period)
    for _ in range(samples):
        reading = sensor.read(data)[2]
    assert (reading - start) / 10.0 == pytest.approx(1.0 - np.exp(-1.0), abs=0.03)


def test_noise_has_the_stated_deviation_and_follows_the_seed():
    hand, model = mounted("shovel", [0, 0, 0])
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    config = SILENT.model_copy(update={"force_noise": 0.3, "torque_noise": 0.01})

    def samples(seed):
        sensor = WristSensor(model, hand.mass_properties(), config, 0.002, seed)
        return np.array([sensor.read(data) for _ in range(2000)])

    first = samples(1)
    np.testing.assert_allclose(first[:, :3].std(axis=0), 0.3, rtol=0.1)
    # Forces and torques are measured on the sensor's tool side, 49 mm from the point of the wrench.
    bent = np.hypot(0.01, 0.049 * 0.3)
    np.testing.assert_allclose(first[:, 3:].std(axis=0), [bent, bent, 0.01], rtol=0.1)
    np.testing.assert_array_equal(first, samples(1))
    assert np.abs(first - samples(2)).max() > 0.1
