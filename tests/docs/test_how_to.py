"""The how-tos are followed literally, in an empty folder outside the repository, with the files that they show."""

import os
import re
import subprocess
import sys

import pytest

from places import DOCS, ROOT

PAGES = sorted((DOCS / "how-to").glob("*.md"))
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
    """Return an environment in which `pilegrasp` is this checkout."""
    program = folder / "pilegrasp"
    program.write_text(f'#!/bin/sh\nPYTHONPATH="{ROOT}" exec "{sys.executable}" -m pilegrasp_ctrl "$@"\n')
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


def test_the_wiggle_of_the_how_to_is_the_example():
    files, _ = files_and_commands(DOCS / "how-to" / "own-primitive.md")
    assert files["wiggle.py"] == (DOCS / "examples" / "plans" / "wiggle.py").read_text(encoding="utf-8")
