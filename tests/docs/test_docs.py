"""Code, commands and links in the documentation are run, parsed or looked up."""

import os
import re
import shlex
import subprocess
import tomllib
from pathlib import Path

import pytest
import typer

from line_links import line_links
from pilegrasp_ctrl.cli import app
from pilegrasp_ctrl.config import build_scenario
from places import ROOT

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("**/*.md"))]
OTHERS = [ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "robots").glob("**/*.md"))]
CI = (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()


def named(pages):
    return [pytest.param(page, id=str(page.relative_to(ROOT))) for page in pages]


def blocks(page: Path, *languages: str) -> list[str]:
    text = page.read_text(encoding="utf-8")
    fenced = re.findall(r"^```([\w-]*)[^\n]*\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL)
    return [body for language, body in fenced if language in languages]


def shell_lines(page: Path) -> list[str]:
    """The commands of a page's shell blocks, without prompts, continuations and comments."""
    lines = "\n".join(blocks(page, "bash", "sh", "console")).replace("\\\n", " ").splitlines()
    return [command for line in lines if (command := line.strip().removeprefix("$ ")) and not command.startswith("#")]


def commands() -> list[tuple[str, str]]:
    pages = [*PAGES, ROOT / "CONTRIBUTING.md"]
    return [(page.name, line) for page in pages for line in shell_lines(page) if line.startswith("pilegrasp ")]


@pytest.mark.slow
@pytest.mark.parametrize("page", named(page for page in PAGES if blocks(page, "python")))
def test_python_blocks_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "__docs__"}
    for body in blocks(page, "python"):
        exec(compile(body, str(page), "exec"), names)


@pytest.mark.parametrize("page", named(page for page in PAGES if blocks(page, "toml")))
def test_toml_blocks_are_scenarios(page):
    for body in blocks(page, "toml"):
        build_scenario(tomllib.loads(body), source=page.name)


def parse(line: str) -> None:
    group = typer.main.get_command(app)
    words = shlex.split(line.partition(" > ")[0], comments=True)[1:]
    if words[0].startswith("-"):
        assert words[0] in {option for parameter in group.params for option in parameter.opts}, words[0]
        return
    verb, *arguments = words
    if "--schema" in arguments:
        arguments = ["spheres_wall"]
    group.commands[verb].make_context(verb, arguments)


@pytest.mark.parametrize(("page", "line"), commands())
def test_shown_commands_exist(page, line):
    parse(line)


def test_some_commands_are_shown():
    assert ("README.md", "pilegrasp run spheres_wall --seed 0 --html grasp.html") in commands()


@pytest.mark.parametrize(
    "line", ["pilegrasp dance", "pilegrasp --dance", "pilegrasp run spheres_wall --sed 0", "pilegrasp export a.npz"]
)
def test_a_command_that_does_not_exist_is_found(line):
    with pytest.raises(Exception, match=r"dance|--sed|recordings"):
        parse(line)


@pytest.mark.parametrize("page", named([*PAGES, *OTHERS]))
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if not target.startswith(("http://", "https://", "#")):
            assert (page.parent / target.partition("#")[0]).exists(), target


@pytest.mark.parametrize("page", named(page for page in PAGES if line_links(page)))
def test_links_to_a_line_lead_to_the_code_that_they_name(page):
    for link in line_links(page):
        assert link.found() == [link.line], (
            f"{link.text!r}; `python tests/helpers/line_links.py` writes the numbers anew"
        )


def test_the_index_lists_every_page():
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    for page in PAGES[1:]:
        relative = str(page.relative_to(ROOT / "docs"))
        assert relative == "README.md" or f"]({relative})" in index, relative


def test_the_readme_shows_two_commands_first_and_ci_calls_the_second():
    run, test, *_ = shell_lines(ROOT / "README.md")
    assert (run, test) == ("make run", "make test")
    assert CI[-1] == test


@pytest.mark.parametrize(
    ("target", "does"), [("run", "pilegrasp run spheres_wall --seed 0 --html"), ("test", "-m pytest")]
)
def test_a_command_of_the_readme_sets_up_what_it_needs(target, does, tmp_path):
    for name in ("Makefile", "pyproject.toml", "constraints.txt"):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    # Called by make, a second make would print more.
    plain = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    command = ["make", "--no-print-directory", "-n", target]
    planned = subprocess.run(command, cwd=tmp_path, env=plain, capture_output=True, text=True, check=True).stdout
    steps = planned.splitlines()
    order = [next(i for i, step in enumerate(steps) if words in step) for words in ("-m venv", "pip install", does)]
    assert order == sorted(order)


def test_the_version_is_written_once():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert version in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_the_trails_through_the_code_name_existing_code():
    page = (ROOT / "docs" / "developer-notes.md").read_text(encoding="utf-8")
    section = page.split("## Four trails")[1].split("\n## ")[0]
    names = {name.rpartition(".")[2] for name in re.findall(r"`([\w.]+)`", section)}
    files = [file for folder in ("pilegrasp_ctrl", "viewer") for file in (ROOT / folder).rglob("*.py")]
    defined = {name for file in files for name in re.findall(r"(?:def|class) (\w+)", file.read_text(encoding="utf-8"))}
    assert len(names) > 10
    assert names <= defined
    assert all(line.count("→") < 5 for line in section.splitlines())
