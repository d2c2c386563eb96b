"""A floor whose slope differs from the known one: touch-down, reading and judgement."""

import copy
import hashlib
import json
import math

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.analysis.motion import table_force
from pilegrasp_ctrl.config import build_scenario, load_scenario
from pilegrasp_ctrl.episode import run
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.neutral_values import NEUTRAL_VALUES
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.planning.simulated_arm import simulated_arm
from pilegrasp_ctrl.planning.strategy import PRE_GRASP_HEIGHT
from pilegrasp_ctrl.primitives.guarded_motions import SEARCH_DEPTH
from pilegrasp_ctrl.primitives.primitive import Setpoint
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sections import PileConfig, SupportConfig
from pilegrasp_ctrl.sim.arm_spread import ArmFactors, draw_factors
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.types import Pose, Reference

G = 9.81
ERROR = math.radians(2.0)
SILENT = {"sensor.force_noise": 0.0, "sensor.torque_noise": 0.0, "sensor.bias": 0.0, "sensor.drift": 0.0}
SHOVEL = SILENT | {"hand": "shovel", "controller.kind": "operational_space"}


def known(tilt=0.0):
    return make_layout(SupportConfig(tilt_deg=tilt), PileConfig(), 0.054)


def wrong_by(error, tilt=0.0):
    return {"support.slope_error_deg": error, "support.tilt_deg": tilt}


@pytest.mark.parametrize("tilt", [0.0, 2.0, 5.0])
def test_a_positive_error_is_a_floor_that_rises_toward_the_support(tilt):
    layout = known(tilt)
    scene_to_known = layout.with_rising_floor(ERROR).transform_from(layout).inverse()
    # Seen from the known floor, the support's lower edge is in its place, and the floor before it is lower.
    for before in (0.0, 0.2, 0.4):
        seen = scene_to_known @ Pose(np.array([layout.support_distance - before, 0.1, 0.0]))
        expected = [layout.support_distance - before * math.cos(ERROR), 0.1, -before * math.sin(ERROR)]
        np.testing.assert_allclose(seen.translation, expected, atol=1e-12)
    gravity = scene_to_known.rotation @ layout.with_rising_floor(ERROR).gravity
    np.testing.assert_allclose(gravity, layout.gravity, atol=1e-12)


@pytest.mark.parametrize("tilt", [0.0, 5.0])
def test_without_an_error_the_transform_is_exactly_the_identity(tilt):
    layout = known(tilt)
    assert repr(layout.with_rising_floor(0.0)) == repr(layout)
    transform = layout.with_rising_floor(0.0).transform_from(layout)
    np.testing.assert_array_equal(transform.rotation, np.eye(3))
    np.testing.assert_array_equal(transform.translation, np.zeros(3))


def test_without_an_error_the_hash_is_that_of_a_scenario_without_the_key():
    scenario = build_scenario({}, wrong_by(0.0))
    content = scenario.model_dump(mode="json", exclude={"name", "summary", "tags"})
    for section, key in NEUTRAL_VALUES:
        content.get(section, {}).pop(key)
    del content["known"]
    assert scenario.config_hash() == hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]
    assert scenario.config_hash() != build_scenario({}, wrong_by(1.0)).config_hash()


def test_the_farthest_touch_down_is_found_at_the_largest_error():
    largest = math.tan(math.radians(3.0))
    assert 0.9 * largest < min(SEARCH_DEPTH, PRE_GRASP_HEIGHT)


def test_an_error_as_large_as_the_tilt_is_a_level_floor_with_the_same_pile():
    level = prepare(load_scenario("spheres_wall", {"pile.count": 5}), 0)
    wrong = prepare(load_scenario("spheres_wall", {"pile.count": 5} | wrong_by(2.0, tilt=2.0)), 0)
    np.testing.assert_array_equal(wrong.pile.poses, level.pile.poses)
    model, other = wrong.simulation.scene.model, level.simulation.scene.model
    np.testing.assert_array_equal(model.opt.gravity, other.opt.gravity)
    np.testing.assert_array_equal(model.body("base_link").pos, other.body("base_link").pos)
    assert not np.array_equal(wrong.arm.pinocchio_model.gravity.linear, level.arm.pinocchio_model.gravity.linear)


@pytest.fixture(scope="module", params=[0.0, 2.0])
def attempt(request):
    return prepare(load_scenario("push_wall", SHOVEL | wrong_by(2.0, request.param)), 0)


def test_the_arm_has_its_planned_pose_relative_to_the_known_floor(attempt):
    # The seed draws the mass of the simulated links.
    mass = draw_factors(simulated_arm("wam7").spread, ArmFactors(np.ones(7), 1.0), attempt.seed).mass
    model, arm = copy.copy(attempt.simulation.scene.model), attempt.arm
    model.body_mass[1 : model.body("sensor").id] /= mass
    data = mujoco.MjData(model)
    data.qpos[:] = attempt.simulation.data.qpos
    mujoco.mj_forward(model, data)
    state = arm.update(data.qpos[:7], np.zeros(7))
    tool = Hand.load("shovel").transform_tool_to_flange
    seen = attempt.transform_known_to_scene @ state.pose
    flange = data.site("flange").xmat.reshape(3, 3)
    np.testing.assert_allclose(seen.rotation, flange @ tool.rotation, atol=1e-9)
    np.testing.assert_allclose(seen.translation, data.site("flange").xpos + flange @ tool.translation, atol=1e-9)
    # The arm is upright and uses the known gravity.
    np.testing.assert_allclose(data.qfrc_bias[:7], state.h, atol=1e-3)


def test_a_kilogram_reads_along_the_known_gravity(attempt):
    simulation, arm = attempt.simulation, attempt.arm
    model = simulation.scene.model
    setpoint = Setpoint(Reference(attempt.plan.start), attempt.plan.closure)
    simulation.apply(arm.update(simulation.observe().q, np.zeros(7)).h, setpoint.closure)
    for period in range(1250):
        if period == 500:
            unloaded = simulation.observe().wrench.copy()
            simulation.data.xfrc_applied[model.body("sensor").id, :3] = model.opt.gravity
        simulation.step()
        observation = simulation.observe()
        state = arm.update(observation.q, observation.v)
        simulation.apply(attempt.control(observation, setpoint, state).command.torque, setpoint.closure)
    assert np.linalg.norm(unloaded[:3]) < 0.05
    np.testing.assert_allclose(observation.wrench[:3], arm.pinocchio_model.gravity.linear, atol=0.01 * G)


@pytest.fixture(scope="module")
def pushes():
    return {
        error: run("push_wall", record=True, overrides=SHOVEL | wrong_by(error, max(error, 0.0)))
        for error in (-2.0, 0.0, 2.0)
    }


def touch_down(result):
    """Position of the tool in the scene when the approach ended [m]."""
    recording = result.recording
    at = np.searchsorted(recording.signal_time, result.outcomes[0].end - 1e-9)
    return recording.signals["tool_position"][at]


@pytest.mark.slow
def test_the_approach_ends_at_the_true_floor(pushes):
    level = touch_down(pushes[0.0])
    for error in (-2.0, 2.0):
        assert touch_down(pushes[error])[2] == pytest.approx(level[2], abs=1e-3)
        # The tool's path ends at the floor. A floor that rises toward the support is lower before it.
        longer = pushes[error].outcomes[0].travel - pushes[0.0].outcomes[0].travel
        assert longer == pytest.approx((1.0 - level[0]) * math.tan(math.radians(error)), abs=1e-3)
        assert abs(longer) > 3e-3


@pytest.mark.slow
def test_recorded_positions_are_those_of_the_scene(pushes):
    recording = pushes[2.0].recording
    sensor = next(index for index, body in enumerate(recording.bodies) if body.name == "sensor")
    columns = recording.signals["tool_position"].T
    tool = np.stack([np.interp(recording.frame_time, recording.signal_time, column) for column in columns], axis=1)
    distance = np.linalg.norm(tool - recording.body_position[:, sensor], axis=1)
    np.testing.assert_allclose(distance, distance[0], atol=2e-4)
    reference = recording.signals["reference_position"][:, 2]
    pushing = recording.signal_time > pushes[2.0].outcomes[1].start + 0.3
    assert reference[pushing][-1] < reference[pushing][0] - 1e-3


@pytest.mark.slow
def test_an_unknown_rise_of_the_floor_presses_on_a_shovel_at_constant_height(pushes):
    mean = {error: table_force(result.recording)["mean"] for error, result in pushes.items()}
    assert mean[2.0] > mean[0.0] + 0.5
    assert all(result.success for result in pushes.values())


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"support.kind": "none"}, "on a sloped floor the objects roll away"),
        ({"support.bin": True}, "is for an open table"),
        ({"program": "order", "support.bin": True}, "is for an open table"),
        ({"program": "line"}, "has no effect if program = 'line'"),
    ],
)
def test_an_error_without_effect_is_rejected(keys, message):
    with pytest.raises(ConfigurationError, match=message):
        build_scenario({}, keys | {"support.slope_error_deg": -1.0})
    build_scenario({}, keys | {"support.slope_error_deg": 0.0})
