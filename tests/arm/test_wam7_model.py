"""The WAM's URDF and MJCF against each other, against robot.toml, and against figures published elsewhere."""

import itertools
import xml.etree.ElementTree as ElementTree

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from pilegrasp_ctrl import robots
from pilegrasp_ctrl.exceptions import ModelError

WAM = robots.description("wam7")
JOINTS = WAM["joints"]
LINKS = [link["name"] for link in WAM["links"]]

# Barrett's AC-02 sheet also prints the inertias about the origin of DH frame i, as public course material quotes them:
# moments [xx, yy, zz] and products [xy, xz, yz] = +∫ x y dm of links 1-3 [kg·m²]. No model was made from these.
ABOUT_ORIGIN = {
    "link1": ([0.29486350, 0.11350017, 0.25065343], [-0.00795023, -0.00009311, -0.00018711]),
    "link2": ([0.02606840, 0.01472202, 0.01934814], [-0.00001346, -0.00011701, 0.00003659]),
    "link3": ([0.13671601, 0.00588354, 0.13951371], [-0.01680434, 0.00000510, -0.00000530]),
}


class Engines:
    """The arm in both engines, with the armature of robot.toml in each."""

    def __init__(self):
        self.pin = pin.buildModelFromUrdf(str(robots.path("wam7", "wam7.urdf")))
        self.pin.armature = np.array(JOINTS["armature"])
        self.pin_data = self.pin.createData()
        self.frame = self.pin.getFrameId("flange")
        self.mj = mujoco.MjModel.from_xml_path(str(robots.path("wam7", "wam7.xml")))
        self.mj_data = mujoco.MjData(self.mj)

    def update(self, q, v):
        pin.computeAllTerms(self.pin, self.pin_data, q, v)
        pin.updateFramePlacements(self.pin, self.pin_data)
        self.mj_data.qpos, self.mj_data.qvel = q, v
        mujoco.mj_forward(self.mj, self.mj_data)

    def mujoco_inertia(self, name):
        body = self.mj.body(name)
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, body.iquat)
        rotation = rotation.reshape(3, 3)
        return body.mass[0], body.ipos, rotation @ np.diag(body.inertia) @ rotation.T

    def pinocchio_inertia(self, name):
        inertia = self.pin.inertias[1 + LINKS.index(name)]
        return inertia.mass, inertia.lever, inertia.inertia


@pytest.fixture(scope="module")
def engines():
    return Engines()


def random_states(count=50, seed=0):
    rng = np.random.default_rng(seed)
    for _ in range(count):
        yield rng.uniform(JOINTS["position_lower"], JOINTS["position_upper"]), rng.uniform(-2.0, 2.0, 7)


def dh_transforms(q):
    """Return the poses (4, 4) of the DH frames 0 (shoulder) to 7 (flange) in the base."""
    table = WAM["kinematics"]
    transforms = [np.eye(4)]
    transforms[0][2, 3] = table["shoulder_height"]
    for angle, a, alpha, d in zip(q, table["a"], table["alpha"], table["d"], strict=True):
        c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
        step = [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]]
        transforms.append(transforms[-1] @ np.array(step))
    return transforms


def dh_frame_in_link(engines, index):
    """Return rotation and translation of DH frame `index` (1-7) in the frame of the same link."""
    engines.update(np.zeros(7), np.zeros(7))
    transform = engines.pin_data.oMi[index].inverse().homogeneous @ dh_transforms(np.zeros(7))[index]
    return transform[:3, :3], transform[:3, 3]


def assert_close(actual, expected, tolerance=1e-8):
    actual, expected = np.asarray(actual), np.asarray(expected)
    assert actual.shape == expected.shape
    assert np.abs(actual - expected).max() <= tolerance * max(1.0, np.abs(expected).max())


def test_both_engines_have_the_joints_and_frames_of_robot_toml(engines):
    assert list(engines.pin.names)[1:] == JOINTS["names"]
    assert [engines.mj.joint(i).name for i in range(engines.mj.njnt)] == JOINTS["names"]
    assert [engines.mj.actuator(i).name for i in range(engines.mj.nu)] == JOINTS["names"]
    assert [engines.mj.body(i).name for i in range(1, engines.mj.nbody)] == ["base_link", *LINKS]
    assert {"base_link", "flange", *LINKS} == {f.name for f in engines.pin.frames if f.type == pin.FrameType.BODY}
    assert engines.mj.nv == engines.mj.nq == engines.pin.nv == 7


def test_forward_kinematics_equals_the_dh_product(engines):
    for q, v in random_states():
        engines.update(q, v)
        assert_close(engines.pin_data.oMf[engines.frame].homogeneous, dh_transforms(q)[-1], 1e-12)


def test_engines_agree_on_the_flange(engines):
    for q, v in random_states():
        engines.update(q, v)
        site = engines.mj_data.site("flange")
        flange = engines.pin_data.oMf[engines.frame]
        assert_close(site.xpos, flange.translation)
        assert_close(site.xmat.reshape(3, 3), flange.rotation)
        jacobian = np.zeros((6, 7))
        mujoco.mj_jacSite(engines.mj, engines.mj_data, jacobian[:3], jacobian[3:], site.id)
        reference = pin.getFrameJacobian(engines.pin, engines.pin_data, engines.frame, pin.LOCAL_WORLD_ALIGNED)
        assert_close(jacobian, reference)


def test_engines_agree_on_the_dynamics(engines):
    for q, v in random_states():
        engines.update(q, v)
        mass_matrix = np.zeros((7, 7))
        mujoco.mj_fullM(engines.mj, engines.mj_data, mass_matrix)
        upper = np.triu(pin.crba(engines.pin, engines.pin_data, q))
        assert_close(mass_matrix, upper + np.triu(upper, 1).T)
        assert_close(engines.mj_data.qfrc_bias, pin.nonLinearEffects(engines.pin, engines.pin_data, q, v))
        gravity = pin.computeGeneralizedGravity(engines.pin, engines.pin_data, q)
        engines.update(q, np.zeros(7))
        assert_close(engines.mj_data.qfrc_bias, gravity)


def test_the_largest_gravity_torques_are_the_documented_ones(engines):
    largest = np.zeros(7)
    for q, _ in random_states(20_000):
        gravity = pin.computeGeneralizedGravity(engines.pin, engines.pin_data, q)
        largest = np.maximum(largest, np.abs(gravity))
    assert largest == pytest.approx([0.0, 28.1, 6.6, 5.2, 0.15, 0.14, 0.0], rel=0.02, abs=0.005)


@pytest.mark.parametrize("link", WAM["links"], ids=LINKS)
@pytest.mark.parametrize("engine", ["pinocchio", "mujoco"])
def test_inertias_are_those_of_the_source_in_dh_axes(engines, engine, link):
    mass, center, inertia = getattr(engines, f"{engine}_inertia")(link["name"])
    rotation, translation = dh_frame_in_link(engines, 1 + LINKS.index(link["name"]))
    xy, xz, yz = link["products"]
    expected = np.diag(link["moments"]) - np.array([[0, xy, xz], [xy, 0, yz], [xz, yz, 0]])
    assert mass == link["mass"]
    assert_close(rotation.T @ (center - translation), link["center_of_mass"], 1e-12)
    assert_close(rotation.T @ inertia @ rotation, expected, 1e-12)


@pytest.mark.parametrize("name", ABOUT_ORIGIN)
@pytest.mark.parametrize("engine", ["pinocchio", "mujoco"])
def test_products_of_inertia_have_the_published_sign(engines, engine, name):
    mass, center, inertia = getattr(engines, f"{engine}_inertia")(name)
    rotation, translation = dh_frame_in_link(engines, 1 + LINKS.index(name))
    lever = rotation.T @ (center - translation)
    about_origin = rotation.T @ inertia @ rotation + mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
    moments, products = ABOUT_ORIGIN[name]
    assert np.diag(about_origin) == pytest.approx(moments, abs=5e-8)
    assert -about_origin[np.triu_indices(3, 1)] == pytest.approx(products, abs=5e-8)


@pytest.mark.parametrize("name", LINKS)
@pytest.mark.parametrize("engine", ["pinocchio", "mujoco"])
def test_principal_moments_are_those_of_a_physical_body(engines, engine, name):
    smallest, middle, largest = np.linalg.eigvalsh(getattr(engines, f"{engine}_inertia")(name)[2])
    assert smallest > 0.0
    assert smallest + middle >= largest


def test_the_total_mass_is_19_459_kg_in_both_engines(engines):
    assert pin.computeTotalMass(engines.pin) == pytest.approx(19.459, abs=5e-4)
    assert engines.mj.body_mass.sum() == pytest.approx(19.459, abs=5e-4)


def test_urdf_states_the_limits_of_robot_toml():
    tree = ElementTree.parse(robots.path("wam7", "wam7.urdf"))
    joints = [joint for joint in tree.iter("joint") if joint.get("type") == "revolute"]
    keys = {
        ("limit", "lower"): "position_lower",
        ("limit", "upper"): "position_upper",
        ("limit", "effort"): "torque_peak",
        ("limit", "velocity"): "velocity",
        ("dynamics", "damping"): "friction_viscous",
        ("dynamics", "friction"): "friction_coulomb",
    }
    for (tag, attribute), key in keys.items():
        assert [float(joint.find(tag).get(attribute)) for joint in joints] == JOINTS[key], key


def test_mjcf_states_the_limits_of_robot_toml(engines):
    model, peak = engines.mj, np.array(JOINTS["torque_peak"])
    assert model.jnt_limited.all()
    assert model.actuator_ctrllimited.all()
    assert model.actuator_forcelimited.all()
    np.testing.assert_array_equal(model.jnt_range.T, [JOINTS["position_lower"], JOINTS["position_upper"]])
    np.testing.assert_array_equal(model.actuator_ctrlrange.T, [-peak, peak])
    np.testing.assert_array_equal(model.actuator_forcerange.T, [-peak, peak])
    np.testing.assert_array_equal(model.dof_armature, JOINTS["armature"])
    np.testing.assert_array_equal(model.dof_frictionloss, JOINTS["friction_coulomb"])
    np.testing.assert_array_equal(np.ravel(model.dof_damping), JOINTS["friction_viscous"])


def test_armature_and_torques_follow_from_the_transmission():
    drive = WAM["transmission"]
    joint_to_motor = np.array(drive["joint_to_motor"])
    reflected = joint_to_motor.T @ np.diag(drive["drive_inertia"]) @ joint_to_motor
    assert JOINTS["armature"] == pytest.approx(np.diag(reflected), rel=0.015)
    for motor, joint in (("motor_torque_continuous", "torque_continuous"), ("motor_torque_peak", "torque_peak")):
        assert JOINTS[joint] == pytest.approx(np.abs(joint_to_motor.T) @ drive[motor], rel=0.005)
    no_load = drive["motor_speed_no_load"] / np.abs(joint_to_motor).sum(axis=1)
    assert JOINTS["velocity"][0] == pytest.approx(no_load[0], rel=0.005)


def test_visual_and_collision_geometry_are_separate(engines):
    group = engines.mj.geom_group
    visual, collision = group == 2, group == 3
    assert (visual | collision).all()
    assert not (engines.mj.geom_contype[visual] | engines.mj.geom_conaffinity[visual]).any()
    assert (engines.mj.geom_contype[collision] & engines.mj.geom_conaffinity[collision]).all()
    for body in range(1, engines.mj.nbody):
        groups = group[engines.mj.geom_bodyid == body]
        assert {2, 3} == set(groups)
    assert collision.sum() < visual.sum() / 2


@pytest.mark.parametrize(("kind", "group"), [(pin.GeometryType.VISUAL, 2), (pin.GeometryType.COLLISION, 3)])
def test_both_files_have_the_same_shapes(engines, kind, group):
    urdf = pin.buildGeomFromUrdf(engines.pin, str(robots.path("wam7", "wam7.urdf")), kind).geometryObjects
    mjcf = np.flatnonzero(engines.mj.geom_group == group)
    assert len(urdf) == len(mjcf)
    for shape, index in zip(urdf, mjcf, strict=True):
        size, rotation = engines.mj.geom_size[index], np.zeros(9)
        mujoco.mju_quat2Mat(rotation, engines.mj.geom_quat[index])
        assert shape.parentJoint == engines.mj.geom_bodyid[index] - 1
        assert_close(shape.placement.translation, engines.mj.geom_pos[index], 1e-12)
        assert abs(shape.placement.rotation[:, 2] @ rotation.reshape(3, 3)[:, 2]) == pytest.approx(1.0)
        if engines.mj.geom_type[index] == mujoco.mjtGeom.mjGEOM_BOX:
            assert_close(shape.geometry.halfSide, size)
        else:
            assert_close([shape.geometry.radius, shape.geometry.halfLength], size[:2])


def test_the_wrist_stays_behind_the_flange_and_within_60_mm_of_its_axis(engines):
    engines.update(np.zeros(7), np.zeros(7))
    flange = engines.mj_data.site("flange").xpos
    for index in np.flatnonzero(engines.mj.geom_bodyid >= engines.mj.body("link5").id):
        size, box = engines.mj.geom_size[index], engines.mj.geom_type[index] == mujoco.mjtGeom.mjGEOM_BOX
        if box:
            local = np.array(list(itertools.product((-1, 1), repeat=3))) * size
        else:
            angles = np.linspace(0.0, 2.0 * np.pi, 33)
            rim = size[0] * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
            end = np.array([0.0, 0.0, size[1]])
            local = np.concatenate([rim + end, rim - end])
        points = local @ engines.mj_data.geom_xmat[index].reshape(3, 3).T + engines.mj_data.geom_xpos[index] - flange
        assert points[:, 2].max() < 1e-9
        assert np.hypot(points[:, 0], points[:, 1]).max() < 0.060


def test_the_home_posture_points_the_flange_down_without_contact(engines):
    home = np.array(WAM["postures"]["home"])
    assert (home > JOINTS["position_lower"]).all()
    assert (home < JOINTS["position_upper"]).all()
    engines.update(home, np.zeros(7))
    assert engines.mj_data.site("flange").xmat.reshape(3, 3)[2, 2] < -0.999
    assert engines.mj_data.ncon == 0


def test_the_bare_arm_steps_without_a_warning():
    model = mujoco.MjModel.from_xml_path(str(robots.path("wam7", "wam7.xml")))
    data = mujoco.MjData(model)
    data.qpos = WAM["postures"]["home"]
    for _ in range(100):
        data.ctrl = data.qfrc_bias
        mujoco.mj_step(model, data)
    assert not any(warning.number for warning in data.warning)
    assert np.abs(data.qpos - WAM["postures"]["home"]).max() < 1e-2


def test_robots_are_found_by_name():
    assert "wam7" in robots.names()
    assert robots.path("wam7", "wam7.urdf").is_file()
    assert WAM["robot"]["flange_frame"] == "flange"


@pytest.mark.parametrize("name", ["wam8", "wam7/../wam7", "", "hands"])
def test_an_unknown_robot_is_an_error_that_names_the_known_ones(name):
    with pytest.raises(ModelError, match="wam7"):
        robots.description(name)


@pytest.mark.parametrize("parts", [(), ("wam7", "wam8.urdf"), ("..", "pyproject.toml")])
def test_a_missing_file_is_an_error_that_names_the_robots(parts):
    with pytest.raises(ModelError, match=r"the robots are:.*wam7"):
        robots.path(*parts)
