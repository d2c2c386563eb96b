"""`pilegrasp check` says what is missing, out of reach, in collision or too heavy, and makes the folder of an arm."""

import json
from xml.etree import ElementTree

import pytest

import pilegrasp_ctrl as pg
from command_line import answer, one_sentence
from pilegrasp_ctrl.exceptions import ExportError, ModelError
from pilegrasp_ctrl.robots import panda_urdf, path
from pilegrasp_ctrl.validation.check.arm_folder import write_arm_folder
from pilegrasp_ctrl.validation.check.registry import Subject, findings
from pilegrasp_ctrl.validation.check.subjects import kind_of

SCENARIO = 'robot = "{robot}"\nhand = "{hand}"\n[pile]\ncount = 3\n'


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return the folder of an arm that is made from the Panda's URDF, and what was said of it."""
    folder = tmp_path_factory.mktemp("arms") / "mine"
    return write_arm_folder(panda_urdf(), "panda_link8", 7, folder, ("shovel",))


def texts(subject, level):
    return [finding.text for finding in findings(subject) if finding.level == level]


@pytest.mark.slow
def test_a_folder_is_made_from_a_bare_urdf(made):
    arm, shipped = pg.ArmModel.load(made.folder), pg.ArmModel.load("panda")
    assert made.left_out == ("panda_hand",)
    assert arm.joint_names == shipped.joint_names
    assert arm.torque_limit.tolist() == shipped.torque_limit.tolist()
    assert arm.pinocchio_model.inertias[7].mass == pytest.approx(shipped.pinocchio_model.inertias[7].mass)
    assert any("no joint friction" in sentence for sentence in made.lacking)
    # Meshes stay behind, so that the folder stands alone.
    assert "mesh" not in (made.folder / "panda.urdf").read_text()
    with pytest.raises(ExportError, match="exists already"):
        write_arm_folder(panda_urdf(), "panda_link8", 7, made.folder)


@pytest.mark.slow
def test_a_made_folder_passes_the_check_and_its_reach_is_found_again(made):
    subject = Subject("arm", f"{made.folder}/", ("shovel",))
    assert texts(subject, "problem") == []
    facts = " ".join(texts(subject, "fact"))
    assert "its fingertips reach 0." in facts
    assert "holds up to" in facts


@pytest.mark.slow
def test_a_folder_is_made_from_a_bare_mjcf(tmp_path):
    done = write_arm_folder(path("wam7", "wam7.xml"), "flange", None, tmp_path / "wam", ("shovel",))
    arm, shipped = pg.ArmModel.load(done.folder), pg.ArmModel.load("wam7")
    assert arm.friction_coulomb.tolist() == shipped.friction_coulomb.tolist()
    assert pytest.approx(shipped.update([0.1] * 7, [0.2] * 7).M, abs=1e-5) == arm.update([0.1] * 7, [0.2] * 7).M
    assert list(ElementTree.parse(done.folder / "wam7.xml").find("worldbody").iter("geom")) == []


def test_a_weak_arm_is_told_what_it_cannot_carry_or_push(tmp_path):
    for file in path("panda").glob("*.toml"):
        text = file.read_text()
        (tmp_path / file.name).write_text(
            text.replace("friction_viscous", "torque_peak = [30, 40, 30, 20, 5, 5, 1]\nfriction_viscous")
        )
    problems = texts(Subject("arm", f"{tmp_path}/", ("shovel",)), "problem")
    assert any("pushes with up to" in text or "holds up to" in text for text in problems)


@pytest.mark.slow
def test_a_scenario_is_checked_with_its_planned_poses_and_a_picture(tmp_path, capsys):
    file, picture = tmp_path / "scene.toml", tmp_path / "poses.png"
    file.write_text(SCENARIO.format(robot="wam7", hand="shovel"))
    status, out, _ = answer(capsys, "check", file, "--picture", picture, "--json")
    document = json.loads(out)
    assert status == 0
    assert document["ok"]
    assert {finding["about"] for finding in document["findings"]} >= {"reach", "collision", "payload", "contacts"}
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_what_prevents_a_run_is_one_sentence_and_status_2(tmp_path, capsys):
    file = tmp_path / "scene.toml"
    file.write_text('program = "line"\n[line]\nstart = [1.9, 0.0, 0.25]\n[pile]\ncount = 0\n')
    status, _, error = answer(capsys, "check", file)
    assert status == 2
    assert one_sentence(error)
    assert "cannot reach (1.90, 0.00, 0.25) m" in error


def test_a_bare_model_without_a_tool_frame_names_its_frames():
    found = list(findings(Subject("model", str(panda_urdf()))))
    assert [finding.level for finding in found] == ["problem"]
    assert "give --tool-frame" in found[0].text
    assert "panda_link8" in found[0].text


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nothing"], "is no scenario, arm, hand or object"),
        (["spheres_wall", "--tool-frame", "flange"], "--tool-frame is for a bare URDF or MJCF, and this is a scenario"),
        (["wam7", "--picture", "F.png"], "--picture is for a scenario, and this is an arm"),
        ([str(panda_urdf()), "--write", "arm"], "--write needs --tool-frame"),
    ],
)
def test_an_option_that_does_not_fit_is_named(arguments, words, capsys):
    status, _, error = answer(capsys, "check", *arguments)
    assert status == 2
    assert words in error


def test_what_is_checked_is_told_by_its_name(tmp_path):
    assert [kind_of(name) for name in ("wam7", "shovel", "hands/shovel", "spheres_wall", "lime")] == [
        "arm",
        "hand",
        "hand",
        "scenario",
        "part",
    ]
    assert kind_of(str(path("panda"))) == "arm"
    assert kind_of(str(path("hands", "shovel"))) == "hand"
    assert kind_of(str(panda_urdf())) == "model"
    (tmp_path / "scene.toml").write_text("[pile]\ncount = 3\n")
    assert kind_of(str(tmp_path / "scene.toml")) == "scenario"


def test_a_tool_frame_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(ModelError, match="no frame 'tip' for the tool; the links are panda_link0"):
        write_arm_folder(panda_urdf(), "tip", 7, tmp_path / "arm")
