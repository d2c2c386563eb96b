"""Installation: one name in site-packages, which contains the linked folders and their data."""

import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

from pilegrasp_ctrl.provenance import dependencies
from places import ROOT

LINKED = ("robots", "scenarios", "viewer")

MAX_WHEEL = 1_500_000
"""Largest wheel [bytes]; it holds no recording and no picture."""


@pytest.fixture(scope="module")
def built(tmp_path_factory) -> Path:
    """An sdist, and a wheel built from that sdist, of a copy of the tree."""
    folder = tmp_path_factory.mktemp("build")
    kept = ["pyproject.toml", "README.md", "LICENSE", "pilegrasp_ctrl", *LINKED]
    for name in kept:
        if (ROOT / name).is_dir():
            ignore = shutil.ignore_patterns("__pycache__", "*.egg-info")
            shutil.copytree(ROOT / name, folder / name, symlinks=True, ignore=ignore)
        else:
            shutil.copy(ROOT / name, folder / name)
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", "dist", "."]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder / "dist"


@pytest.fixture(scope="module")
def wheel(built) -> set[str]:
    (path,) = built.glob("*.whl")
    with zipfile.ZipFile(path) as archive:
        return set(archive.namelist())


@pytest.mark.slow
def test_the_wheel_installs_one_name(wheel):
    top = {name.partition("/")[0] for name in wheel}
    assert {name for name in top if not name.endswith(".dist-info")} == {"pilegrasp_ctrl"}
    assert len(top) == 2


@pytest.mark.slow
@pytest.mark.parametrize("folder", LINKED)
def test_the_wheel_holds_every_file_of_a_linked_folder(wheel, folder):
    assert (ROOT / "pilegrasp_ctrl" / folder).resolve() == ROOT / folder
    files = {path.relative_to(ROOT) for path in (ROOT / folder).rglob("*") if path.is_file()}
    expected = {f"pilegrasp_ctrl/{path}" for path in files if "__pycache__" not in path.parts}
    assert expected
    assert expected - wheel == set()


def test_the_wheel_holds_every_module_and_no_test(wheel):
    modules = {str(path.relative_to(ROOT)) for path in (ROOT / "pilegrasp_ctrl").rglob("*.py")}
    assert modules - wheel == set()
    assert "pilegrasp_ctrl/py.typed" in wheel
    assert not [name for name in wheel if "test" in name]


def test_the_sdist_holds_the_linked_folders_as_folders(built):
    (path,) = built.glob("*.tar.gz")
    with tarfile.open(path) as archive:
        members = {member.name.partition("/")[2]: member for member in archive.getmembers()}
    for file in ("robots/wam7/wam7.urdf", "scenarios/spheres_wall.toml", "viewer/__init__.py"):
        assert members[f"pilegrasp_ctrl/{file}"].isreg()
    assert not [name for name, member in members.items() if member.issym()]


def test_an_installed_wheel_works_on_its_own(built, tmp_path):
    (path,) = built.glob("*.whl")
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path)
    code = "import pilegrasp_ctrl as pg; from pilegrasp_ctrl.cli import main; print(pg.__file__); main(['list'])"
    command = [sys.executable, "-c", code]
    answer = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert answer.startswith(str(tmp_path))
    assert "spheres_wall" in answer


def test_the_doctor_knows_every_dependency():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert [text.partition(">=")[0] for text in project["dependencies"]] == list(dependencies())


def test_every_dependency_is_locked():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    locked = dict(line.split("==") for line in (ROOT / "constraints.txt").read_text(encoding="utf-8").split())
    wanted = project["dependencies"] + project["optional-dependencies"]["dev"]
    assert {text.partition(">=")[0] for text in wanted} - locked.keys() == set()


def test_the_wheel_is_small_and_holds_the_schema(built):
    (path,) = built.glob("*.whl")
    assert path.stat().st_size < MAX_WHEEL
    with zipfile.ZipFile(path) as archive:
        assert "pilegrasp_ctrl/scenarios/scenario.schema.json" in archive.namelist()


def test_the_metadata_are_complete(built):
    (path,) = built.glob("*.whl")
    with zipfile.ZipFile(path) as archive:
        (name,) = (each for each in archive.namelist() if each.endswith(".dist-info/METADATA"))
        metadata = archive.read(name).decode()
    for entry in ("Version: ", "Summary: ", "License-Expression: Apache-2.0", "Author: ", "Provides-Extra: gym"):
        assert f"\n{entry}" in metadata
    assert "\n# pilegrasp\n" in metadata


@pytest.mark.slow
def test_the_wheel_of_the_sdist_installs_into_an_empty_environment(built, tmp_path):
    (path,) = built.glob("*.whl")
    venv.create(tmp_path / "empty", with_pip=True)
    python = tmp_path / "empty" / "bin" / "python"
    # The dependencies are those of the tests, behind the environment's own packages; none is fetched.
    libraries = [entry for entry in sys.path if entry.endswith("site-packages")]
    (own,) = (tmp_path / "empty" / "lib").glob("python*/site-packages")
    (own / "libraries.pth").write_text("\n".join(libraries), encoding="utf-8")
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    options = ["--quiet", "--no-deps", "--no-index", "--no-build-isolation", "--ignore-installed"]
    subprocess.run([python, "-m", "pip", "install", *options, str(path)], cwd=tmp_path, env=environment, check=True)
    program = tmp_path / "empty" / "bin" / "pilegrasp"
    done = subprocess.run([program, "list", "--json"], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "spheres_wall" in done.stdout
    code = "import pilegrasp_ctrl as pg; print(pg.__file__, pg.__version__)"
    told = subprocess.run([python, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True).stdout
    place, version = told.split()
    assert place.startswith(str(tmp_path))
    assert version == tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
