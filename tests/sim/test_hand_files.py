"""The MJCF and the README of each hand agree with its robot.toml."""

import copy
import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest

import hand_files
from pilegrasp_ctrl import robots
from pilegrasp_ctrl.sim.hand import Hand

NAMES = [name.rpartition("/")[2] for name in robots.hands()]
BUILT = [name for name in NAMES if Hand.load(name).description.hand.builder]
AGAIN = "run `make hands`"


def file(name):
    return robots.path("hands", name, f"{name}.xml")


def readme(name):
    return robots.path("hands", name, "README.md").read_text(encoding="utf-8")


def differences(model, other):
    """Return the fields in which two models differ by more than the six digits that MJCF is written with."""
    found = [] if element_names(model) == element_names(other) else ["names"]
    for field in dir(model):
        value = getattr(model, field)
        # The addresses of names move with the model's own name.
        if isinstance(value, np.ndarray) and not field.startswith("name"):
            wanted = getattr(other, field)
            tolerance = 1e-5 * np.abs(wanted).max(initial=0.0)
            if value.shape != wanted.shape or not np.allclose(value, wanted, rtol=1e-5, atol=tolerance):
                found.append(field)
    return found


def element_names(model):
    return model.names.split(b"\0")[1:]


class FromFile(Hand):
    """A hand whose bodies are read from its MJCF."""

    def standalone_spec(self):
        return mujoco.MjSpec.from_file(str(file(self.name)))


@pytest.mark.parametrize("name", BUILT)
def test_the_mjcf_follows_from_robot_toml(name):
    assert (
        differences(mujoco.MjModel.from_xml_path(str(file(name))), Hand.load(name).standalone_spec().compile()) == []
    ), AGAIN


@pytest.mark.parametrize(
    ("name", "table", "key", "field"),
    [
        ("rbo_hand2", "pneumatics", "bending_stiffness", "jnt_stiffness"),
        ("rbo_hand2", "pneumatics", "bending_damping", "dof_damping"),
        ("rbo_hand2", "pneumatics", "closing_moment", "actuator_gainprm"),
        ("rbo_hand2", "pneumatics", "time_constant", "actuator_dynprm"),
        ("rbo_hand2", "fingers", "mass", "body_mass"),
        ("rbo_hand2", "fingers", "radius_tip", "geom_size"),
        ("shovel", "scoop", "thickness", "geom_size"),
        ("shovel", "hand", "finger_angle_deg", "body_quat"),
    ],
)
def test_a_changed_parameter_is_a_difference_to_the_mjcf(name, table, key, field):
    hand = Hand.load(name)
    parameters = copy.deepcopy(hand.parameters)
    parameters[table][key] *= 1.02
    changed = replace(hand, parameters=parameters)
    assert field in differences(mujoco.MjModel.from_xml_path(str(file(name))), changed.standalone_spec().compile())
    assert hand_files.replace_values(readme(name), parameters) != readme(name)


@pytest.mark.parametrize("name", BUILT)
def test_the_mjcf_loads_with_the_mass_properties_of_the_hand(name):
    loaded, made = FromFile.load(name).mass_properties(), Hand.load(name).mass_properties()
    assert loaded.mass == pytest.approx(made.mass, rel=1e-5)
    np.testing.assert_allclose(loaded.center_of_mass, made.center_of_mass, atol=1e-6)
    np.testing.assert_allclose(loaded.inertia, made.inertia, atol=1e-5 * np.abs(made.inertia).max())


@pytest.mark.parametrize("name", BUILT)
def test_the_mjcf_runs_alone_and_reads_its_own_weight(name):
    model = mujoco.MjModel.from_xml_path(str(file(name)))
    data = mujoco.MjData(model)
    data.ctrl[:] = 1.0
    mujoco.mj_step(model, data, 1500)
    assert not data.warning.number.any()
    assert np.abs(data.qvel).max(initial=0.0) < 1e-3
    force = data.sensor("wrist_force").data
    np.testing.assert_allclose(force, [0.0, 0.0, 9.81 * model.body_mass.sum()], atol=1e-3)


@pytest.mark.parametrize("name", NAMES)
def test_the_readme_lists_every_number_with_its_value(name):
    parameters = Hand.load(name).parameters
    text = readme(name)
    assert hand_files.read_rows(text).keys() == hand_files.flatten(parameters).keys()
    assert hand_files.replace_values(text, parameters) == text, AGAIN


def test_the_readme_states_the_stiffness_at_the_tip():
    hand = Hand.load("rbo_hand2").parameters
    lengths = [
        np.linalg.norm(np.subtract(hand["fingers"]["tip"][f], base)) for f, base in hand["fingers"]["base"].items()
    ]
    count = hand["fingers"]["segments"]
    levers = np.arange(1, count + 1) / count
    stiffness = [hand["pneumatics"]["bending_stiffness"] / (length**2 * levers @ levers) for length in lengths]
    (stated,) = re.findall(r"(\d+) to (\d+) N/m at the tip", readme("rbo_hand2"))
    assert [int(number) for number in stated] == [round(min(stiffness)), round(max(stiffness))]


def test_both_files_are_written_from_robot_toml(tmp_path, monkeypatch):
    for name in BUILT:
        folder = tmp_path / name
        folder.mkdir()
        (folder / "README.md").write_text("| `use.heel` | stale | m |\n", encoding="utf-8")
    monkeypatch.setattr(hand_files, "path", lambda _, *parts: tmp_path.joinpath(*parts))
    for name in BUILT:
        model, text = hand_files.write(name)
        assert differences(mujoco.MjModel.from_xml_path(str(model)), Hand.load(name).standalone_spec().compile()) == []
        assert (
            text.read_text(encoding="utf-8") == f"| `use.heel` | {Hand.load(name).parameters['use']['heel']:g} | m |\n"
        )
