"""The compiled scene: order of its parts, contact pairs, numerics and drawn bodies."""

from itertools import combinations, product
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.sim.contact import SUPPORT, combine, pair_parameters
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.objects import object_model
from pilegrasp_ctrl.sim.readout import drawn_bodies
from pilegrasp_ctrl.sim.scene import build_scene

ARM_JOINTS = tuple(f"j{i}" for i in range(1, 8))
COUNT = 5


def scene_of(hand="rbo_hand2", **overrides):
    """Build the scene of a scenario in a corner, and return it with what it was built from."""
    scenario = load_scenario("spheres_corner", {"hand": hand, "pile.count": COUNT, **overrides})
    objects, hand = object_model(scenario.pile.object), Hand.load(hand)
    layout = make_layout(scenario.support, scenario.pile, objects.diameter)
    return SimpleNamespace(
        scene=build_scene(scenario, hand, objects, layout), hand=hand, objects=objects, layout=layout
    )


@pytest.fixture(scope="module", params=["rbo_hand2", "shovel"])
def built(request):
    return scene_of(request.param)


def pairs_of(model):
    """Return the explicit contact pairs by the names of their geoms."""
    names = [
        [model.geom(int(geom)).name for geom in (model.pair_geom1[i], model.pair_geom2[i])] for i in range(model.npair)
    ]
    return {frozenset(pair): i for i, pair in enumerate(names)}


def test_the_arms_joints_come_first(built):
    model, scene = built.scene.model, built.scene
    assert scene.arm_dofs == 7
    assert tuple(model.joint(i).name for i in range(7)) == ARM_JOINTS
    assert model.jnt_qposadr[:7].tolist() == model.jnt_dofadr[:7].tolist() == list(range(7))
    driven = [model.joint(int(model.actuator_trnid[i, 0])).name for i in range(7)]
    assert tuple(driven) == ARM_JOINTS
    np.testing.assert_array_equal(model.body("base_link").pos, built.layout.transform_base_to_world.translation)


def test_the_objects_come_last_and_in_order(built):
    model, scene = built.scene.model, built.scene
    assert [model.body(body).name for body in scene.objects] == [f"object_{i}" for i in range(COUNT)]
    addresses = [int(model.joint(f"object_{i}").qposadr[0]) for i in range(COUNT)]
    assert addresses == [scene.object_qpos + 7 * i for i in range(COUNT)]
    assert addresses[-1] + 7 == model.nq
    np.testing.assert_allclose(model.body_mass[list(scene.objects)], built.objects.mass)


def test_the_hand_is_everything_beyond_the_flange(built):
    model, scene = built.scene.model, built.scene
    names = {model.body(body).name for body in scene.hand_bodies}
    assert names == {body.name for body in built.hand.standalone_spec().bodies} - {"world"}
    mass = model.body_mass[list(scene.hand_bodies)].sum()
    assert mass == pytest.approx(built.hand.mass_properties().mass)


def test_exactly_the_contacts_of_hand_and_objects_have_explicit_pairs(built):
    supports = ["table", "wall_left", "wall_right"]
    objects = [f"object_{i}" for i in range(COUNT)]
    fingers = built.hand.contact_geoms
    expected = {frozenset(pair) for pair in combinations(objects, 2)}
    expected |= {frozenset(pair) for pair in product(objects, supports)}
    expected |= {frozenset(pair) for pair in product(fingers, objects)}
    expected |= {frozenset(pair) for pair in product(fingers, supports)}
    expected |= {frozenset(pair) for pair in built.hand.touching_pairs}
    assert pairs_of(built.scene.model).keys() == expected
    assert len(expected) == built.scene.model.npair
    assert "sensor" in fingers
    assert "bracket" not in fingers


def test_by_default_objects_collide_with_the_arms_own_links_only_and_the_hand_with_nothing(built):
    model = built.scene.model
    contact_type, affinity = model.geom_contype, model.geom_conaffinity

    def partners(name):
        geom = model.geom(name).id
        bodies = model.geom_bodyid[((contact_type[geom] & affinity) | (contact_type & affinity[geom])) != 0]
        return {model.body(int(body)).name for body in bodies}

    for name in built.hand.contact_geoms:
        assert partners(name) == set()
    for index in range(COUNT):
        assert partners(f"object_{index}") == {"base_link", *(f"link{i}" for i in range(1, 8))}


def with_objects_far_away(built):
    data = mujoco.MjData(built.scene.model)
    poses = data.qpos[built.scene.object_qpos :].reshape(COUNT, 7)
    poses[:, 0] = 5.0 + np.arange(COUNT)
    poses[:, 2] = 5.0
    mujoco.mj_forward(built.scene.model, data)
    return data, poses


def touching(model, data):
    """Return the names of the bodies in contact."""
    return {model.body(int(model.geom_bodyid[geom])).name for pair in data.contact.geom for geom in pair}


def test_an_arm_below_the_table_top_collides_except_at_its_base(built):
    data, _ = with_objects_far_away(built)
    assert data.ncon == 0
    data.qpos[:7] = [0.0, 1.9, 0.0, 0.0, 0.0, 0.0, 0.0]
    mujoco.mj_forward(built.scene.model, data)
    assert touching(built.scene.model, data) & {"link4", "link5", "link6", "link7"}


def test_an_object_in_the_forearm_collides(built):
    data, poses = with_objects_far_away(built)
    poses[0, :3] = data.body("link5").xipos
    mujoco.mj_forward(built.scene.model, data)
    assert touching(built.scene.model, data) >= {"object_0", "link5"}


@pytest.mark.parametrize("rule", ["paper", "product", "maximum"])
def test_a_pair_has_the_coefficients_of_its_two_bodies(rule):
    built = scene_of("shovel", **{"sim.contact_rule": rule, "pile.object": "heavy_sphere"})
    model, pairs = built.scene.model, pairs_of(built.scene.model)
    ball, hand = built.objects.surface, built.hand.surface
    cases = {
        ("object_0", "object_1"): (ball, ball, 6),
        ("object_0", "table"): (ball, SUPPORT, 6),
        ("object_0", "wall_left"): (ball, SUPPORT, 6),
        ("object_0", "scoop_floor"): (hand, ball, 6),
        ("table", "scoop_floor"): (hand, SUPPORT, 3),
        ("wall_right", "sensor"): (hand, SUPPORT, 3),
    }
    for names, (first, second, condim) in cases.items():
        pair = pairs[frozenset(names)]
        wanted = pair_parameters(combine(first, second, rule), model.opt.timestep)
        np.testing.assert_allclose(model.pair_friction[pair], wanted.friction)
        np.testing.assert_allclose(model.pair_solref[pair], wanted.solref)
        np.testing.assert_allclose(model.pair_solimp[pair], wanted.solimp)
        assert model.pair_dim[pair] == condim


def test_the_numerics_are_those_of_the_scenario():
    option = scene_of(**{"sim.timestep": 0.0005}).scene.model.opt
    assert option.timestep == 0.0005
    assert option.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert option.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    assert option.solver == mujoco.mjtSolver.mjSOL_CG
    assert option.enableflags & mujoco.mjtEnableBit.mjENBL_SLEEP
    assert option.gravity.tolist() == [0.0, 0.0, -9.81]


def test_the_walls_of_the_model_are_those_of_the_layout(built):
    model = built.scene.model
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for wall in built.layout.walls:
        geom = data.geom(wall.name)
        np.testing.assert_allclose(geom.xpos, wall.center)
        normal = [np.cos(wall.yaw), np.sin(wall.yaw), 0.0]
        np.testing.assert_allclose(geom.xmat.reshape(3, 3)[:, 0], normal, atol=1e-12)
        np.testing.assert_allclose(model.geom(wall.name).size, wall.half_size)
    assert data.geom("table").xpos[2] == 0.0


def test_every_drawn_body_has_its_role(built):
    bodies, ids = drawn_bodies(built.scene)
    model = built.scene.model
    assert [body.name for body in bodies] == [model.body(int(body)).name for body in ids]
    roles = {body.name: body.role for body in bodies}
    assert roles["world"] == "support"
    assert roles["sensor"] == "sensor"
    assert all(roles[f"object_{i}"] == "object" for i in range(COUNT))
    assert {name for name, role in roles.items() if role == "arm"} == {"base_link", *(f"link{i}" for i in range(1, 8))}
    hand = {model.body(body).name for body in built.scene.hand_bodies} - {"sensor"}
    assert {name for name, role in roles.items() if role == "hand"} == hand
    support = next(body for body in bodies if body.role == "support")
    assert sorted(shape.kind for shape in support.shapes) == ["box", "box", "plane"]


def test_shapes_that_only_collide_are_not_drawn(built):
    model = built.scene.model
    bodies, _ = drawn_bodies(built.scene)
    assert sum(len(body.shapes) for body in bodies) == np.count_nonzero(model.geom_group != 3) < model.ngeom
