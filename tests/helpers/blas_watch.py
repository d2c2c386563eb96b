"""Which lines of the library call BLAS or LAPACK: a C library that is preloaded into a Python process."""

import platform
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

from places import ROOT

SOURCE = Path(__file__).with_suffix(".c")
PACKAGE = ROOT / "pilegrasp_ctrl"


def missing():
    """Return why calls cannot be watched here, or an empty text."""
    if sys.platform != "linux" or platform.machine() != "x86_64":
        return "calls into BLAS are watched on Linux and x86-64 only"
    return "" if shutil.which("gcc") else "there is no gcc, which builds the watch of BLAS; install the package gcc"


def build(folder):
    """Compile the library into a folder, and return its path."""
    library = folder / "blas_watch.so"
    subprocess.run(["gcc", "-shared", "-fPIC", "-O1", "-o", str(library), str(SOURCE), "-ldl"], check=True)
    return library


def variables(library, log):
    """Return the variables with which a new process writes its calls down in the file `log`."""
    return {"LD_PRELOAD": str(library), "BLAS_WATCH_LOG": str(log), "BLAS_WATCH_ROOT": f"{PACKAGE}/"}


def calls_in(log):
    """Return the numbers of calls in a file by function, file in the package and line."""
    calls = {}
    for line, count in Counter(log.read_text().splitlines() if log.exists() else []).items():
        function, file, number = line.split("\t")
        calls[function, file.removeprefix(f"{PACKAGE}/"), int(number)] = count
    return calls
