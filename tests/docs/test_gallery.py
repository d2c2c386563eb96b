"""The gallery's page shows the attempts of its TOML, with commands that the program accepts."""

import shlex

import pytest

from gallery import PICTURES, attempts
from pilegrasp_ctrl.config import load_scenario
from pilegrasp_ctrl.settings import parse_value
from places import DOCS

PAGE = (DOCS / "gallery.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("attempt", list(attempts()), ids=lambda attempt: attempt.name)
def test_an_attempt_of_the_gallery_is_on_its_page_and_runs_by_its_command(attempt):
    assert f"## {attempt.title}" in PAGE
    assert attempt.command in PAGE
    assert (PICTURES / f"{attempt.name}.jpg").is_file()
    words = shlex.split(attempt.command)
    said = dict(words[at + 1].split("=", 1) for at, word in enumerate(words) if word == "--set")
    overrides = {key: parse_value(value) for key, value in said.items()}
    assert load_scenario(attempt.scenario, overrides) == load_scenario(attempt.scenario, attempt.set)


def test_the_page_has_no_other_attempt():
    assert PAGE.count("pilegrasp run ") == len(list(attempts()))
