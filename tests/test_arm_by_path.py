"""A scenario takes an arm by the path of its folder."""

import shutil

import pytest

import pilegrasp_ctrl as pg
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.exceptions import PilegraspError
from pilegrasp_ctrl.planning.arm_room import default_room, stated_room
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.robots import description, path


@pytest.fixture
def folder(tmp_path):
    made = tmp_path / "arms" / "mine"
    shutil.copytree(path("panda"), made)
    return made


def scenario_beside(folder, robot="arms/mine", program="line"):
    file = folder.parents[1] / "scene.toml"
    file.write_text(f'program = "{program}"\nrobot = "{robot}"\n[pile]\ncount = 0\n[line]\nstart = [0.5, -0.1, 0.25]\n')
    return file


def test_the_path_is_relative_to_the_scenario_and_an_override_to_the_working_directory(folder, monkeypatch):
    scenario = load_scenario(scenario_beside(folder))
    assert scenario.robot == str(folder)
    monkeypatch.chdir(folder.parent)
    other = load_scenario("free_space_line", {"robot": "./mine", "pile.count": 0, "line.start": [0.5, -0.1, 0.25]})
    assert other.robot == "./mine"
    assert other.config_hash() == scenario.model_copy(update={"support": other.support}).config_hash()


def test_the_folder_counts_by_its_content(folder):
    scenario = load_scenario(scenario_beside(folder))
    before = scenario.config_hash()
    (folder / "README.md").write_text("other words")
    assert scenario.config_hash() == before
    text = (folder / "robot.toml").read_text()
    (folder / "robot.toml").write_text(text.replace("0.273", "0.300"))
    assert scenario.config_hash() != before


@pytest.mark.slow
def test_a_copy_of_the_panda_gives_the_attempt_of_the_panda(folder):
    mine = pg.run(load_scenario(scenario_beside(folder)), seed=1)
    shipped = pg.run(load_scenario(scenario_beside(folder), {"robot": "panda"}), seed=1)
    assert mine.sim_time == shipped.sim_time
    assert [each.peak_force for each in mine.outcomes] == [each.peak_force for each in shipped.outcomes]
    assert mine.success


@pytest.mark.slow
def test_an_arm_that_states_no_room_and_no_postures_gets_those_of_its_model(folder):
    text = (folder / "robot.toml").read_text()
    kept, _, rest = text.partition("[postures]")
    (folder / "robot.toml").write_text(kept + rest[rest.index("# Capsules") :])
    assert stated_room(f"{folder}/") is None
    attempt = prepare(load_scenario("spheres_wall", {"robot": str(folder), "pile.count": 3}), seed=0)
    assert attempt.plan.start.translation[0] > 0.1


def test_the_wams_numbers_are_in_its_file():
    room = default_room()
    assert stated_room("wam7") == room
    assert description("wam7")["room"]["reach"] == list(room.reach) == [1.04, 1.02, 1.0, 0.98, 0.96, 0.92]
    assert (room.base_below_table, room.wall_distance, room.push_end) == (0.25, 1.0, 0.94)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("push_end = 0.84", "push_end = -1", "push_end = -1 must be a length from 0 to 10 m"),
        ("push_end = 0.84", "push_ends = 0.84", "unknown key 'push_ends'; did you mean 'push_end'"),
        ("reach = [0.92,", "reach = [0.82,", "must be a list of lengths, the longest first"),
        ("max_touch_distance = 0.54", "max_touch_distance = 0.94", "< every reach must hold"),
        ("base_radius = 0.18", "# base_radius", "base_radius = None must be a length"),
    ],
)
def test_a_wrong_room_is_named(folder, old, new, words):
    text = (folder / "robot.toml").read_text()
    assert old in text
    (folder / "robot.toml").write_text(text.replace(old, new))
    with pytest.raises(PilegraspError, match=words):
        stated_room(f"{folder}/")


@pytest.mark.parametrize(
    ("robot", "words"),
    [
        ("pandas", "no robot 'pandas'; choose from panda, wam7"),
        ("./nowhere", r"nowhere: is no folder that holds a robot\.toml"),
        ("arms", r"or give the path of a folder, with a slash"),
    ],
)
def test_an_arm_that_does_not_exist_is_refused_in_a_sentence(folder, robot, words, monkeypatch):
    monkeypatch.chdir(folder.parents[1])
    with pytest.raises(PilegraspError, match=words):
        prepare(load_scenario(scenario_beside(folder, robot)), seed=0)
