"""The watchdog: states that stop a simulation, and the file of the last states."""

import tempfile

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import SimulationError
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sections import PileConfig
from pilegrasp_ctrl.sim.monitors import KINDS, MAX_DROP_PENETRATION, MAX_PENETRATION, Watchdog, kinds_of
from pilegrasp_ctrl.sim.objects import objects_of
from pilegrasp_ctrl.sim.scene import add_objects, new_spec

ON_SUPPORT = MAX_PENETRATION["object", "support"]


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
    site = body.add_site(name="center")
    spec.add_actuator(name="push", target=site.name, trntype=mujoco.mjtTrn.mjTRN_SITE)
    return mujoco.MjData(spec.compile())


def at_height(data, height):
    data.time, data.qpos[2] = 0.5, 0.027 + height
    mujoco.mj_forward(data.model, data)
    return data


def stop(watchdog, data, match):
    """Let the watchdog stop the simulation, and return the error text."""
    with pytest.raises(SimulationError, match=match) as error:
        watchdog.check(data)
    assert "\n" not in str(error.value)
    return str(error.value)


def load(folder, text):
    """Return the last states from the file that the text names."""
    (file,) = folder.iterdir()
    assert str(file) in text
    with np.load(file, allow_pickle=False) as states:
        return {name: states[name] for name in states.files}


def test_a_healthy_run_is_not_stopped(last_states):
    data = at_height(ball_on_a_table(), 0.02)
    watchdog = Watchdog("healthy")
    for _ in range(1000):
        mujoco.mj_step(data.model, data)
        watchdog.check(data)
    assert data.ncon > 0
    assert list(last_states.iterdir()) == []


def test_a_state_that_is_not_finite_stops_the_run_and_leaves_the_last_states(last_states):
    data = at_height(ball_on_a_table(), 0.02)
    watchdog = Watchdog("abc-7")
    for _ in range(3000):
        mujoco.mj_step(data.model, data)
        watchdog.check(data)
    data.time += 0.1
    data.qvel[1] = np.nan
    text = stop(watchdog, data, match="not finite")
    states = load(last_states, text)
    assert "abc-7" in text
    assert f"{data.time:.3f} s" in text
    assert len(states["time"]) == len(states["qpos"]) == len(states["qvel"]) == len(states["ctrl"]) == 100
    assert states["time"][-1] == data.time
    assert (np.diff(states["time"]) > 0.0).all()
    assert np.isnan(states["qvel"][-1, 1])
    assert np.isfinite(states["qvel"][:-1]).all()


def test_a_torque_that_is_not_finite_stops_the_run(last_states):
    data = at_height(ball_on_a_table(), 0.02)
    data.ctrl[0] = np.inf
    stop(Watchdog("torque"), data, match="not finite")


@pytest.mark.parametrize(
    ("depth", "stops"),
    [(0.5 * ON_SUPPORT, False), (0.95 * ON_SUPPORT, False), (1.05 * ON_SUPPORT, True)],
)
def test_a_contact_that_is_too_deep_stops_the_run(last_states, depth, stops):
    data = at_height(ball_on_a_table(), -depth)
    watchdog = Watchdog("deep")
    if not stops:
        watchdog.check(data)
        return
    text = stop(watchdog, data, match="ball")
    assert "table" in text
    assert f"{1000 * depth:.1f} mm" in text
    np.testing.assert_array_equal(load(last_states, text)["qpos"], [data.qpos])


def test_the_hardest_impact_of_two_limes_from_a_dropped_bag_is_accepted(last_states):
    spec = new_spec(0.001)
    add_objects(spec, objects_of(PileConfig(object="lime", count=2)), 2, [], "paper")
    data = mujoco.MjData(spec.compile())
    data.qpos.reshape(2, 7)[:, 0] = [-0.03, 0.03]
    data.qvel.reshape(2, 6)[:, 0] = [1.55, -1.55]
    watchdog, deepest = Watchdog("bag"), 0.0
    for _ in range(40):
        mujoco.mj_step(data.model, data)
        watchdog.check(data)
        deepest = max(deepest, -float(data.contact.dist.min(initial=0.0)))
    assert data.qvel[0] < 0.0 < data.qvel[6]
    assert 0.003 < deepest < MAX_DROP_PENETRATION


def test_a_deep_contact_is_accepted_while_objects_fall(last_states):
    data = at_height(ball_on_a_table(), -1.05 * ON_SUPPORT)
    data.qvel[2] = -2.0
    watchdog = Watchdog("fall")
    watchdog.check(data)
    data.time, data.qvel[2] = data.time + 0.05, 0.0
    watchdog.check(data)
    data.time += 0.06
    stop(watchdog, data, match="overlap")


def test_geoms_are_objects_hand_or_support():
    scene = prepare(load_scenario("spheres_wall", {"pile.count": 1}), 0).simulation.scene
    kinds, geom = kinds_of(scene.model), scene.model.geom
    named = {name: KINDS[kinds[geom(name).id]] for name in ("table", "wall", "object_0", "middle_4", "palm_web")}
    assert named == {
        "table": "support",
        "wall": "support",
        "object_0": "object",
        "middle_4": "hand",
        "palm_web": "hand",
    }
