"""Meshes that are not convex: their integrals, their convex pieces, how they are drawn, and what is refused."""

import json

import mujoco
import numpy as np
import pytest

from brackets import DEPTH, FACES, PLATES, VERTICES, store, write_bracket
from command_line import answer, one_sentence
from object_worlds import compile_objects, write_ball
from pilegrasp_ctrl.config import build_scenario, load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError, RecordingError
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.programs.notes import notes_on
from pilegrasp_ctrl.recording import Recording
from pilegrasp_ctrl.recording_parts import Body, Shape
from pilegrasp_ctrl.scenarios import PIECES_SUFFIX
from pilegrasp_ctrl.sim import pieces, triangles
from pilegrasp_ctrl.sim.hand import Hand
from pilegrasp_ctrl.sim.hull import Hull
from pilegrasp_ctrl.sim.object_file import read_object
from pilegrasp_ctrl.sim.objects import objects_of, own_frame, spread
from pilegrasp_ctrl.sim.readout import drawn_bodies
from pilegrasp_ctrl.sim.scene import build_scene
from pilegrasp_ctrl.sim.solid import Solid
from pilegrasp_ctrl.validation.check.part import check_part
from pilegrasp_ctrl.viewer.scene.shapes import body_object


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def of_boxes(boxes):
    """Volume, centre and second moments about it of boxes that touch, each with its low and high corner."""
    parts = [(np.prod(high - low), 0.5 * (low + high), high - low) for low, high in boxes]
    volume = sum(part[0] for part in parts)
    center = sum(part[0] * part[1] for part in parts) / volume
    second = np.zeros((3, 3))
    for each, middle, size in parts:
        second += each * (np.diag(size**2) / 12.0 + np.outer(middle - center, middle - center))
    return volume, center, second


@pytest.mark.parametrize("sense", [1, -1], ids=["outward", "inward"])
@pytest.mark.parametrize("shift", [0.0, 1000.0])
def test_the_integrals_of_a_polyhedron_are_exact(sense, shift):
    vertices, faces = np.array(VERTICES, dtype=float) + shift, np.array(FACES)[:, ::sense]
    mesh = triangles.close(vertices, faces)
    volume, center, second = of_boxes([(plate.min(axis=0) + shift, plate.max(axis=0) + shift) for plate in PLATES])
    assert mesh.volume == pytest.approx(volume, rel=1e-12)
    np.testing.assert_allclose(mesh.center, center, rtol=1e-12)
    np.testing.assert_allclose(mesh.inertia, (np.trace(second) * np.eye(3) - second) / volume, rtol=1e-9)
    axes, moments = mesh.principal_axes()
    np.testing.assert_allclose(axes.T @ mesh.inertia @ axes, np.diag(moments), atol=1e-9 * max(moments))


def test_triangles_of_different_senses_are_turned():
    faces = np.array(FACES)
    faces[::3] = faces[::3, ::-1]
    assert triangles.close(np.array(VERTICES, dtype=float), faces).volume == pytest.approx(95 * 5 * DEPTH)


def test_a_bracket_has_the_mass_and_inertia_of_the_real_solid_and_its_pieces(tmp_path):
    bracket = read_object(write_bracket(tmp_path))
    assert isinstance(bracket.hull, Solid)
    assert bracket.hull.stored
    assert bracket.volume == pytest.approx(1e-9 * 95 * 5 * DEPTH)
    volume, _, second = of_boxes([(plate.min(axis=0), plate.max(axis=0)) for plate in PLATES])
    inertia = 0.11 * 1e-6 * np.linalg.eigvalsh(np.trace(second) * np.eye(3) - second) / volume
    np.testing.assert_allclose(sorted(bracket.solid_inertia()), inertia, rtol=1e-9)
    model = compile_objects(bracket)
    assert [model.geom(geom).name for geom in range(model.ngeom)] == ["object_0", "object_0_1", "object_0_drawn"]
    np.testing.assert_allclose(sorted(model.body_inertia[1]), inertia, rtol=1e-6)
    np.testing.assert_allclose(model.body_ipos[1], 0.0, atol=1e-9)
    assert read_object(write_bracket(tmp_path), "real").scaled(2.0).volume == pytest.approx(8.0 * bracket.volume)


def test_a_ball_lies_in_the_notch_that_the_hull_would_fill(tmp_path):
    """Its middle is 10 mm from both plates, which are 5 mm thick, and within the hull."""
    distances = {}
    for as_hull in (False, True):
        bracket = read_object(write_bracket(tmp_path, hull=as_hull))
        model = compile_objects(bracket)
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        center = triangles.close(np.array(VERTICES, dtype=float), np.array(FACES))
        axes = center.principal_axes()[0]
        point = 1e-3 * axes.T @ (np.array([15.0, 15.0, 15.0]) - center.center)
        inside = []
        for geom in range(model.ngeom):
            if model.geom(geom).name.endswith("drawn"):
                continue
            mesh = model.geom_dataid[geom]
            first, corner = model.mesh_vertadr[mesh], model.mesh_faceadr[mesh]
            vertices = model.mesh_vert[first : first + model.mesh_vertnum[mesh]].astype(float)
            faces = model.mesh_face[corner : corner + model.mesh_facenum[mesh]]
            vertices = vertices @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
            a, b, c = (vertices[faces[:, k]] for k in range(3))
            normals = np.cross(b - a, c - a)
            inside.append((((point - a) * normals).sum(axis=1) / np.linalg.norm(normals, axis=1)).max())
        distances[as_hull] = min(inside)
    assert distances[False] == pytest.approx(0.010, abs=2e-4)
    assert distances[True] < -0.005


def test_the_page_draws_the_bracket_as_it_is(tmp_path):
    file = write_bracket(tmp_path)
    scenario = load_scenario("spheres_wall", {"pile.object": str(file), "pile.count": 2})
    objects = objects_of(scenario.pile)
    layout = make_layout(scenario.support, scenario.pile, objects.diameter)
    bodies, _ = drawn_bodies(build_scene(scenario, Hand.load("shovel"), objects, layout))
    drawn = [body for body in bodies if body.role == "object"]
    assert [len(body.shapes) for body in drawn] == [1, 1]
    shape = drawn[0].shapes[0]
    assert (shape.kind, len(shape.vertices), len(shape.faces)) == ("mesh", 12, 20)
    sides = np.array(shape.vertices)[:, None, :] - np.array(shape.vertices)[None, :, :]
    assert np.linalg.norm(sides, axis=2).max() == pytest.approx(1e-3 * np.linalg.norm([50, 50, DEPTH]), rel=1e-3)
    group = body_object(drawn[0])
    corners = [len(each["data"]["attributes"]["position"]["array"]) // 9 for each in group["geometries"]]
    assert sum(corners) == 20
    assert all(corners)
    again = Shape(**json.loads(json.dumps(shape.as_dict())))
    assert again == shape
    assert "vertices" not in Shape("sphere", (0.1,)).as_dict()
    assert Body("b", "object", (again,)).shapes[0].half_extents() == shape.size


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"faces": [(0, 1, 99)]}, "names a vertex"),
        ({"faces": [(0, 1)]}, "not lists of three numbers"),
        ({"vertices": [(0.0, 0.0, np.nan)] * 3}, "vertices of a mesh"),
        ({"kind": "sphere"}, "only a mesh has them"),
    ],
)
def test_a_recorded_mesh_that_is_none_is_refused(keys, sentence):
    good = {"kind": "mesh", "size": (1, 1, 1), "vertices": [(0, 0, 0), (1, 0, 0), (0, 1, 0)], "faces": [(0, 1, 2)]}
    Shape(**good)
    with pytest.raises(RecordingError, match=sentence):
        Shape(**(good | keys))


def hash_of(file, **pile):
    return build_scenario({"pile": {"object": str(file)} | pile}).config_hash()


def test_stored_pieces_count_in_the_hash_and_hull_true_is_the_former_behaviour(tmp_path):
    file = write_bracket(tmp_path)
    stored = hash_of(file)
    store(tmp_path / "bracket.obj", PLATES[::-1])
    assert hash_of(file) != stored
    (tmp_path / f"bracket.obj{PIECES_SUFFIX}").unlink()
    without = hash_of(file, frame_size=0.2)
    assert without != stored
    write_bracket(tmp_path, stored=False, hull=True)
    assert hash_of(file, frame_size=0.2) == without
    assert isinstance(read_object(file).hull, Hull)


def test_pieces_of_another_mesh_and_damaged_pieces_are_one_sentence(tmp_path):
    file = write_bracket(tmp_path)
    beside = tmp_path / f"bracket.obj{PIECES_SUFFIX}"
    text = beside.read_text()
    for changed, sentence in (
        (text.replace("# pieces of ", "# pieces of f")[:-1], "is not a file of convex pieces"),
        (text.replace(text[12:16], "0000", 1), "holds the pieces of another mesh"),
        (text.replace("v 0 0 0", "v 0 0 x"), "has a line that is not three numbers"),
        (text.replace("v 0 0 0", "v 0 0 nan"), "four finite corners"),
        (text.splitlines()[0] + "\n", "four finite corners"),
    ):
        beside.write_text(changed)
        with pytest.raises(ConfigurationError, match=sentence) as error:
            read_object(file)
        assert "make it anew by `pilegrasp check PART --write`" in str(error.value)


OPEN = FACES[:-1]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "bracket.obj: cannot be"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "bracket.obj: cannot be"),
        ("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "bracket.obj: cannot be"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n", "bracket.obj: the mesh has no volume"),
    ],
    ids=["empty", "no triangles", "nan", "flat"],
)
def test_a_mesh_that_is_no_body_is_one_sentence(tmp_path, text, sentence):
    file = write_bracket(tmp_path, stored=False, hull=True)
    file.write_text(file.read_text().replace("hull = true\n", ""))
    (tmp_path / "bracket.obj").write_text(text)
    with pytest.raises(ConfigurationError, match=sentence) as error:
        read_object(file)
    assert "\n" not in str(error.value)


def test_an_open_mesh_and_a_huge_one_are_one_sentence(tmp_path, monkeypatch):
    with pytest.raises(ConfigurationError, match=r"3 of its edges do not join two triangles; .* hull = true"):
        write_bracket(tmp_path, stored=False, faces=OPEN)
    monkeypatch.setattr(triangles, "MAX_TRIANGLES", 10)
    with pytest.raises(ConfigurationError, match="has 20 triangles, and 10 are allowed; reduce the mesh"):
        write_bracket(tmp_path)


def test_a_mesh_that_cannot_be_decomposed_in_time_is_one_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr(pieces, "TIME_LIMIT", 1e-3)
    with pytest.raises(ConfigurationError, match=r"is not decomposed within .* make hull = true"):
        write_bracket(tmp_path, stored=False)


@pytest.mark.slow
def test_pieces_are_made_once_noted_and_stored_on_demand(tmp_path):
    file = write_bracket(tmp_path, stored=False)
    made = read_object(file)
    assert not made.hull.stored
    assert made.hull.pieces == read_object(file).hull.pieces
    (note,) = notes_on(Hand.load("shovel"), made, 3)
    assert "convex pieces were made on this machine" in note
    before = hash_of(file)
    report = check_part(file, write=True)
    assert [path.name for path in report.written] == [f"bracket.obj{PIECES_SUFFIX}"]
    assert any("convex pieces, stored beside the mesh" in sentence for sentence in report.sentences)
    kept = read_object(file)
    assert kept.hull.stored
    assert kept == made
    assert hash_of(file) != before
    assert notes_on(Hand.load("shovel"), kept, 3) == ()


@pytest.mark.slow
def test_the_verb_stores_the_pieces_and_says_what_the_part_is(tmp_path, capsys):
    file = write_bracket(tmp_path, stored=False, mass=1.2)
    status, out, _ = answer(capsys, "check", file, "--write", "--json")
    found = {each["about"]: each for each in json.loads(out)["findings"]}
    assert status == 0
    assert found["pieces"]["text"].startswith(str(tmp_path / f"bracket.obj{PIECES_SUFFIX}"))
    assert "2 convex pieces, stored beside the mesh" in found["contacts"]["text"]
    assert found["payload"]["level"] == "note"
    assert read_object(file).hull.stored


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("bracket.obj",), "is a mesh; write an object's file with shape = 'mesh'"),
        (("bracket.toml", "--write", "elsewhere"), "stand beside its mesh; leave the folder out"),
        (("light_sphere", "--write"), "needs the .toml file of an object of yours"),
        (("bracket.toml", "--seed", "3"), "--seed is for a scenario"),
    ],
)
def test_a_check_of_a_part_that_cannot_be_made_is_one_sentence(tmp_path, capsys, monkeypatch, arguments, sentence):
    write_bracket(tmp_path)
    monkeypatch.chdir(tmp_path)
    status, _, err = answer(capsys, "check", *arguments)
    assert status == 2
    assert sentence in err
    assert one_sentence(err)


def test_a_check_tells_size_density_and_where_the_numbers_come_from(tmp_path):
    report = check_part(write_bracket(tmp_path, mass=5.0))
    assert "350" in report.sentences[0].replace(".", "")
    assert "restitution is 0.00, from its mass" in report.sentences[2]
    assert "that of smooth wood" in report.sentences[3]
    assert report.warnings == ("a density of 3.51e+05 kg/m³ is that of no material; check mass, unit and scale",)
    assert report.written == ()


def test_a_part_that_is_heavier_than_the_hand_was_measured_to_hold_is_noted():
    heavy = objects_of(build_scenario({}, {"pile.mass": 1.2}).pile)
    hand = Hand.load("rbo_hand2")
    assert notes_on(hand, heavy, 3) == (
        "an object of 1.2 kg is heavier than the 0.74 kg that rbo_hand2 was measured to hold",
    )
    assert notes_on(hand, objects_of(build_scenario({}).pile), 3) == ()
    assert notes_on(hand, heavy, 0) == ()


def test_objects_of_a_kind_differ_by_the_spread_and_the_seed_alone():
    pile = build_scenario({}, {"pile.spread.size": 0.1, "pile.spread.mass": 0.2, "pile.spread.friction": 0.3}).pile
    plain = objects_of(pile)
    first, again, other = (spread(plain, pile, seed).assign_models(18) for seed in (3, 3, 4))
    assert first == again != other
    for name, bound, read in (
        ("size", 0.1, lambda each: each.half_size[0] / plain.half_size[0]),
        ("mass", 0.2, lambda each: each.mass / plain.mass),
        ("friction", 0.3, lambda each: each.surface.lateral / plain.surface.lateral),
    ):
        factors = np.array([read(each) for each in first])
        assert np.abs(factors - 1.0).max() <= bound, name
        assert np.ptp(factors) > bound, name
    assert first[0].surface.restitution != plain.surface.restitution
    assert spread(plain, build_scenario({}).pile, 3) is plain
    assert build_scenario({}, {"pile.spread.size": 0.0}).config_hash() == build_scenario({}).config_hash()
    nets = build_scenario({}, {"pile.object": "lime_net", "pile.spread.mass": 0.1}).pile
    with pytest.raises(ConfigurationError, match=r"pile\.spread is for single objects"):
        spread(objects_of(nets), nets, 0)


def test_the_frame_grows_with_the_parts_of_a_file_and_not_with_those_that_ship(tmp_path):
    def frame(name, count=18, **more):
        pile = build_scenario({"pile": {"object": name, "count": count} | more}).pile
        return own_frame(pile, objects_of(pile))

    bracket, radius = str(write_bracket(tmp_path)), read_object(tmp_path / "bracket.toml").bounding_radius
    assert frame("apple") is None
    assert frame(bracket, frame_size=0.3) is None
    # Brackets are long and flat: in four layers of 18 they need three columns each way.
    assert frame(bracket) == pytest.approx(3 * 2.1 * radius)
    assert frame(bracket, count=1) == pytest.approx(2.1 * radius)
    small, large = (str(write_ball(tmp_path, name, radius=r)) for name, r in (("small", 0.008), ("large", 0.06)))
    assert frame(small) == pytest.approx(0.25 * 16.0 / 54.0)
    assert frame(large) == pytest.approx(0.25 * 120.0 / 54.0)
    assert frame(f"apple+{small}") == pytest.approx(0.25)
    assert frame(str(write_ball(tmp_path, "huge", radius=0.2))) == 0.6


def test_a_recording_keeps_meshes_and_says_so_by_its_version(tmp_path):
    mesh = Shape("mesh", (1, 1, 1), vertices=[(0, 0, 0), (1, 0, 0), (0, 1, 0)], faces=[(0, 1, 2)])
    for shape, version in ((mesh, 3), (Shape("sphere", (0.1,)), 2)):
        pose = {"body_position": np.zeros((1, 1, 3)), "body_quaternion": np.array([[[1.0, 0.0, 0.0, 0.0]]])}
        times = {"frame_time": [0.0], "signal_time": [0.0], "signals": {}}
        written = Recording(meta={"scenario": "s"}, bodies=(Body("b", "object", (shape,)),), **pose, **times)
        written.save(tmp_path / "a.npz")
        assert Recording.load(tmp_path / "a.npz").bodies == written.bodies
        with np.load(tmp_path / "a.npz") as arrays:
            assert json.loads(str(arrays["header"]))["version"] == version
