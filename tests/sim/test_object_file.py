"""Object files: every shape loads, errors are one sentence, and the contents count in the hash."""

import math

import mujoco
import numpy as np
import pytest
from scipy.spatial import ConvexHull

from object_worlds import BRICK, compile_objects, settled_poses, write_ball, write_mesh
from pilegrasp_ctrl.config import build_scenario, load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.hull import MAX_VERTICES
from pilegrasp_ctrl.sim.object_file import read_object, write_object
from pilegrasp_ctrl.sim.objects import object_model, objects_of
from pilegrasp_ctrl.sim.readout import drawn_bodies
from pilegrasp_ctrl.sim.scene import build_scene


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def of_points(points, mass):
    """Moments of inertia of a cloud of equal masses about its centre, as an independent check of the formulas."""
    points = points - points.mean(axis=0)
    squares = (points**2).mean(axis=0)
    return mass * (squares.sum() - squares)


SHAPES = {
    "sphere": ({"radius": 0.02}, 4.0 / 3.0 * math.pi * 0.02**3),
    "ellipsoid": ({"radii": [0.02, 0.025, 0.03]}, 4.0 / 3.0 * math.pi * 0.02 * 0.025 * 0.03),
    "capsule": ({"radius": 0.02, "length": 0.07}, math.pi * 0.02**2 * (0.03 + 4.0 / 3.0 * 0.02)),
    "cylinder": ({"radius": 0.02, "length": 0.05}, math.pi * 0.02**2 * 0.05),
    "box": ({"edges": [0.03, 0.04, 0.05]}, 0.03 * 0.04 * 0.05),
    "mesh": ({"file": "brick.obj", "unit": "mm"}, 0.04 * 0.06 * 0.03),
}


def test_the_inertia_of_a_capsule_is_that_of_its_points(tmp_path):
    objects = read_object(write_ball(tmp_path, shape="capsule", length=0.09))
    assert objects.half_size == pytest.approx((0.02, 0.025))
    assert objects.bounding_radius == pytest.approx(0.045)
    assert objects.diameter == pytest.approx(0.04)
    points = np.random.default_rng(0).uniform(-1.0, 1.0, size=(400_000, 3)) * [0.02, 0.02, 0.045]
    beyond = np.maximum(np.abs(points[:, 2]) - 0.025, 0.0)
    inside = points[np.hypot(np.hypot(points[:, 0], points[:, 1]), beyond) < 0.02]
    np.testing.assert_allclose(objects.solid_inertia(), of_points(inside, 0.03), rtol=0.01)


@pytest.mark.parametrize("shape", SHAPES)
def test_every_shape_loads_and_its_volume_and_inertia_are_mujocos(tmp_path, shape):
    sizes, volume = SHAPES[shape]
    write_mesh(tmp_path / "brick.obj")
    (tmp_path / "thing.toml").write_text(
        "\n".join([f'shape = "{shape}"', "mass = 0.05", *(f"{k} = {v!r}" for k, v in sizes.items())]).replace("'", '"')
    )
    objects = read_object(tmp_path / "thing.toml")
    model = compile_objects(objects)
    assert model.body_mass[1] == 0.05
    by_mujoco = {}
    for quantity, value in (("mass", 0.05), ("density", 1.0)):
        spec = mujoco.MjSpec()
        objects.add_to(spec, 0, (1, 1, 1, 1))
        spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
        setattr(spec.geoms[0], quantity, value)
        by_mujoco[quantity] = spec.compile()
    theirs = by_mujoco["mass"].body_inertia[1]
    np.testing.assert_allclose(np.sort(model.body_inertia[1]), np.sort(theirs), rtol=1e-6)
    assert by_mujoco["density"].body_mass[1] == pytest.approx(volume, rel=1e-6)


def test_a_mesh_is_placed_about_its_centre_of_mass_and_drawn(tmp_path):
    write_mesh(tmp_path / "brick.obj")
    objects = read_object(write_object(tmp_path / "m.toml", shape="mesh", file="brick.obj", unit="mm", mass=0.05))
    assert objects.half_size == pytest.approx((0.015, 0.02, 0.03), rel=1e-6)
    assert objects.diameter == pytest.approx(0.03)
    assert objects.bounding_radius == pytest.approx(math.hypot(0.015, 0.02, 0.03))
    model = compile_objects(objects, 2)
    np.testing.assert_allclose(model.body_ipos, 0.0, atol=1e-9)
    assert objects.scaled(2.0).half_size == pytest.approx((0.03, 0.04, 0.06), rel=1e-6)
    doubled = compile_objects(objects.scaled(2.0))
    np.testing.assert_allclose(np.sort(doubled.body_inertia[1]), 4.0 * np.sort(model.body_inertia[1]), rtol=1e-6)
    scenario = load_scenario("spheres_wall", {"pile.count": 2})
    layout = make_layout(scenario.support, scenario.pile, objects.diameter)
    bodies, _ = drawn_bodies(build_scene(scenario, Hand.load("shovel"), objects, layout))
    drawn = [body for body in bodies if body.role == "object"]
    assert len(drawn) == 2
    (shape,) = drawn[0].shapes
    assert (shape.kind, len(shape.vertices), len(shape.faces)) == ("mesh", 8, 12)
    assert sorted(shape.size) == pytest.approx([0.015, 0.02, 0.03], rel=1e-4)


def test_a_hull_has_at_most_two_hundred_vertices_and_nearly_its_volume(tmp_path):
    points = np.random.default_rng(0).normal(size=(1000, 3))
    points *= 20.0 / np.linalg.norm(points, axis=1, keepdims=True)
    write_mesh(tmp_path / "ball.obj", points, ConvexHull(points).simplices.tolist())
    file = write_object(tmp_path / "ball.toml", shape="mesh", file="ball.obj", unit="mm", mass=0.05)
    ball = read_object(file)
    assert len(ball.hull.vertices) == MAX_VERTICES == 200
    assert ball.volume == pytest.approx(4.0 / 3.0 * math.pi * 0.02**3, rel=0.05)


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"colour": "red"}, r"a sphere has no key 'colour'; valid keys are"),
        ({"radii": [1, 1, 1]}, r"a sphere has no key 'radii'; did you mean 'radius'\?"),
        ({"radius": -0.02}, r"radius = -0.02 must be a number from 0.001 to 0.25 m"),
        ({"radius": 27}, r"radius = 27 must be a number from 0.001 to 0.25 m"),
        ({"radius": math.nan}, r"radius = nan must be a number"),
        ({"radius": True}, r"radius = True must be a number"),
        ({"mass": 0.0}, r"mass = 0.0 must be a number from 0.001 to 5 kg"),
        ({"shape": "cone"}, r"shape = 'cone' must be one of 'sphere', "),
        ({"shape": "box"}, r"a box has no key 'radius'"),
        ({"restitution": 1.2}, r"restitution = 1.2 must be a number from 0 to 1"),
        ({"inertia_factor": 9.0}, r"inertia_factor = 9.0 must be a number from 0.1 to 2"),
        ({"friction": {"lateral": -1.0}}, r"friction.lateral = -1.0 must be a number from 0 to 5"),
        ({"friction": {"slip": 1.0}}, r"\[friction\] has no key 'slip'"),
        ({"friction": 0.5}, r"friction = 0.5 must be a table"),
        ({"sim": {"radios": 0.02}}, r"\[sim\] of a sphere has no key 'radios'; did you mean 'radius'\?"),
        ({"sim": {"radius": 2.0}}, r"radius = 2.0 must be a number"),
        ({"net": {"members": 1, "loop": 1.0}}, r"net.members = 1 must be an integer from 2 to 12"),
        (
            {"net": {"members": 3, "loop": 0.1}},
            r"net.loop = 0.1 is too short for 3 objects side by side; at least 0.124",
        ),
        ({"net": {"members": 3}}, r"the key 'net.loop' is missing"),
        ({"shape": "capsule", "length": 0.04}, r"length = 0.04 must be more than twice the radius"),
    ],
)
def test_a_wrong_key_is_one_sentence(tmp_path, keys, sentence):
    with pytest.raises(ConfigurationError, match=sentence) as error:
        write_ball(tmp_path, **keys)
    assert "\n" not in str(error.value)
    assert not list(tmp_path.glob("*.toml"))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (None, "no such file of an object"),
        ("radius = ", "is not valid TOML"),
        ('shape = "sphere"\nmass = 0.1', "the key 'radius' is missing"),
        ('shape = "sphere"\nradius = 0.02', "the key 'mass' is missing"),
        ('shape = "box"\nmass = 0.1\nedges = [0.1, 0.1]', "must be a list of 3 lengths in m"),
        (
            'shape = "box"\nmass = 0.1\nedges = [0.1, 0.1, 0.6]',
            r"edges\[2\] = 0.6 must be a number from 0.002 to 0.5 m",
        ),
    ],
)
def test_a_wrong_file_is_one_sentence_with_its_name(tmp_path, text, sentence):
    file = tmp_path / "egg.toml"
    if text is not None:
        file.write_text(text)
    with pytest.raises(ConfigurationError, match=f"egg.toml: .*{sentence}"):
        object_model(str(file))


FLAT = [(0, 0, 0), (40, 0, 0), (0, 40, 0), (40, 40, 0)]


@pytest.mark.parametrize(
    ("name", "keys", "sentence"),
    [
        ("nowhere.stl", {}, r"nowhere.stl: no such mesh; its path is relative to the object's file$"),
        ("flat.obj", {}, r"flat.obj: the mesh is not the closed surface of a body: 4 of its edges"),
        ("flat.obj", {"hull": True}, r"flat.obj: cannot be used as a mesh; .* coplanar"),
        ("text.stl", {}, r"text.stl: cannot be (read|used) as"),
        ("brick.ply", {}, r"brick.ply: a mesh must be one of .stl, .obj"),
        ("brick.obj", {"unit": "m"}, r"the mesh measures 30 to 60 m across, .* check unit and scale"),
        ("brick.obj", {"unit": "foot"}, r"unit = 'foot' must be one of 'm', 'cm', 'mm', 'in'"),
        ("brick.obj", {"scale": 0.0}, r"scale = 0.0 must be a number from 0.0001 to 10000"),
    ],
)
def test_a_mesh_that_cannot_be_used_is_one_sentence(tmp_path, name, keys, sentence):
    write_mesh(tmp_path / "brick.obj")
    write_mesh(tmp_path / "flat.obj", FLAT, [(0, 1, 2), (1, 3, 2)])
    (tmp_path / "text.stl").write_text("solid nothing\n" + 100 * " ")
    with pytest.raises(ConfigurationError, match=sentence) as error:
        write_object(tmp_path / "m.toml", **({"shape": "mesh", "file": name, "unit": "mm", "mass": 0.05} | keys))
    assert "\n" not in str(error.value)


def test_a_stated_restitution_is_fixed_and_the_papers_follows_the_mass(tmp_path):
    stiff = str(write_ball(tmp_path, "stiff", restitution=0.1, friction={"lateral": 0.2}))
    assert object_model(stiff, mass=0.06).surface.restitution == 0.1
    assert object_model(stiff).surface.lateral == 0.2
    assert object_model(stiff).surface.rolling == 0.001
    plain = str(write_ball(tmp_path, "plain"))
    assert object_model(plain, mass=0.06).surface.restitution == pytest.approx(0.72)


def test_a_file_can_have_the_variants_of_table_one(tmp_path):
    file = str(write_ball(tmp_path, sim={"radius": 0.03}))
    assert object_model(file).half_size == (0.02,)
    assert object_model(file, variant="sim").half_size == (0.03,)
    with pytest.raises(ConfigurationError, match=r"has no variant 'literal'; pile\.variant can be 'real' or 'sim'$"):
        object_model(file, variant="literal")


def test_the_hash_of_a_scenario_depends_on_the_content_of_object_and_mesh(tmp_path):
    def digest():
        return build_scenario({"pile": {"object": str(tmp_path / "thing.toml")}}).config_hash()

    write_mesh(tmp_path / "brick.obj")
    write_ball(tmp_path)
    first = digest()
    write_ball(tmp_path, radius=0.021)
    assert digest() != first
    write_ball(tmp_path)
    assert digest() == first
    write_object(tmp_path / "thing.toml", shape="mesh", file="brick.obj", unit="mm", mass=0.05)
    brick = digest()
    write_mesh(tmp_path / "brick.obj", [(x + 1, y, z) if x else (x, y, z) for x, y, z in BRICK])
    assert digest() != brick
    (tmp_path / "brick.obj").unlink()
    with pytest.raises(ConfigurationError, match=r"brick\.obj: cannot be read: No such file"):
        digest()
    variants = {load_scenario("spheres_wall", {"pile.variant": v}).config_hash() for v in ("real", "sim", "literal")}
    assert len(variants) == 3


def test_the_path_of_an_object_is_relative_to_the_scenario_file(tmp_path, monkeypatch):
    write_ball(tmp_path, "pea")
    (tmp_path / "peas.toml").write_text('[pile]\nobject = "pea.toml"\n')
    objects = objects_of(load_scenario(tmp_path / "peas.toml").pile)
    assert (objects.name, objects.half_size) == ("pea", (0.02,))
    monkeypatch.chdir(tmp_path)
    assert objects_of(load_scenario("spheres_wall", {"pile.object": "pea.toml"}).pile) == objects


@pytest.mark.parametrize("shape", ["capsule", "mesh"])
def test_a_users_object_settles(tmp_path, shape):
    write_mesh(tmp_path / "brick.obj")
    file = write_object(tmp_path / "thing.toml", shape=shape, mass=0.05, **SHAPES[shape][0])
    objects = object_model(str(file))
    poses = settled_poses(objects, 6)
    assert poses[:, 2].min() > 0.5 * objects.diameter - 0.001
    assert poses[:, 2].max() < 0.2
    other = object_model(str(file), scale=1.1)
    assert np.abs(settled_poses(other, 6) - poses).max() > 1e-3


def test_a_mix_of_files_counts_in_the_hash_with_their_content(tmp_path):
    (tmp_path / "pea.toml").write_text('shape = "sphere"\nradius = 0.02\nmass = 0.02\n')
    (tmp_path / "mix.toml").write_text('[pile]\nobject = "pea.toml+cube"\n')
    mixed = load_scenario(tmp_path / "mix.toml")
    before = mixed.config_hash()
    assert [each.name for each in objects_of(mixed.pile).object_models] == ["pea", "cube"]
    (tmp_path / "pea.toml").write_text('shape = "sphere"\nradius = 0.02\nmass = 0.03\n')
    assert mixed.config_hash() != before


def test_a_plus_in_the_name_of_a_folder_is_part_of_the_path(tmp_path):
    folder = tmp_path / "c++"
    folder.mkdir()
    (folder / "pea.toml").write_text('shape = "sphere"\nradius = 0.02\nmass = 0.02\n')
    (folder / "peas.toml").write_text('[pile]\nobject = "pea.toml"\n')
    scenario = load_scenario(folder / "peas.toml")
    assert objects_of(scenario.pile).name == "pea"
    assert len(scenario.config_hash()) == 16
