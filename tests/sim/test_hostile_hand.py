"""The folder of a hand from a stranger: it reads nothing outside itself, and runs no code of its own."""

import os
import struct

import pytest

from own_hand import SCOOP, write_hand
from pilegrasp_ctrl.exceptions import ConfigurationError, ModelError
from pilegrasp_ctrl.sim.hand import Hand

BODY = '<body><geom name="inner" type="sphere" size="0.01"/></body>'


def tetrahedron(size=0.02):
    """Return a binary STL."""
    corners = [(0.0, 0.0, 0.0), (size, 0.0, 0.0), (0.0, size, 0.0), (0.0, 0.0, size)]
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    rows = (struct.pack("<12fH", 0.0, 0.0, 0.0, *sum((corners[i] for i in face), ()), 0) for face in faces)
    return b"\0" * 80 + struct.pack("<I", len(faces)) + b"".join(rows)


def with_mesh(path, compiler=""):
    """Return the scoop with a mesh from `path`."""
    asset = f'{compiler}<asset><mesh name="part" file="{path}"/></asset><default>'
    return SCOOP.replace("<default>", asset).replace("</body>", '<geom name="part" type="mesh" mesh="part"/></body>')


def with_include(path):
    return SCOOP.replace("</body>", f'<include file="{path}"/></body>')


def test_meshes_and_includes_inside_the_folder_are_read(tmp_path):
    folder = write_hand(tmp_path / "scoop", {}, with_mesh("part.stl", '<compiler meshdir="meshes"/>'))
    (folder / "meshes").mkdir()
    (folder / "meshes" / "part.stl").write_bytes(tetrahedron())
    assert "hand_part" in Hand.load(folder).contact_geoms
    (folder / "parts").mkdir()
    (folder / "parts" / "more.xml").write_text(f"<mujocoinclude>{BODY}</mujocoinclude>", encoding="utf-8")
    write_hand(folder, {}, with_include("parts/more.xml"))
    assert "hand_inner" in Hand.load(folder).contact_geoms


OUTSIDE = {
    "mesh above": lambda place: with_mesh("../part.stl"),
    "absolute mesh": lambda place: with_mesh(place / "part.stl"),
    "meshdir above": lambda place: with_mesh("part.stl", '<compiler meshdir=".."/>'),
    "assetdir above": lambda place: with_mesh("part.stl", '<compiler assetdir=".."/>'),
    "absolute meshdir": lambda place: with_mesh("part.stl", f'<compiler meshdir="{place}"/>'),
    "include above": lambda place: with_include("../more.xml"),
    "absolute include": lambda place: with_include(place / "more.xml"),
    "link to a mesh": lambda place: with_mesh("link.stl"),
    "link to a folder": lambda place: with_include("links/more.xml"),
}


@pytest.mark.parametrize("way", OUTSIDE)
def test_a_path_that_leads_outside_is_refused_in_one_sentence(tmp_path, way):
    (tmp_path / "part.stl").write_bytes(tetrahedron())
    (tmp_path / "more.xml").write_text(f"<mujoco>{BODY}</mujoco>", encoding="utf-8")
    folder = write_hand(tmp_path / "scoop", {}, OUTSIDE[way](tmp_path))
    os.symlink(tmp_path / "part.stl", folder / "link.stl")
    os.symlink(tmp_path, folder / "links")
    with pytest.raises(ModelError, match="leads out of the folder of the model; put the file into the folder") as error:
        Hand.load(folder).use  # noqa: B018
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "element",
    [
        '<asset><hfield name="h" file="../h.png" size="1 1 1 1"/></asset>',
        '<asset><model name="m" file="../other.xml"/></asset>',
        '<asset><skin name="s" file="../s.skn"/></asset>',
        '<asset><texture name="t" type="cube" fileright="../t.png"/></asset>',
    ],
)
def test_other_elements_name_no_file(tmp_path, element):
    folder = write_hand(tmp_path / "scoop", {}, SCOOP.replace("<default>", f"{element}<default>"))
    with pytest.raises(ModelError, match="names a file; only mesh, texture and include may"):
        Hand.load(folder).use  # noqa: B018


def test_an_include_of_itself_ends(tmp_path):
    folder = write_hand(tmp_path / "scoop", {}, with_include("scoop.xml"))
    with pytest.raises(ModelError, match="includes itself"):
        Hand.load(folder).use  # noqa: B018


def test_a_link_in_place_of_robot_toml_is_refused(tmp_path):
    folder = write_hand(tmp_path / "real")
    (tmp_path / "fake").mkdir()
    os.symlink(folder / "robot.toml", tmp_path / "fake" / "robot.toml")
    with pytest.raises(ModelError, match=r"its robot.toml is a link that leads out of the folder"):
        Hand.load(tmp_path / "fake")


@pytest.mark.parametrize("place", ["folder", "working directory"])
def test_a_builder_beside_the_hand_is_never_run(tmp_path, monkeypatch, place):
    changes = {"hand.mjcf": None, "hand.builder": "evil_builder:build", "hand.tool_frame": "edge"}
    folder = write_hand(tmp_path / "scoop", changes)
    code = f"open({str(tmp_path / 'was_run')!r}, 'w').close()\ndef build(*a): pass\n"
    inside = folder if place == "folder" else tmp_path
    (inside / "evil_builder.py").write_text(code, encoding="utf-8")
    monkeypatch.chdir(inside)
    with pytest.raises(ConfigurationError, match=r"no module 'evil_builder' is in .* by --plugins DIR"):
        Hand.load(folder).use  # noqa: B018
    assert not (tmp_path / "was_run").exists()
