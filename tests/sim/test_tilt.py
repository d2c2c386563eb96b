"""The tilted floor: gravity, arm and sensor agree, balls roll down to the support, and the pile knows its slope."""

import copy
import math

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.arm.model import ArmModel
from pilegrasp_ctrl.config import build_scenario, load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.planning.arm_room import default_room
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.planning.simulated_arm import simulated_arm
from pilegrasp_ctrl.primitives.primitive import Setpoint
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sections import PileConfig, SupportConfig
from pilegrasp_ctrl.sim.arm_spread import ArmFactors, draw_factors
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.objects import object_model
from pilegrasp_ctrl.sim.pile_cache import PileCache
from pilegrasp_ctrl.sim.scene import add_objects, add_support, new_spec
from pilegrasp_ctrl.types import Reference

G = 9.81
SLOPE = math.radians(5.0)
DOWN = np.array([math.sin(SLOPE), 0.0, -math.cos(SLOPE)])
SUPPORTS = [("wall", False), ("corner", False), ("wall", True), ("corner", True)]


def layout_of(support="wall", bin=True, tilt=5.0, count=18):
    return make_layout(SupportConfig(kind=support, bin=bin, tilt_deg=tilt), PileConfig(count=count), 0.054)


def rolling(ball, layout):
    """A ball on the floor, 0.3 m before the support."""
    spec = new_spec(1e-3)
    add_objects(spec, ball, 1, add_support(spec, layout), "paper")
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:3] = layout.support_distance - ball.half_size[0] - 0.3, 0.0, ball.half_size[0]
    return model, data


@pytest.mark.parametrize(("support", "bin"), SUPPORTS)
def test_gravity_points_down_the_slope_and_the_arm_is_upright(support, bin):
    layout = layout_of(support, bin)
    np.testing.assert_allclose(layout.gravity, G * DOWN, atol=1e-12)
    base = layout.transform_base_to_world
    np.testing.assert_allclose(base.rotation[:, 2], -DOWN, atol=1e-12)
    # Seen from the arm, the support's lower edge is where it is on a level floor.
    foot = base.inverse().rotation @ [layout.support_distance, 0.0, 0.0] + base.inverse().translation
    np.testing.assert_allclose(foot, [layout.support_distance, 0.0, default_room().base_below_table], atol=1e-12)
    np.testing.assert_array_equal(layout_of(support, bin, tilt=0.0).gravity, [0.0, 0.0, -G])


@pytest.mark.parametrize("solid", [True, False])
def test_a_ball_rolls_down_by_the_formula_and_rests_at_the_low_wall(solid):
    # With the rolling friction of wood. That of felt would leave a quarter of the driving force, of which 5 % is small.
    ball = object_model("heavy_sphere" if solid else "light_sphere").with_friction(0.5)
    radius, friction = ball.half_size[0], ball.surface.rolling
    model, data = rolling(ball, layout_of())
    share = model.body_inertia[1, 0] / (ball.mass * radius**2)
    assert share == pytest.approx(0.4, rel=1e-6) if solid else share > 0.45
    expected = G * (math.sin(SLOPE) - math.cos(SLOPE) * friction / radius) / (1.0 + share)
    # The ball first sinks into its contact.
    speeds = []
    for _ in range(2):
        for _ in range(300):
            mujoco.mj_step(model, data)
        speeds.append(data.qvel[0])
    assert (speeds[1] - speeds[0]) / 0.3 == pytest.approx(expected, rel=0.05)
    assert data.qpos[0] < layout_of().support_distance - radius
    for _ in range(15000):
        mujoco.mj_step(model, data)
    assert data.qpos[0] == pytest.approx(layout_of().support_distance - radius, abs=5e-4)
    assert np.abs(data.qvel).max() < 0.01


@pytest.mark.parametrize("name", ["heavy_sphere", "light_sphere"])
def test_a_felt_ball_still_rolls_to_the_low_wall(name):
    model, data = rolling(object_model(name), layout_of())
    for _ in range(15600):
        mujoco.mj_step(model, data)
    assert data.qpos[0] == pytest.approx(layout_of().support_distance - object_model(name).half_size[0], abs=5e-4)
    assert np.abs(data.qvel).max() < 0.01


def test_friction_among_objects_holds_on_a_slope_more_than_on_a_level_floor():
    def friction_damping(tilt):
        scenario = load_scenario("bin_picking", {"support.tilt_deg": tilt, "pile.count": 2})
        model = prepare(scenario, 0).simulation.scene.model
        geoms = {mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_GEOM, geom): geom for geom in range(model.ngeom)}
        pairs = {
            frozenset(pair): damping
            for pair, damping in zip(
                zip(model.pair_geom1.tolist(), model.pair_geom2.tolist(), strict=True),
                model.pair_solreffriction[:, 1],
                strict=True,
            )
        }
        others = [("object_0", "object_1"), ("object_0", "table"), ("object_1", "bin_far"), ("object_0", "sensor")]
        return model.opt.impratio, [pairs[frozenset(geoms[name] for name in pair)] for pair in others]

    assert friction_damping(0.0) == (3.0, [0.0, 0.0, 0.0, 0.0])
    assert friction_damping(5.0) == (20.0, pytest.approx([-1000.0, -1000.0, -1000.0, 0.0]))


@pytest.fixture(scope="module")
def attempt():
    return prepare(
        load_scenario("bin_picking", {"program": "push", "pile.count": 0, "sensor.bias": 0.0, "sensor.drift": 0.0}), 0
    )


def test_both_engines_see_the_same_arm(attempt):
    # The seed draws the mass of the simulated links.
    mass = draw_factors(simulated_arm("wam7").spread, ArmFactors(np.ones(7), 1.0), attempt.seed).mass
    model, arm = copy.copy(attempt.simulation.scene.model), attempt.arm
    model.body_mass[1 : model.body("sensor").id] /= mass
    np.testing.assert_allclose(model.opt.gravity, arm.pinocchio_model.gravity.linear, atol=1e-12)
    data = mujoco.MjData(model)
    data.qpos[:] = attempt.simulation.data.qpos
    mujoco.mj_forward(model, data)
    state = arm.update(data.qpos[:7], np.zeros(7))
    flange = data.site("flange").xmat.reshape(3, 3)
    tool = Hand.load("rbo_hand2").transform_tool_to_flange
    np.testing.assert_allclose(state.rotation, flange @ tool.rotation, atol=1e-9)
    np.testing.assert_allclose(state.pose.translation, data.site("flange").xpos + flange @ tool.translation, atol=1e-9)
    # The soft fingers hang on springs, which moves the tool's centre of mass slightly.
    np.testing.assert_allclose(data.qfrc_bias[:7], state.h, atol=0.02)


def test_an_upright_arm_needs_the_same_torques_at_every_slope():
    level, tilted = (
        ArmModel.load(base=layout_of(tilt=tilt).transform_base_to_world, gravity=layout_of(tilt=tilt).gravity)
        for tilt in (0.0, 5.0)
    )
    q = np.array([0.3, 0.6, 0.1, 1.2, 0.2, 0.4, 0.1])
    # The numbers of base and gravity differ, but the torques do not.
    np.testing.assert_allclose(level.update(q, np.zeros(7)).h, tilted.update(q, np.zeros(7)).h, atol=1e-9)
    wrong = ArmModel.load(base=layout_of().transform_base_to_world)
    assert np.abs(wrong.update(q, np.zeros(7)).h - tilted.update(q, np.zeros(7)).h).max() > 0.5


def hold(attempt, periods):
    """Let the controller hold the start pose; return the last observation."""
    simulation, arm = attempt.simulation, attempt.arm
    setpoint = Setpoint(Reference(attempt.plan.start), attempt.plan.closure)
    simulation.apply(arm.update(simulation.observe().q, np.zeros(7)).h, setpoint.closure)
    for _ in range(periods):
        simulation.step()
        observation = simulation.observe()
        state = arm.update(observation.q, observation.v)
        simulation.apply(attempt.control(observation, setpoint, state).command.torque, setpoint.closure)
    return observation, state


def test_the_controlled_arm_holds_still_and_the_sensor_reads_nothing(attempt):
    observation, state = hold(attempt, 500)
    assert np.linalg.norm(state.pose.translation - attempt.plan.start.translation) < 2e-3
    assert np.abs(observation.v).max() < 0.01
    assert np.linalg.norm(observation.wrench[:3]) < 0.2


@pytest.mark.parametrize("hand_name", ["rbo_hand2", "shovel"])
def test_a_kilogram_that_hangs_from_the_hand_reads_along_gravity(hand_name):
    silent = {"sensor.force_noise": 0.0, "sensor.torque_noise": 0.0, "sensor.bias": 0.0, "sensor.drift": 0.0}
    loaded = prepare(load_scenario("bin_picking", {"program": "push", "pile.count": 0, "hand": hand_name, **silent}), 0)
    model = loaded.simulation.scene.model
    loaded.simulation.data.xfrc_applied[model.body("sensor").id, :3] = model.opt.gravity
    observation, _ = hold(loaded, 750)
    np.testing.assert_allclose(observation.wrench[:3], G * DOWN, atol=0.01 * G)


def test_the_cache_of_piles_distinguishes_slopes_and_bins():
    ball = object_model("light_sphere")
    layouts = [layout_of(*support, tilt=tilt) for support in SUPPORTS for tilt in (0.0, 5.0, 6.0)]
    files = {PileCache(repr(ball), 18, repr(layout)).file for layout in layouts}
    assert len(files) == len(layouts)
    scenarios = [
        build_scenario({"support": {"bin": bin, "tilt_deg": tilt}}) for bin in (True, False) for tilt in (0, 5)
    ]
    assert len({scenario.config_hash() for scenario in scenarios}) == 4


@pytest.mark.parametrize(
    ("keys", "why"),
    [({"support.bin": True}, "a bin is pushed to its wall"), ({"support.tilt_deg": 5.0}, "the objects roll away")],
)
def test_bin_and_slope_need_a_support(keys, why):
    with pytest.raises(ConfigurationError, match=f"support.kind = 'none' is not allowed, because .*{why}"):
        build_scenario({}, {"support.kind": "none", **keys})
