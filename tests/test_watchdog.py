"""What stops a simulation, what does not, and what it leaves behind."""

import tempfile

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.exceptions import SimulationError
from pilegrasp_ctrl.sim.watchdog import DEEPEST, SATURATION_TIME, Watchdog

LIMIT = np.array([10.0, 2.0])


@pytest.fixture
def last_states(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def ball_on_a_table():
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 0.1])
    body = spec.worldbody.add_body(name="ball")
    body.add_freejoint()
    body.add_geom(name="ball", size=[0.027, 0, 0], mass=0.06)
    return mujoco.MjData(spec.compile())


def at_height(data, height):
    data.time, data.qpos[2] = 0.5, 0.027 + height
    mujoco.mj_forward(data.model, data)
    return data


def stop(watchdog, data, torque, match):
    """Let the watchdog stop the simulation, and return what it says."""
    with pytest.raises(SimulationError, match=match) as error:
        watchdog.check(data, torque)
    assert "\n" not in str(error.value)
    return str(error.value)


def load(folder, text):
    """Return the last states from the file that the text names."""
    (file,) = folder.iterdir()
    assert str(file) in text
    with np.load(file, allow_pickle=False) as states:
        return {name: states[name] for name in states.files}


def test_a_healthy_run_is_left_alone(last_states):
    data = at_height(ball_on_a_table(), 0.05)
    watchdog = Watchdog(LIMIT, "healthy")
    for _ in range(1000):
        mujoco.mj_step(data.model, data)
        watchdog.check(data, 0.99 * LIMIT)
    assert data.ncon > 0
    assert list(last_states.iterdir()) == []


def test_a_state_that_is_not_finite_stops_the_run_and_leaves_the_last_states(last_states):
    data = at_height(ball_on_a_table(), 0.05)
    watchdog = Watchdog(LIMIT, "abc-7")
    for _ in range(3000):
        mujoco.mj_step(data.model, data)
        watchdog.check(data, 0.0 * LIMIT)
    data.time += 0.1
    data.qvel[1] = np.nan
    text = stop(watchdog, data, 0.0 * LIMIT, match="not finite")
    states = load(last_states, text)
    assert "abc-7" in text
    assert f"{data.time:.3f} s" in text
    assert len(states["time"]) == len(states["qpos"]) == len(states["qvel"]) == len(states["ctrl"]) == 100
    assert states["time"][-1] == data.time
    assert (np.diff(states["time"]) > 0.0).all()
    assert np.isnan(states["qvel"][-1, 1])
    assert np.isfinite(states["qvel"][:-1]).all()


def test_a_torque_that_is_not_finite_stops_the_run(last_states):
    stop(Watchdog(LIMIT, "torque"), at_height(ball_on_a_table(), 0.05), np.array([0.0, np.inf]), match="not finite")


@pytest.mark.parametrize(("depth", "stops"), [(0.5 * DEEPEST, False), (0.95 * DEEPEST, False), (1.05 * DEEPEST, True)])
def test_a_contact_too_deep_to_be_one_stops_the_run(last_states, depth, stops):
    data = at_height(ball_on_a_table(), -depth)
    watchdog = Watchdog(LIMIT, "deep")
    if not stops:
        watchdog.check(data, 0.0 * LIMIT)
        return
    text = stop(watchdog, data, 0.0 * LIMIT, match="ball")
    assert "table" in text
    assert f"{1000 * depth:.1f} mm" in text
    np.testing.assert_array_equal(load(last_states, text)["qpos"], [data.qpos])


def saturate(period, pattern, duration=3.0):
    """Return when the watchdog stops a run whose torque is `pattern(time)` of the limits, or None."""
    data = at_height(ball_on_a_table(), 0.5)
    watchdog = Watchdog(LIMIT, "torque")
    while data.time < duration:
        try:
            watchdog.check(data, pattern(data.time) * LIMIT)
        except SimulationError as error:
            return data.time, str(error)
        # As MuJoCo does: a step at a time, rounding included.
        for _ in range(round(period / 0.001)):
            data.time += 0.001
    return None


@pytest.mark.parametrize("period", [0.001, 0.002, 0.01])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_joint_that_stays_at_its_torque_limit_stops_the_run(last_states, period, sign):
    time, text = saturate(period, lambda time: np.array([0.2, sign if time > 1.0 else 0.5]))
    assert time - 1.0 == pytest.approx(SATURATION_TIME, rel=0.25)
    assert "joint 2" in text
    assert "2.0 N·m" in text
    assert load(last_states, text)["time"][-1] == time


def test_a_torque_limit_that_is_reached_now_and_then_is_no_reason_to_stop(last_states):
    assert saturate(0.002, lambda time: np.array([1.0, 0.0]) if time % 1.0 < 0.9 else 0.9 * np.ones(2)) is None
    assert saturate(0.002, lambda _: 0.99 * np.ones(2)) is None
    assert list(last_states.iterdir()) == []
