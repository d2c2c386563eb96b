"""How-tos and tutorial are followed literally, in an empty folder outside the repository, with the files they show."""

import os
import re
import subprocess
import sys

import pytest

from places import DOCS, ROOT

PAGES = sorted(page for folder in ("how-to", "tutorial") for page in (DOCS / folder).glob("*.md"))
MAX_LINES = 60
"""Most lines of the user's own files [-]."""

BLOCK = re.compile(r"^```([\w-]*)[ \t]*([^\n]*)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def files_and_commands(page):
    """Return the files of a page by name, and its commands; ```py NAME begins a file, ```console commands."""
    files, commands = {}, []
    for language, name, body in BLOCK.findall(page.read_text(encoding="utf-8")):
        if language == "console":
            lines = body.replace("\\\n", " ").splitlines()
            commands += [line.removeprefix("$ ") for line in lines if line.startswith("$ ")]
        elif name:
            files[name.strip()] = body
    return files, commands


def with_program(folder):
    """Return an environment in which `pilegrasp` is this checkout, and `python` finds it."""
    for name, words in (("pilegrasp", "-m pilegrasp_ctrl "), ("python", "")):
        program = folder / name
        program.write_text(f'#!/bin/sh\nPYTHONPATH="{ROOT}" exec "{sys.executable}" {words}"$@"\n')
        program.chmod(0o755)
    return os.environ | {"PATH": f"{folder}:{os.environ['PATH']}", "PYTHONPATH": "", "OMP_NUM_THREADS": "1"}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_how_to_needs_few_lines(page):
    files, commands = files_and_commands(page)
    assert commands
    assert sum(len(text.splitlines()) for text in files.values()) < MAX_LINES


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_how_to_works_in_an_empty_folder(page, tmp_path):
    (tmp_path / "bin").mkdir()
    environment, place = with_program(tmp_path / "bin"), tmp_path / "mine"
    place.mkdir()
    files, commands = files_and_commands(page)
    for name, text in files.items():
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_text(text, encoding="utf-8")
    for command in commands:
        done = subprocess.run(command, shell=True, cwd=place, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, f"{command}\n{done.stderr}"


@pytest.mark.parametrize(
    ("page", "example"),
    [("own-primitive", "plans/wiggle.py"), ("own-task", "own_task.py"), ("own-limit", "own_limit.py")],
)
def test_the_script_of_a_how_to_is_the_example(page, example):
    files, _ = files_and_commands(DOCS / "how-to" / f"{page}.md")
    text = (DOCS / "examples" / example).read_text(encoding="utf-8")
    assert files[example.rpartition("/")[2]] == text
