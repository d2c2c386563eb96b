"""Origin of a result: the code and the packages that decide it."""

import ast
import subprocess
import sys

from pilegrasp_ctrl import provenance
from pilegrasp_ctrl.provenance import (
    ABSENT,
    DECIDING_PACKAGES,
    SOLVER_PACKAGES,
    code_digest,
    deciding_files,
    deciding_packages,
    python_version,
    version_of,
    versions,
)


def test_every_module_that_an_attempt_loads_is_part_of_its_origin():
    code = (
        "import sys; from pathlib import Path; import pilegrasp_ctrl.episode; "
        "print(*(Path(m.__file__).resolve() for n, m in sys.modules.items() if n.startswith('pilegrasp_ctrl.')))"
    )
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    covered = {str(file.resolve()) for file in deciding_files()}
    markers = {file for file in loaded if "/robots/" in file and file.endswith("__init__.py")}
    assert set(loaded) - markers <= covered


def test_code_that_only_shows_or_repeats_a_result_is_not_part_of_its_origin():
    rooms = {file.relative_to(provenance.deciding_files()[0].parent).parts[0] for file in deciding_files()}
    assert rooms & {"viewer", "study", "tuning", "validation", "cli"} == set()


def test_a_changed_file_changes_the_digest(monkeypatch):
    before = code_digest()
    monkeypatch.setattr(provenance, "deciding_files", lambda *rooms: deciding_files(*rooms)[1:])
    assert code_digest.__wrapped__() != before
    assert len({before, code_digest("sim"), code_digest("sim", "planning")}) == 3


def test_versions_name_the_deciding_packages_and_the_requested_ones():
    found = versions("scipy", "a-package-that-is-not-there")
    assert set(found) == {"pilegrasp", *DECIDING_PACKAGES, "scipy", "a-package-that-is-not-there"}
    assert found["a-package-that-is-not-there"] == ABSENT == version_of("a-package-that-is-not-there")
    assert ABSENT not in (found["mujoco"], found["scipy"])


def test_every_package_that_the_deciding_code_imports_is_named():
    imported = set()
    for file in deciding_files():
        for node in ast.walk(ast.parse(file.read_bytes())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) and not node.level else []
            imported |= {name.partition(".")[0] for name in names}
    others = imported - sys.stdlib_module_names - {"pilegrasp_ctrl", "osqp"}
    assert {"pin" if name == "pinocchio" else name.replace("_", "-") for name in others} <= set(deciding_packages())
    assert "osqp" in {package for packages, _ in SOLVER_PACKAGES.values() for package in packages}


def test_the_packages_that_deciding_packages_require_are_named():
    found = set(deciding_packages())
    # Pinocchio's library, MuJoCo's engine, numba's compiler, and the solver that mink asks for as an extra.
    assert {"libpinocchio", "mujoco-core", "llvmlite", "daqp"} <= found
    assert not found & {"osqp", "optuna", "matplotlib", "pytest", "jinja2"}
    assert ABSENT not in map(version_of, found)


def test_the_version_of_python_has_two_parts():
    assert python_version() == ".".join(map(str, sys.version_info[:2]))
