"""The cache of compiled kernels: damaged, read-only and absent, and plain Python in its place."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from places import ROOT

SUM = """
from pilegrasp_ctrl.kernels import algebra, compile as c
import numpy as np
x = np.arange(3.0)
print(algebra.length_square(x), c._cache_folder())
"""


def run(folder, home, **environment):
    """Run `SUM` with the package copied to `folder`; return the answer, the cache's folder and standard error."""
    done = subprocess.run(
        [sys.executable, "-c", SUM],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder), "HOME": str(home), **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    answer, cache = done.stdout.split()
    return answer, Path(cache), done.stderr


@pytest.fixture
def package(tmp_path):
    """A copy of what a kernel needs, without compiled code."""
    kernels = tmp_path / "site" / "pilegrasp_ctrl" / "kernels"
    kernels.mkdir(parents=True)
    (kernels.parent / "__init__.py").touch()
    for name in ("__init__", "compile", "algebra"):
        (kernels / f"{name}.py").write_bytes((ROOT / "pilegrasp_ctrl" / "kernels" / f"{name}.py").read_bytes())
    return tmp_path / "site"


@pytest.mark.slow
def test_a_damaged_cache_is_made_anew_and_a_change_of_any_kernel_is_noticed(package, tmp_path):
    answer, cache, said = run(package, tmp_path)
    assert answer == "5.0"
    assert "compiles its control law for this machine, once" in said
    assert run(package, tmp_path) == ("5.0", cache, "")
    for kind in ("*.nbi", "*.nbc"):
        for file in cache.rglob(kind):
            file.write_bytes(file.read_bytes()[:20])
        assert run(package, tmp_path)[0] == "5.0"
    algebra = package / "pilegrasp_ctrl" / "kernels" / "algebra.py"
    algebra.write_text(algebra.read_text().replace("total += x[i] * x[i]", "total += 2.0 * x[i] * x[i]"))
    answer, other, _ = run(package, tmp_path)
    assert (answer, other != cache) == ("10.0", True)


@pytest.mark.slow
def test_without_a_writable_folder_kernels_still_run(package, tmp_path):
    # A file where the folder should be serves as well as missing rights, which the superuser would have anyway.
    (package / "pilegrasp_ctrl" / "kernels" / "__pycache__").write_text("")
    home = tmp_path / "home"
    home.mkdir()
    answer, cache, _ = run(package, home, PYTHONDONTWRITEBYTECODE="1")
    assert (answer, cache.parts[-3:-1]) == ("5.0", (".cache", "pilegrasp"))
    (tmp_path / "file").write_text("")
    assert run(package, tmp_path / "file", PYTHONDONTWRITEBYTECODE="1")[0] == "5.0"


def test_kernels_run_as_plain_python_too(package, tmp_path):
    assert run(package, tmp_path, NUMBA_DISABLE_JIT="1")[0] == "5.0"
