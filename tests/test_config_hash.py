"""The hash of a scenario: equal only for equal physics and control."""

import re

import pytest

from pilegrasp_ctrl.config import Scenario, build_scenario, load_scenario
from pilegrasp_ctrl.exceptions import ConfigurationError


def test_the_hash_is_16_hex_digits():
    assert re.fullmatch("[0-9a-f]{16}", Scenario().config_hash())


def test_the_hash_ignores_name_summary_and_tags():
    scenario = Scenario(name="a", summary="b", tags=("c",))
    assert scenario.config_hash() == Scenario().config_hash()


def test_the_hash_does_not_depend_on_how_a_number_is_written():
    whole, real = build_scenario({}, {"strategy.alpha_deg": 30}), build_scenario({}, {"strategy.alpha_deg": 30.0})
    assert whole.config_hash() == real.config_hash() != Scenario().config_hash()


CHANGED = {"pile.object": "cube", "support.kind": "none", "program": "push", "hand": "shovel", "robot": "panda"}


@pytest.mark.parametrize(
    ("key", "value"),
    [
        *CHANGED.items(),
        ("pile.count", 17),
        ("pile.mass", 0.06),
        ("strategy.speed", 0.11),
        ("controller.solver", "osqp"),
        ("controller.kind", "impedance"),
        ("sensor.cutoff", 9.0),
        ("sim.contact_rule", "product"),
    ],
)
def test_the_hash_depends_on_every_key_of_physics_and_control(key, value):
    assert build_scenario({}, {key: value}).config_hash() != Scenario().config_hash()


def test_the_hash_depends_on_the_line_if_the_program_is_line():
    line = {"program": "line"}
    assert build_scenario(line, {"line.start": [0.5, 0.0, 0.2]}).config_hash() != build_scenario(line).config_hash()


def test_an_operator_counts_only_where_an_order_is_delivered():
    assert build_scenario({}, {"order.operator": "sees"}).config_hash() == Scenario().config_hash()
    assert Scenario().config_hash() == "fc62c636053d5e87", "kept studies have this hash"
    with pytest.raises(ConfigurationError, match=r"order\.operator has no effect if program = 'grasp'"):
        build_scenario({}, {"order.operator": "bandit"})


def test_the_hash_depends_on_the_content_of_the_gains_and_not_on_their_path(tmp_path):
    hashes = []
    for folder, text in (("a", "x = 1"), ("b", "x = 1"), ("c", "x = 2")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "gains.toml").write_text(text, encoding="utf-8")
        file = tmp_path / folder / "mine.toml"
        file.write_text('controller.gains = "gains.toml"', encoding="utf-8")
        scenario = load_scenario(file)
        assert scenario.controller.gains == str(tmp_path / folder / "gains.toml")
        hashes.append(scenario.config_hash())
    assert hashes[0] == hashes[1] != hashes[2]


def test_the_error_names_missing_gains():
    with pytest.raises(ConfigurationError, match=r"nowhere\.toml: no such file"):
        build_scenario({}, {"controller.gains": "nowhere.toml"}).config_hash()
