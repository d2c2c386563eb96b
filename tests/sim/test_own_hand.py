"""A hand of the user's own: a folder with an MJCF and a robot.toml."""

import mujoco
import numpy as np
import pytest

from own_hand import SCOOP, write_hand
from pilegrasp_ctrl.config import Scenario, build_scenario, load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError, ModelError
from pilegrasp_ctrl.plugins import use_plugins
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.sections import HandModelConfig
from pilegrasp_ctrl.sim.hand import Hand

GRIPPER = """\
<mujoco>
  <worldbody>
    <body name="left" pos="0 0.04 0.05">
      <joint name="left" type="slide" axis="0 -1 0" range="0 0.04"/>
      <geom name="left" type="box" size="0.01 0.005 0.02" mass="0.1"/>
    </body>
    <site name="edge" pos="0 0 0.07" euler="0 -90 0"/>
  </worldbody>
  <actuator><position name="jaw" joint="left" kp="1000" kv="10" ctrlrange="0 0.04"/></actuator>
</mujoco>
"""
CLOSING = {"use.can": ["close"], "use.scoop_angle_deg": None, "use.closing_time": 1.0}


def numbers_of(folder):
    """Return all that an attempt asks of a hand."""
    hand = Hand.load(folder)
    return hand.use, hand.drive, hand.contact_geoms


def refusal(folder):
    """Return the sentence with which all uses of a hand refuse it."""
    with pytest.raises(ModelError) as caught:
        numbers_of(folder)
    text = str(caught.value)
    assert "\n" not in text
    return text


def test_width_heel_and_outline_follow_from_the_geometry(tmp_path):
    use = Hand.load(write_hand(tmp_path / "scoop")).use
    assert use.half_width == pytest.approx(0.07)
    assert use.heel == pytest.approx(0.12, abs=2e-4)
    assert np.abs(use.outline[:, 1]).max() == pytest.approx(0.07)
    assert not use.closes
    assert use.scoop_angle == pytest.approx(np.radians(45.0))
    stated = Hand.load(write_hand(tmp_path / "scoop", {"hand.width": 0.1, "use.heel": 0.05})).use
    assert (stated.half_width, stated.heel) == (0.05, 0.05)
    assert (use.aim_half_width, stated.aim_half_width) == (use.half_width, 0.05)


def test_the_tool_frame_is_the_site_seen_from_the_flange(tmp_path):
    tool = Hand.load(write_hand(tmp_path / "scoop")).transform_tool_to_flange
    np.testing.assert_allclose(tool.translation, [-0.02, 0.0, 0.049 + 0.16], atol=1e-9)
    np.testing.assert_allclose(tool.rotation[:, 0], [0.342, 0.0, 0.940], atol=1e-3)
    turned = Hand.load(write_hand(tmp_path / "scoop", {"hand.mount_deg": 90.0})).transform_tool_to_flange
    np.testing.assert_allclose(turned.translation, [0.0, -0.02, 0.049 + 0.16], atol=1e-9)


def test_what_collides_in_the_model_touches_objects_and_the_rest_is_drawn(tmp_path):
    folder = write_hand(tmp_path / "scoop")
    hand = Hand.load(folder)
    assert hand.contact_geoms == ("sensor", "hand_floor", "hand_back")
    assert not hand.model.geom_contype.any()
    assert not hand.model.geom_conaffinity.any()
    write_hand(folder, {"hand.contact_geoms": ["floor"]})
    assert Hand.load(folder).contact_geoms == ("sensor", "hand_floor")
    write_hand(folder, {"hand.contact_geoms": ["flor"]})
    assert "contact_geoms names 'flor', which is no geom of the hand; choose from strut, floor, back" in refusal(folder)


def test_the_scene_carries_the_hand_behind_the_sensor(tmp_path):
    folder = write_hand(tmp_path / "scoop")
    scene = prepare(build_scenario({}, {"hand": str(folder), "pile.count": 3}), 0).simulation.scene
    names = [scene.model.body(body).name for body in scene.hand_bodies]
    assert names == ["sensor", "hand", "hand_scoop"]
    assert scene.model.nu == scene.arm_dofs
    pair = {scene.model.geom("hand_floor").id, scene.model.geom("object_0").id}
    (index,) = [i for i in range(scene.model.npair) if {scene.model.pair_geom1[i], scene.model.pair_geom2[i]} == pair]
    assert scene.model.pair_friction[index, 0] == 0.4


def test_a_closing_hand_follows_the_ends_of_its_ctrlrange_or_of_the_stated_closure(tmp_path):
    folder = write_hand(tmp_path / "jaw", CLOSING, GRIPPER)
    drive = Hand.load(folder).drive
    assert (drive.opened.tolist(), drive.closed.tolist(), drive.stroke_time) == ([0.0], [0.04], 0.0)
    assert drive.next_closure(0.0, 1.0, 0.002) == 1.0
    write_hand(folder, CLOSING | {"use.closure": {"jaw": [0.01, 0.03]}, "use.stroke_time": 0.5}, GRIPPER)
    drive = Hand.load(folder).drive
    assert drive.command(0.5) == pytest.approx([0.02])
    assert drive.next_closure(0.2, 1.0, 0.1) == pytest.approx(0.4)
    assert drive.next_closure(0.9, 0.0, 0.1) == pytest.approx(0.7)
    assert drive.next_closure(0.9, 1.0, 0.1) == 1.0


def test_the_closing_force_limits_every_actuator_of_the_hand(tmp_path):
    hand = Hand.load(write_hand(tmp_path / "jaw", CLOSING | {"use.closing_force": 12.0}, GRIPPER))
    np.testing.assert_array_equal(hand.model.actuator_forcerange, [[-12.0, 12.0]])


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"hand.mjcf": None}, r"[hand] needs one of mjcf and builder"),
        ({"hand.theta_deg": None}, r"hand.theta_deg is missing; add it"),
        ({"hand.theta_deg": 120.0}, r"hand.theta_deg = 120.0 is not allowed: it must be at most 90"),
        ({"hand.thta": 1.0}, r"hand.thta is not known; did you mean 'theta_deg'?"),
        ({"scoop.width": 0.1}, r"scoop is not known"),
        ({"hand.tool_frame": "tip"}, r"tool_frame = 'tip' is no site of the hand; its sites are: edge"),
        ({"use.can": ["grip"]}, r"is not allowed"),
        ({"use.can": ["close"]}, r"[use] closing_time goes with 'close' in can: give both or none"),
        ({"use.can": []}, r"[use] scoop_angle_deg goes with 'scoop' in can: give both or none"),
        (CLOSING, r"'close' needs an actuator, and the hand has none; take it out of use.can"),
        ({"use.closure": {"jaw": [0.0, 1.0]}}, r"use.closure names 'jaw'; the actuators of the hand are: none"),
        ({"hand.mjcf": "none.xml"}, r"no such file of a model"),
    ],
)
def test_a_wrong_robot_toml_is_one_sentence(tmp_path, changes, sentence):
    assert sentence in refusal(write_hand(tmp_path / "scoop", changes))


@pytest.mark.parametrize(
    ("model", "sentence"),
    [
        ("<mujoco", "is not XML"),
        ("<robot/>", "has the root <robot>; an MJCF has the root <mujoco>"),
        ("<mujoco><worldbody><geom type='plane' size='1 1 1'/></worldbody></mujoco>", "a hand has no plane"),
        (SCOOP.replace('<site name="edge"/>', '<site name="edge"/><freejoint/>'), "remove the free or ball joint"),
        (SCOOP.replace('mass="0.2"', 'mass="-1"'), "MuJoCo cannot"),
        (SCOOP.replace('mass="0.2"', 'mas="1"'), "MuJoCo cannot"),
    ],
)
def test_a_model_that_is_no_hand_is_one_sentence(tmp_path, model, sentence):
    assert sentence in refusal(write_hand(tmp_path / "scoop", {}, model))


def test_an_unknown_hand_is_refused_with_the_names_that_ship():
    with pytest.raises(ConfigurationError, match=r"hand = 'scoop' is not allowed: .*'shovel', or the folder"):
        build_scenario({}, {"hand": "scoop"})
    with pytest.raises(ModelError, match=r"hand = './nowhere': is no folder that holds a robot.toml"):
        prepare(build_scenario({}, {"hand": "./nowhere"}), 0)


def test_the_folder_is_relative_to_the_scenario_that_names_it(tmp_path, monkeypatch):
    write_hand(tmp_path / "scoop")
    file = tmp_path / "mine.toml"
    file.write_text('hand = "./scoop"\n', encoding="utf-8")
    assert load_scenario(file).hand == str(tmp_path / "scoop")
    monkeypatch.chdir(tmp_path)
    assert load_scenario("mine.toml").hand == "./scoop"


def test_the_hash_depends_on_the_files_of_the_hand_and_not_on_their_place(tmp_path):
    def hash_of(folder):
        return build_scenario({}, {"hand": str(folder)}).config_hash()

    one, other = write_hand(tmp_path / "a"), write_hand(tmp_path / "b")
    (other / "README.md").write_text("my scoop", encoding="utf-8")
    assert hash_of(one) == hash_of(other) != Scenario().config_hash()
    write_hand(other, {}, SCOOP.replace("0.0685", "0.07").replace("0.070", "0.071"))
    assert hash_of(one) != hash_of(other)


def test_hand_model_varies_the_defaults_of_an_own_hand_and_refuses_what_it_lacks(tmp_path):
    folder = write_hand(tmp_path / "scoop")
    varied = Hand.load(folder, HandModelConfig(sensor_mass=2.0, friction=0.5))
    assert varied.parameters["sensor"]["mass"] == pytest.approx(0.51)
    assert varied.surface.lateral == pytest.approx(0.2)
    with pytest.raises(ConfigurationError, match=r"hand_model\.closing_moment has no effect"):
        build_scenario({}, {"hand": str(folder), "hand_model.closing_moment": 1.2})


def test_an_order_needs_a_hand_that_can_release(tmp_path):
    table = {"program": "order", "support": {"bin": True}}
    with pytest.raises(ConfigurationError, match=r"needs .* a hand that can release objects"):
        build_scenario(table, {"hand": str(write_hand(tmp_path / "scoop"))})
    both = {"use.can": ["scoop", "release"]}
    build_scenario(table, {"hand": str(write_hand(tmp_path / "tray", both))})


BUILDER = """\
def build(spec, root, parameters):
    size = parameters["plate"]["size"]
    root.add_geom(name="plate", type=6, size=size, pos=[0.0, 0.0, 0.2], mass=0.1)
    root.add_site(name="edge", pos=[0.0, 0.0, 0.2 + size[2]])
"""
BUILT = {"hand.mjcf": None, "hand.builder": "my_plates:build", "plate.size": [0.05, 0.002, 0.05], "use.can": []}


@pytest.fixture
def plugins(tmp_path):
    (tmp_path / "plugins").mkdir()
    (tmp_path / "plugins" / "my_plates.py").write_text(BUILDER, encoding="utf-8")
    use_plugins([tmp_path / "plugins"])
    yield tmp_path / "plugins" / "my_plates.py"
    use_plugins([])


def test_a_builder_from_a_folder_of_plugins_makes_the_hand_and_counts_in_the_hash(tmp_path, plugins):
    folder = write_hand(tmp_path / "plate", BUILT | {"use.scoop_angle_deg": None})
    hand, before = Hand.load(folder), build_scenario({}, {"hand": str(folder)}).config_hash()
    assert hand.contact_geoms == ("sensor", "plate")
    assert hand.mass_properties().mass == pytest.approx(0.255 + 0.1)
    assert not hand.model.geom_contype.any()
    plugins.write_text(BUILDER.replace("mass=0.1", "mass=0.2"), encoding="utf-8")
    use_plugins([plugins.parent])
    assert build_scenario({}, {"hand": str(folder)}).config_hash() != before


def test_a_builder_that_fails_is_one_sentence(tmp_path, plugins):
    folder = write_hand(tmp_path / "plate", BUILT | {"use.scoop_angle_deg": None, "plate.size": [0.05]})
    assert "hand.builder = 'my_plates:build' failed: IndexError: list index out of range (my_plates.py" in refusal(
        folder
    )


def test_numbers_of_the_model_s_own_numerics_do_not_count(tmp_path):
    model = SCOOP.replace("<default>", '<option timestep="0.02"/><keyframe><key name="home"/></keyframe><default>')
    hand = Hand.load(write_hand(tmp_path / "scoop", {}, model))
    assert hand.model.opt.timestep == mujoco.MjSpec().option.timestep
