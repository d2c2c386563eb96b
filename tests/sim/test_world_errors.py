"""What differs between the world and what is known of it: table, support, pile, friction, sensor, contacts."""

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.config import Scenario, build_scenario, dotted_keys, load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.neutral_values import NEUTRAL_VALUES
from pilegrasp_ctrl.programs.attempt import check, prepare
from pilegrasp_ctrl.sections import PileConfig, SensorConfig
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.objects import objects_of
from pilegrasp_ctrl.sim.wrist_sensor import WristSensor

CHANGED = {
    "known.table_z": 0.005,
    "known.support_x": 0.01,
    "known.support_y": -0.01,
    "known.support_yaw_deg": 3.0,
    "known.pile_x": 0.02,
    "known.pile_y": -0.02,
    "pile.friction_value": 0.3,
    "pile.mutual_contacts": False,
    "sensor.delay": 0.01,
    "sensor.slow_drift": 1.0,
    "sim.joint_friction": 1.5,
}
PERIOD = 0.002
SILENT = {"force_noise": 0.0, "torque_noise": 0.0, "cutoff": 1e3, "bias": 0.0, "drift": 0.0}


def plan_with(**keys):
    return prepare(load_scenario("spheres_wall", {"pile.count": 5, **keys}), 3)


def touch(attempt):
    """The planned touch-down (3,) in the scene."""
    return (attempt.transform_known_to_scene @ attempt.plan.waypoints[1]).translation


@pytest.mark.parametrize("key", CHANGED)
def test_a_key_counts_in_the_hash_unless_it_means_the_behaviour_before_it_existed(key):
    assert key in dotted_keys()
    section, _, name = key.partition(".")
    neutral = NEUTRAL_VALUES[section, name]
    before = Scenario().config_hash()
    same = {} if neutral is None else {key: neutral}
    assert build_scenario({}, same).config_hash() == before
    assert build_scenario({}, {key: CHANGED[key]}).config_hash() != before


def test_the_hand_meets_a_table_that_is_lower_than_known_later_and_where_it_is():
    def down(parts):
        shipped = parts.push_plan()
        return replace(shipped, primitives=shipped.primitives[:1])

    found = {}
    for error in (0.0, 0.005):
        result = pg.run("push_wall", plan=down, overrides={"known.table_z": error}, record=True)
        found[error] = result.outcomes[0].end, result.recording.signals["tool_position"][-1][2]
    speed = load_scenario("push_wall").strategy.touch_speed
    assert found[0.005][0] - found[0.0][0] == pytest.approx(0.005 / speed, abs=0.015)
    assert found[0.005][1] == pytest.approx(found[0.0][1], abs=6e-4)


def test_a_displaced_pile_is_where_it_was_and_the_hand_comes_down_beside():
    true, aside = plan_with(), plan_with(**{"known.pile_y": 0.02})
    assert np.array_equal(true.simulation.object_poses(), aside.simulation.object_poses())
    np.testing.assert_allclose(touch(aside) - touch(true), [0.0, 0.02, 0.0], atol=1e-9)
    assert touch(plan_with(**{"known.pile_x": -0.02}))[0] == pytest.approx(touch(true)[0] - 0.02, abs=1e-9)


def test_a_turned_wall_turns_the_push_and_stays_where_it_is():
    true, turned = plan_with(), plan_with(**{"known.support_yaw_deg": 5.0})
    wanted = [math.cos(math.radians(5.0)), math.sin(math.radians(5.0)), 0.0]
    np.testing.assert_allclose(turned.plan.direction, wanted, atol=1e-12)
    walls = [attempt.simulation.scene.model.geom("wall") for attempt in (true, turned)]
    assert np.array_equal(walls[0].pos, walls[1].pos)
    assert np.array_equal(walls[0].quat, walls[1].quat)


def test_a_wall_that_is_believed_farther_away_lets_the_base_stand_back():
    keys = {"pile.count": 18}
    true, far = plan_with(**keys), plan_with(**keys, **{"known.support_x": 0.03})
    assert np.array_equal(true.simulation.object_poses(), far.simulation.object_poses())
    # The hand comes down behind the pile either way.
    np.testing.assert_allclose(touch(far), touch(true), atol=1e-9)
    bases = [attempt.simulation.scene.model.body("base_link").pos[0] for attempt in (true, far)]
    assert bases[1] != bases[0]


def test_a_corner_that_is_believed_aside_moves_the_push_aside():
    keys = {"support.kind": "corner"}
    true, aside = plan_with(**keys), plan_with(**keys, **{"known.support_y": 0.02})
    assert touch(aside)[1] - touch(true)[1] == pytest.approx(0.02, abs=2e-3)


def test_the_friction_of_the_plants_joints_holds_a_torque_that_the_usual_one_does_not():
    moved = {}
    for factor in (1.0, 1.5):
        attempt = prepare(load_scenario("push_wall", {"sim.joint_friction": factor}), 0)
        simulation, arm = attempt.simulation, attempt.arm
        usual = prepare(load_scenario("push_wall"), 0).simulation.scene.model.dof_frictionloss[0]
        start = simulation.observe().q
        for _ in range(150):
            observation = simulation.observe()
            torque = arm.update(observation.q, observation.v).h.copy()
            torque[0] += 1.25 * usual
            simulation.apply(torque, 0.3)
            simulation.step()
        moved[factor] = abs(simulation.observe().q[0] - start[0])
    assert moved[1.0] > 8.0 * moved[1.5]


def sensor_on(config, steps, force):
    """Readings (steps, 6) of a sensor whose hand a force (3,) pulls from step 100 on."""
    hand = Hand.load("shovel")
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    hand.add_to(spec, spec.worldbody.add_site(name="flange", pos=[0.0, 0.0, 1.0]))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    sensor = WristSensor(model, hand.mass_properties(), SensorConfig(**{**SILENT, **config}), PERIOD, seed=1)
    found = []
    for step in range(steps):
        data.xfrc_applied[model.body("sensor").id, :3] = force if step >= 100 else 0.0
        mujoco.mj_forward(model, data)
        sensor.sample(data)
        found.append(sensor.read(data))
    return np.array(found)


def test_a_late_sensor_reads_the_same_that_many_periods_later():
    now, late = (sensor_on({"delay": delay}, 200, [5.0, 0.0, 2.0]) for delay in (0.0, 0.02))
    assert np.array_equal(late[10:], now[:-10])
    assert np.array_equal(late[:10], np.repeat(now[:1], 10, axis=0))
    assert np.flatnonzero(np.abs(late[:, 0]) > 2.0)[0] - np.flatnonzero(np.abs(now[:, 0]) > 2.0)[0] == 10


def test_a_late_sensor_ends_a_push_later():
    ends = [pg.run("push_wall", overrides={"sensor.delay": delay}).outcomes[1] for delay in (0.0, 0.03)]
    assert ends[1].end - ends[0].end == pytest.approx(0.03, abs=0.02)
    assert ends[1].trigger == "grasp force"


def test_the_zero_drifts_by_its_size_in_ten_seconds_and_comes_back():
    still, drifting = (sensor_on({"slow_drift": size}, 10_001, np.zeros(3)) for size in (0.0, 1.0))
    off = np.linalg.norm((drifting - still)[:, :3], axis=1)
    assert off[5000] == pytest.approx(1.0, abs=0.05)
    assert off[2500] == pytest.approx(0.5, abs=0.05)
    assert off[[0, 10_000]] == pytest.approx(0.0, abs=0.05)


def test_a_delay_of_less_than_half_a_period_is_refused():
    with pytest.raises(ConfigurationError, match=r"sensor\.delay = 0\.0005 s has no effect.*such as 0\.002"):
        check(build_scenario({}, {"sensor.delay": 0.0005}))


def test_without_mutual_contacts_what_lay_on_others_lies_on_the_floor():
    keys = {"pile.object": "cube", "pile.count": 20, "pile.frame_size": 0.17}
    heaped = plan_with(**keys).simulation.object_poses()
    attempt = plan_with(**keys, **{"pile.mutual_contacts": False})
    flat, model, data = attempt.simulation.object_poses(), attempt.simulation.scene.model, attempt.simulation.data
    half = objects_of(PileConfig(object="cube")).half_size[0]
    assert heaped[:, 2].max() > 2.5 * half
    assert flat[:, 2].max() < math.sqrt(3.0) * half
    bodies = set(attempt.simulation.scene.objects)
    pairs = [{int(model.geom_bodyid[geom]) for geom in pair} for pair in data.contact.geom]
    assert pairs
    assert not any(pair <= bodies for pair in pairs)
    # Hand, table and wall still touch the objects.
    explicit = [
        {model.geom_bodyid[a], model.geom_bodyid[b]} for a, b in zip(model.pair_geom1, model.pair_geom2, strict=True)
    ]
    assert any(pair & bodies and pair & set(attempt.simulation.scene.hand_bodies) for pair in explicit)
    assert not any(pair <= bodies for pair in explicit)


def test_one_friction_holds_for_all_objects_and_the_factor_multiplies_it():
    mix = objects_of(PileConfig(object="light_sphere+cube", count=4, friction_value=0.3, friction=0.5))
    assert [each.surface.lateral for each in mix.object_models] == [0.15, 0.15]
    own = objects_of(PileConfig(object="light_sphere+cube", count=4, friction=0.5))
    assert [each.surface.rolling for each in mix.object_models] == [each.surface.rolling for each in own.object_models]


@pytest.mark.parametrize(
    ("scenario", "key"),
    [
        ("free_space_line", "known.table_z"),
        ("spheres_alone", "known.support_x"),
        ("push_wall", "known.pile_y"),
    ],
)
def test_an_error_of_what_is_not_there_is_refused(scenario, key):
    with pytest.raises(ConfigurationError, match=rf"{key} has no effect without"):
        load_scenario(scenario, {key: 0.01})
