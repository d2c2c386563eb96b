"""`pilegrasp show`: the effective scenario as a file to start from."""

import json

import pytest

from pilegrasp_ctrl import cli
from pilegrasp_ctrl.config import dotted_keys, load_scenario
from pilegrasp_ctrl.scenarios import names


@pytest.mark.parametrize("name", names())
def test_what_is_shown_is_the_scenario(name, tmp_path, capsys):
    assert cli.main(["show", name]) == 0
    (tmp_path / "mine.toml").write_text(capsys.readouterr().out, encoding="utf-8")
    again = load_scenario(tmp_path / "mine.toml")
    assert again == load_scenario(name)
    assert again.config_hash() == load_scenario(name).config_hash()


def dotted(table, start=""):
    for key, value in table.items():
        if isinstance(value, dict):
            yield from dotted(value, f"{start}{key}.")
        yield start + key


def test_changed_keys_are_shown_and_every_key_is_there(capsys):
    assert cli.main(["show", "spheres_wall", "--set", "pile.count=5", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["pile"]["count"] == 5
    assert shown["config_hash"] == load_scenario("spheres_wall", {"pile.count": 5}).config_hash()
    assert set(dotted(shown)) >= set(dotted_keys())


def test_an_unknown_scenario_is_one_sentence(capsys):
    assert cli.main(["show", "nothing"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("error: ")
    assert err.count("\n") == 1
