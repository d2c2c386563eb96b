"""The same scenario, seed and versions give the same bits on every x86-64 processor, with every number of threads.

No attempt calls BLAS or LAPACK, whose sums differ between processors, except where the result is rounded.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import attempt_bits
import blas_watch
from places import ROOT

pytestmark = pytest.mark.slow

CPU = Path("/proc/cpuinfo")
HAS_AVX512 = CPU.is_file() and " avx512f " in CPU.read_text()

ELSEWHERE = {
    "a processor of 2008, two threads": {"OPENBLAS_CORETYPE": "Nehalem", "OMP_NUM_THREADS": "2"},
    "a processor with AVX2": {
        "OPENBLAS_CORETYPE": "Haswell",
        "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR",
    },
    "a processor with AVX-512": {"OPENBLAS_CORETYPE": "SkylakeX"},
}
"""Variables that let BLAS and numpy take the code for another processor; names as in numpy 2.4 and OpenBLAS 0.3."""

REPEATED = ("spheres_wall", "cubes_wall")
"""Attempts that are repeated as on other processors: motion control and impedance control."""

ROUNDED = {"sim/start_posture.py"}
"""Files whose result is rounded to far more than the difference."""

watched = pytest.mark.skipif(bool(blas_watch.missing()) and not os.environ.get("CI"), reason=blas_watch.missing())


def found_with(variables, cache, scenarios=attempt_bits.ATTEMPTS):
    """Run attempts in a new process with an empty cache of piles, and return their digests."""
    fixed = {"OMP_NUM_THREADS": "1", "XDG_CACHE_HOME": str(cache), "PYTHONPATH": str(ROOT)}
    environment = os.environ | fixed | variables
    command = [sys.executable, attempt_bits.__file__, *scenarios]
    done = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return blas_watch.build(tmp_path_factory.mktemp("watch"))


@pytest.fixture(scope="module")
def attempts(request, tmp_path_factory):
    """The digests of all attempts, and their calls of BLAS if these can be watched here."""
    folder = tmp_path_factory.mktemp("here")
    log = folder / "calls"
    watch = {} if blas_watch.missing() else blas_watch.variables(request.getfixturevalue("library"), log)
    return found_with(watch, folder / "cache"), blas_watch.calls_in(log)


@pytest.fixture
def here(attempts):
    return attempts[0]


@pytest.mark.parametrize("place", ELSEWHERE)
def test_an_attempt_has_the_same_bits_on(place, here, tmp_path):
    if "SkylakeX" in ELSEWHERE[place].values() and not HAS_AVX512:
        pytest.skip("this processor has no AVX-512")
    expected = {scenario: here[scenario] for scenario in REPEATED}
    assert found_with(ELSEWHERE[place], tmp_path, REPEATED) == expected


def test_an_attempt_has_the_bits_that_are_kept(here):
    """Another machine wrote them; `python tests/helpers/attempt_bits.py --write` writes them anew."""
    if not attempt_bits.KEPT.is_file():
        pytest.skip("no digests are kept; write them by python tests/helpers/attempt_bits.py --write")
    kept = json.loads(attempt_bits.KEPT.read_text(encoding="utf-8"))
    if kept["versions"] != attempt_bits.deciding_versions():
        pytest.skip("other versions than those of the kept digests are installed; see constraints.txt")
    assert here == kept["digests"]


@watched
def test_no_attempt_calls_blas_from_set_up_to_verdict(attempts):
    _, calls = attempts
    assert {file for _, file, _ in calls} & ROUNDED  # the watch sees calls
    assert [call for call in calls if call[1] not in ROUNDED] == []


@watched
def test_the_watch_names_function_and_line(library, tmp_path):
    expressions = {
        "a @ b": "scipy_cblas_dgemm64_",
        "a.dot(c)": "scipy_cblas_dgemv64_",
        "c.dot(c)": "scipy_cblas_ddot64_",
        "a @ a.T": "scipy_cblas_dsyrk64_",
        "np.linalg.inv(a)": "scipy_dgesv_64_",
    }
    text = "\n".join(("import numpy as np", "a, b, c = np.eye(3), np.ones((3, 3)), np.ones(3)", *expressions))
    # The watch looks for the innermost file in the package.
    code = f"exec(compile({text!r}, {str(blas_watch.PACKAGE / 'here.py')!r}, 'exec'))"
    environment = os.environ | blas_watch.variables(library, tmp_path / "calls")
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)
    calls = blas_watch.calls_in(tmp_path / "calls")
    for line, function in enumerate(expressions.values(), start=3):
        assert (function, "here.py", line) in calls
