"""Capsules of arms and hands: stated in a folder, or fitted around the geometry of a model."""

import numpy as np
import pinocchio as pin
import pytest

from pilegrasp_ctrl.arm.capsules import capsules_of
from pilegrasp_ctrl.arm.collision_balls import balls_of_model
from pilegrasp_ctrl.arm.model import ArmModel
from pilegrasp_ctrl.exceptions import ModelError
from pilegrasp_ctrl.robots import panda_urdf, path
from pilegrasp_ctrl.sim.hand import Hand

ROBOT = '<robot name="arm"><link name="base"><collision>{}<geometry>{}</geometry></collision></link></robot>'
BODY = """<mujoco><worldbody><geom type="plane" size="1 1 1"/><body name="arm">
<geom type="{}" size="{}" pos="0.1 0 0" euler="0 90 0"/><geom type="sphere" size="9" contype="0" conaffinity="0"/>
<joint/></body></worldbody></mujoco>"""


def excess(capsules, points, radii):
    """Return by how much balls stick out of the capsule that holds them best, for the worst ball [m]."""
    out = np.full(len(points), np.inf)
    for capsule in capsules:
        along = capsule.end - capsule.start
        share = np.clip((points - capsule.start) @ along / max(along @ along, 1e-12), 0.0, 1.0)
        away = np.linalg.norm(points - capsule.start - share[:, None] * along, axis=1)
        out = np.minimum(out, away + radii - capsule.radius)
    return out.max()


def volume(capsule):
    length = np.linalg.norm(capsule.end - capsule.start)
    return np.pi * capsule.radius**2 * (length + 4.0 / 3.0 * capsule.radius)


def test_each_link_of_a_urdf_gets_a_capsule_around_all_vertices_of_its_meshes():
    model = pin.buildModelFromUrdf(str(panda_urdf()))
    folders = [str(folder) for folder in panda_urdf().parents]
    shapes = pin.buildGeomFromUrdf(model, str(panda_urdf()), pin.GeometryType.COLLISION, package_dirs=folders)
    capsules = {capsule.frame: capsule for capsule in capsules_of(panda_urdf())}
    assert set(capsules) == {model.frames[shape.parentFrame].name for shape in shapes.geometryObjects}
    for shape in shapes.geometryObjects[:9]:
        frame = model.frames[shape.parentFrame]
        place = frame.placement.inverse() * shape.placement
        points = shape.geometry.vertices() @ place.rotation.T + place.translation
        capsule = capsules[frame.name]
        assert excess([capsule], points, 0.0) <= 0.0
        spread = np.ptp(points, axis=0)
        assert volume(capsule) < 2.5 * np.prod(spread)


def test_the_capsules_of_the_wam_hold_the_collision_geometry_of_its_model():
    stated = capsules_of("wam7")
    for link, balls in balls_of_model(path("wam7", "wam7.urdf"), ()).items():
        # The prism around a cylinder is 1 % wider than the cylinder, and a stated capsule need not hold its corners.
        assert excess([capsule for capsule in stated if capsule.frame == link], *balls) < 1e-3, link


@pytest.mark.parametrize("name", ["rbo_hand2", "shovel"])
def test_the_capsules_of_a_hand_hold_the_housing_of_its_sensor(name):
    capsules = capsules_of(f"hands/{name}", frame="flange")
    sensor = Hand.load(name).parameters["sensor"]
    turns = np.linspace(0.0, 2.0 * np.pi, 40)
    for z in (sensor["bottom"], sensor["top"]):
        rim = np.column_stack((sensor["radius"] * np.cos(turns), sensor["radius"] * np.sin(turns), np.full(40, z)))
        assert excess(capsules, rim, 0.0) <= 0.0
    assert {capsule.frame for capsule in capsules} == {"flange"}
    ArmModel.load("wam7").check_frame(capsules[0].frame)


def test_the_capsules_of_the_soft_hand_hold_its_palm():
    palm = Hand.load("rbo_hand2").parameters["palm"]
    for part in ("scaffold", "pad", "web"):
        signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T
        corners = np.array(palm[f"{part}_center"]) + signs * palm[f"{part}_half_size"]
        assert excess(capsules_of("hands/rbo_hand2", frame="flange"), corners, 0.0) <= 0.0, part


def test_urdf_and_mjcf_of_one_arm_give_the_same_capsules():
    urdf, mjcf = (capsules_of(path("wam7", f"wam7.{kind}")) for kind in ("urdf", "xml"))
    assert [capsule.frame for capsule in urdf] == [capsule.frame for capsule in mjcf]
    for one, other in zip(urdf, mjcf, strict=True):
        assert volume(one) == pytest.approx(volume(other), rel=0.1)


@pytest.mark.parametrize(
    ("shape", "radius", "length"),
    [
        ('<sphere radius="0.1"/>', 0.1, 0.0),
        ('<cylinder radius="0.05" length="0.6"/>', 0.05, 0.6),
        ('<box size="0.1 0.1 0.8"/>', 0.0707, 0.8),
    ],
)
def test_a_primitive_of_a_urdf_gets_a_tight_capsule(tmp_path, shape, radius, length):
    file = tmp_path / "arm.urdf"
    place = '<origin xyz="0.1 0.2 0.3"/>'
    file.write_text(ROBOT.format(place, shape))
    (capsule,) = capsules_of(file)
    assert capsule.frame == "base"
    assert radius <= capsule.radius < 1.1 * radius
    assert np.linalg.norm(capsule.end - capsule.start) <= length + 1e-6
    np.testing.assert_allclose(0.5 * (capsule.start + capsule.end), [0.1, 0.2, 0.3], atol=5e-3)


@pytest.mark.parametrize(
    ("kind", "size", "half", "radius"),
    [("capsule", "0.05 0.2", 0.2, 0.05), ("cylinder", "0.05 0.2", 0.2, 0.055), ("ellipsoid", "0.3 0.1 0.1", 0.3, 0.2)],
)
def test_a_geom_of_an_mjcf_gets_a_capsule_and_a_visual_one_none(tmp_path, kind, size, half, radius):
    file = tmp_path / "arm.xml"
    file.write_text(BODY.format(kind, size))
    (capsule,) = capsules_of(file)
    assert capsule.frame == "arm"
    assert np.linalg.norm(capsule.end - capsule.start) <= 2.0 * half + 1e-6
    assert capsule.radius <= radius + 1e-6


def test_a_folder_without_tables_gets_the_capsules_of_its_model(tmp_path):
    (tmp_path / "robot.toml").write_text('[robot]\nurdf = "arm.urdf"\n')
    (tmp_path / "arm.urdf").write_text(ROBOT.format("", '<sphere radius="0.1"/>'))
    (capsule,) = capsules_of(tmp_path)
    assert capsule.radius == pytest.approx(0.1, rel=1e-3)
    with (tmp_path / "robot.toml").open("a") as toml:
        toml.write('[[collision.capsules]]\nlink = "hand"\nfrom = [0, 0, 0]\nto = [0, 0, 1]\nradius = 0.2\n')
    (capsule,) = capsules_of(tmp_path)
    assert (capsule.frame, capsule.radius, capsule.end[2]) == ("hand", 0.2, 1.0)


@pytest.mark.parametrize(
    ("toml", "words"),
    [
        ("from = [0, 0, 0]\nto = [0, 0, 1]\nradius = 0.2\n", "frame="),
        ('link = "hand"\nfrom = [0, 0, 0]\nto = [0, 0, 1]\nradius = -1\n', "positive"),
        ('link = "hand"\nfrom = [0, 0]\nto = [0, 0, 1]\nradius = 1\n', "shape"),
        ('link = "hand"\nfrom = [0, 0, 0]\nto = [0, 0, 1]\nradius = 1\nname = 2\n', "keys link, from, to, radius"),
    ],
)
def test_a_wrong_table_is_named(tmp_path, toml, words):
    (tmp_path / "robot.toml").write_text(f"[[collision.capsules]]\n{toml}")
    with pytest.raises(ModelError, match=words) as refusal:
        capsules_of(tmp_path)
    assert tmp_path.name in str(refusal.value)


def test_a_source_that_cannot_be_used_is_named(tmp_path):
    with pytest.raises(ModelError, match=r"no arm or hand 'wam8'.*wam7"):
        capsules_of("wam8")
    with pytest.raises(ModelError, match=r"nothing.*existing"):
        capsules_of(tmp_path / "nothing.urdf")
    bare = tmp_path / "bare.urdf"
    bare.write_text('<robot name="bare"><link name="base"/></robot>')
    with pytest.raises(ModelError, match="no collision geometry"):
        capsules_of(bare)
    lost = tmp_path / "lost.urdf"
    mesh = '<mesh filename="package://nowhere/link.stl"/>'
    lost.write_text(ROBOT.format("", mesh))
    with pytest.raises(ModelError, match=r"folders=\[...\]"):
        capsules_of(lost)
    broken = tmp_path / "broken.urdf"
    broken.write_text("<robot")
    with pytest.raises(ModelError, match="not XML"):
        capsules_of(broken)
