"""Origin of a result: the code and the packages that decide it."""

import subprocess
import sys

from pilegrasp_ctrl import provenance
from pilegrasp_ctrl.provenance import ABSENT, DECIDING_PACKAGES, code_digest, deciding_files, version_of, versions


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
    monkeypatch.setattr(provenance, "deciding_files", lambda: deciding_files()[1:])
    assert code_digest.__wrapped__() != before


def test_versions_name_the_deciding_packages_and_the_requested_ones():
    found = versions("scipy", "a-package-that-is-not-there")
    assert set(found) == {"pilegrasp", *DECIDING_PACKAGES, "scipy", "a-package-that-is-not-there"}
    assert found["a-package-that-is-not-there"] == ABSENT == version_of("a-package-that-is-not-there")
    assert ABSENT not in (found["mujoco"], found["scipy"])
