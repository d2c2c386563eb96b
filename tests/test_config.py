"""Scenarios: keys, values, files, overrides and their errors."""

import datetime
import re
from pathlib import Path

import numpy as np
import pytest

from pilegrasp_ctrl.config import Scenario, build_scenario, dotted_keys, load_scenario, parse_overrides
from pilegrasp_ctrl.exceptions import ConfigurationError
from pilegrasp_ctrl.scenarios import find, names
from places import DOCS
from scenario_table import table

# Keys that each shipped scenario changes from the defaults, which are those of spheres_wall.
DIFFERENCES = {
    "spheres_wall": {},
    "spheres_corner": {"support.kind": "corner"},
    "spheres_alone": {"support.kind": "none"},
    "cylinders_wall": {"pile.object": "cylinder", "pile.count": 14},
    "cubes_wall": {"pile.object": "cube", "pile.count": 14},
    "bin_picking": {"program": "order", "support.bin": True, "support.tilt_deg": 5.0},
    "free_space_line": {"program": "line", "pile.count": 0},
    "push_wall": {"program": "push", "pile.count": 0},
}


def value_of(scenario: Scenario, key: str) -> object:
    value: object = scenario
    for part in key.split("."):
        value = getattr(value, part)
    return value


def write(folder: Path, text: str) -> Path:
    path = folder / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_shipped_scenarios_are_the_expected_ones():
    assert names() == sorted(DIFFERENCES)


@pytest.mark.parametrize("name", sorted(DIFFERENCES))
def test_a_shipped_scenario_changes_only_the_keys_that_its_name_names(name):
    scenario, default = load_scenario(name), Scenario()
    assert scenario.name == name
    assert scenario.summary
    assert scenario.tags
    differences = {
        key: value_of(scenario, key)
        for key in dotted_keys()
        if key not in ("name", "summary", "tags") and value_of(scenario, key) != value_of(default, key)
    }
    assert differences == DIFFERENCES[name]


def test_the_shipped_scenarios_have_different_hashes():
    assert len({load_scenario(name).config_hash() for name in names()}) == len(names())


def test_the_documented_keys_are_the_declared_ones():
    assert table() in (DOCS / "scenarios.md").read_text(encoding="utf-8"), (
        "python tests/helpers/scenario_table.py prints it anew"
    )


def test_the_documented_scenarios_are_those_that_ship():
    text = (DOCS / "scenarios.md").read_text(encoding="utf-8")
    rows = "\n".join(f"| `{name}` | {load_scenario(name).summary} |" for name in names())
    assert rows in text, rows


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("pile.count", -1),
        ("pile.count", 201),
        ("pile.count", 5.0),
        ("pile.count", "5"),
        ("pile.count", True),
        ("pile.mass", 0.0),
        ("pile.mass", -0.06),
        ("pile.mass", float("nan")),
        ("pile.mass", 1e-9),
        ("pile.mass", 1e6),
        ("pile.scale", 0.01),
        ("pile.frame_size", 5.0),
        ("pile.scale", float("inf")),
        ("pile.object", 3),
        ("strategy.alpha_deg", 91),
        ("strategy.beta_deg", float("nan")),
        ("strategy.theta_deg", "steep"),
        ("strategy.speed", 0.0),
        ("strategy.speed", 1e-9),
        ("strategy.grasp_force", float("inf")),
        ("strategy.grasp_force", 1e9),
        ("strategy.grasp_force", 1e-9),
        ("strategy.touch_force", 1e-9),
        ("strategy.kind", "object_based"),
        ("support.kind", "walls"),
        ("support.tilt_deg", -1.0),
        ("support.tilt_deg", 15.1),
        ("support.slope_error_deg", -3.1),
        ("support.slope_error_deg", 3.1),
        ("support.bin", "yes"),
        ("controller.rate", 99),
        ("controller.solver", "simplex"),
        ("sensor.force_noise", -0.1),
        ("sensor.cutoff", 0),
        ("sensor.cutoff", 1e-9),
        ("sensor.torque_noise", 1e9),
        ("sim.timestep", 0.01),
        ("line.start", [0.1, 0.2]),
        ("line.start", [0.1, 0.2, 0.3, 0.4]),
        ("line.displacement", [0.1, 0.2, float("nan")]),
        ("line.displacement", [1e300, 0.0, 0.0]),
        ("name", ""),
        ("summary", "two\nlines"),
        ("controller.gains", ""),
        ("controller.gains", "a\0b"),
        ("program", "dance"),
        ("hand", "gripper"),
        ("tags", "paper"),
    ],
)
def test_the_error_names_a_value_that_is_not_allowed(key, value):
    with pytest.raises(ConfigurationError) as caught:
        build_scenario({}, {key: value})
    assert key in str(caught.value)
    assert "is not allowed: " in str(caught.value)


@pytest.mark.parametrize(
    ("program", "key", "value"),
    [
        ("grasp", "line.speed", 0.2),
        ("push", "line.start", [0.5, 0.0, 0.2]),
        ("line", "strategy.speed", 0.2),
        ("line", "strategy.theta_deg", 30.0),
    ],
)
def test_a_key_that_the_program_does_not_read_is_rejected(program, key, value):
    with pytest.raises(ConfigurationError, match=f"{key} has no effect if program = '{program}'"):
        build_scenario({"program": program}, {key: value})


@pytest.mark.parametrize("value", [[0.1, 0.2], [0.1, 0.2, 0.3, 0.4], "0.1, 0.2, 0.3", 0.1])
def test_the_error_of_a_wrong_vector_shows_a_valid_one(value):
    with pytest.raises(ConfigurationError, match=r"line\.start = .* list of 3 numbers, such as \[0\.5, 0\.0, 0\.2\]"):
        build_scenario({"program": "line"}, {"line.start": value})


def test_the_error_names_the_wrong_entry_of_a_vector():
    with pytest.raises(ConfigurationError, match=r"^line\.start\[1\] = 10 is not allowed: it must be at most 2$"):
        build_scenario({"program": "line"}, {"line.start": [0, 10, 0]})


@pytest.mark.parametrize("key", dotted_keys())
def test_every_key_takes_its_own_default_from_python_and_from_toml(key, tmp_path):
    value = value_of(Scenario(), key)
    assert build_scenario({}, {key: value}) == Scenario()
    if value is not None:
        text = f"{key} = {list(value) if isinstance(value, tuple) else value}".replace("False", "false").replace(
            "True", "true"
        )
        text = f'{key} = "{value}"' if isinstance(value, str) else text
        assert build_scenario({}, parse_overrides([text.replace(" = ", "=")])) == Scenario()
        assert load_scenario(write(tmp_path, text), {"name": "unnamed"}) == Scenario()


@pytest.mark.parametrize("key", ["pile.cout", "support.tilt", "strategy.Speed", "controler.rate"])
def test_a_misspelt_key_is_an_error_with_a_suggestion(key, tmp_path):
    with pytest.raises(ConfigurationError, match="did you mean"):
        build_scenario({}, {key: 1})
    with pytest.raises(ConfigurationError, match=r"mine\.toml: unknown key"):
        load_scenario(write(tmp_path, f"{key} = 1"))


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("count", "did you mean 'pile.count' or 'order.count'?"),
        ("speed", "did you mean 'strategy.speed' or 'line.speed'?"),
        ("piles", "did you mean 'pile'?"),
        ("support", "it is a table of support.kind, support.tilt_deg, support.slope_error_deg, support.bin"),
        ("support.walls", "valid keys are support.kind, support.tilt_deg, support.slope_error_deg, support.bin"),
    ],
)
def test_a_suggestion_comes_from_the_same_table(key, words):
    with pytest.raises(ConfigurationError, match=re.escape(f"unknown key '{key}'; {words}")):
        build_scenario({}, {key: 1})


def test_an_error_in_an_override_does_not_name_the_file(tmp_path):
    file = write(tmp_path, "pile.count = 5")
    with pytest.raises(ConfigurationError, match=r"^pile\.count = -5 is not allowed: it must be at least 0$"):
        load_scenario(file, {"pile.count": -5})
    with pytest.raises(ConfigurationError, match=r"mine\.toml: pile\.mass = -1 is not allowed"):
        load_scenario(write(tmp_path, "pile.mass = -1"), {"pile.count": 5})


def test_the_error_of_an_unknown_key_lists_the_valid_keys_of_its_section():
    with pytest.raises(ConfigurationError, match=r"valid keys are sensor\.cutoff, sensor\.force_noise") as caught:
        build_scenario({}, {"sensor.zzzzzz": 1})
    assert "pile.count" not in str(caught.value)


def test_a_section_is_not_a_key():
    with pytest.raises(ConfigurationError, match="unknown key 'pile'"):
        build_scenario({}, {"pile": {"count": 3}})


def test_a_section_must_be_a_table():
    with pytest.raises(ConfigurationError, match="'pile' must be a table"):
        build_scenario({"pile": 3}, {"pile.count": 5})
    with pytest.raises(ConfigurationError, match="pile = 3 is not allowed: it must be a table"):
        build_scenario({"pile": 3})


def test_every_problem_is_reported_in_one_sentence():
    with pytest.raises(ConfigurationError) as caught:
        build_scenario({"pile": {"count": -1, "mas": 1}, "sensor": {"cutoff": 0}}, source="here")
    text = str(caught.value)
    assert text.startswith("here: ")
    assert "\n" not in text
    assert all(key in text for key in ("pile.count", "'pile.mas'", "sensor.cutoff"))


def test_overrides_replace_values_of_the_table_and_do_not_change_it():
    table = {"pile": {"count": 3, "scale": 2.0}}
    scenario = build_scenario(table, {"pile.count": 4})
    assert (scenario.pile.count, scenario.pile.scale) == (4, 2.0)
    assert table == {"pile": {"count": 3, "scale": 2.0}}


def test_numpy_values_are_accepted_as_numbers():
    scenario = build_scenario({"program": "line"}, {"pile.count": np.int64(3), "pile.mass": np.float64(0.1)})
    assert (scenario.pile.count, scenario.pile.mass) == (3, 0.1)
    scenario = build_scenario({"program": "line"}, {"line.start": np.ones(3)})
    assert scenario.line.start == (1.0, 1.0, 1.0)


def test_a_value_of_an_unsupported_type_is_an_error():
    date = datetime.date(2021, 5, 30)
    with pytest.raises(ConfigurationError, match=r"^pile\.count holds .* not a number, .*: 2021-05-30"):
        build_scenario({}, {"pile.count": date})
    with pytest.raises(ConfigurationError, match=r"^mine\.toml: holds .* not a number, .*: 2021-05-30"):
        build_scenario({"name": date}, source="mine.toml")


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("pile.count=5", "pile.count", 5),
        (" pile.mass = 0.12 ", "pile.mass", 0.12),
        ("pile.object=cube", "pile.object", "cube"),
        ('pile.object="cube"', "pile.object", "cube"),
        ("line.start=[0.5, 0, 0.3]", "line.start", [0.5, 0, 0.3]),
        ("controller.gains=a=b.toml", "controller.gains", "a=b.toml"),
    ],
)
def test_a_setting_is_read_as_toml_or_as_text(text, key, value):
    assert parse_overrides([text]) == {key: value}


def test_the_last_of_two_settings_of_a_key_counts():
    assert parse_overrides(["pile.count=5", "pile.count=6"]) == {"pile.count": 6}


@pytest.mark.parametrize("text", ["pile.count", "=5", "", " = 5"])
def test_a_setting_without_key_or_value_is_an_error(text):
    with pytest.raises(ConfigurationError, match="key=value"):
        parse_overrides([text])


def test_a_scenario_is_frozen():
    with pytest.raises(ValueError, match="frozen"):
        Scenario().pile.count = 3


def test_a_scenario_without_a_name_gets_that_of_its_file(tmp_path):
    assert load_scenario(write(tmp_path, "")).name == "mine"
    assert load_scenario(write(tmp_path, 'name = "yours"')).name == "yours"
    assert load_scenario(str(write(tmp_path, ""))).name == "mine"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"pile = ", "is not valid TOML"),
        (b"name = '\xff'", "is not valid TOML"),
        (b"a = 1\na = 2", "is not valid TOML"),
        (b"x = " + 2000 * b"[", "is not valid TOML"),
        (b"pile.count = " + 5000 * b"9", "is not valid TOML"),
    ],
)
def test_the_error_names_a_file_that_is_not_toml(tmp_path, content, message):
    path = tmp_path / "mine.toml"
    path.write_bytes(content)
    with pytest.raises(ConfigurationError, match=rf"mine\.toml: {message}"):
        load_scenario(path)


def test_a_byte_order_mark_is_accepted(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_bytes("name = 'yours'".encode("utf-8-sig"))
    assert load_scenario(path).name == "yours"


def test_the_error_names_a_file_that_cannot_be_read(tmp_path):
    with pytest.raises(ConfigurationError, match=r"nothing\.toml: no such file"):
        load_scenario("nothing.toml")
    with pytest.raises(ConfigurationError, match="cannot be read"):
        load_scenario(tmp_path)


def test_an_unknown_name_is_an_error_with_a_suggestion():
    with pytest.raises(ConfigurationError, match="did you mean 'spheres_wall'"):
        find("spheres_walls")
    with pytest.raises(ConfigurationError, match=r"choose from bin_picking, .*, spheres_wall"):
        find("zzz")
    with pytest.raises(ConfigurationError, match="no scenario is called ''"):
        find("")


def test_a_suffix_in_capitals_also_marks_a_file():
    assert find("mine.TOML") == Path("mine.TOML")
