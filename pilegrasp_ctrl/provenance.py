"""Origin of a result: versions of the packages and a digest of the code that decide it."""

from __future__ import annotations

import hashlib
import platform
import re
import sys
from collections.abc import Iterable
from functools import cache
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

ABSENT = "absent"
"""Version of a package that is not installed."""


@cache
def version_of(package: str) -> str:
    """Return the version of an installed package, or `ABSENT`."""
    try:
        return version(package)
    except PackageNotFoundError:
        return ABSENT


VERSION = "0+uninstalled" if version_of("pilegrasp") == ABSENT else version_of("pilegrasp")
"""Version of this library."""

DECIDING_PACKAGES = ("mujoco", "pin", "numpy", "daqp", "mink")
"""Packages that a report names. A study's origins name all that decide, see `deciding_packages`."""

IMPORTED_AS = {"pinocchio": "pin"}
"""Packages that are imported under another name than their own."""

SOLVER_PACKAGES: dict[str, tuple[tuple[str, ...], str | None]] = {
    "daqp": (("daqp",), "daqp"),
    "osqp": (("osqp",), "osqp"),
    "proxqp": (("proxsuite",), "proxqp"),
    "quadprog": (("quadprog",), "quadprog"),
    "clarabel": (("clarabel",), "clarabel"),
    "copt": (("coptpy",), "copt"),
    "cvxopt": (("cvxopt",), "cvxopt"),
    "ecos": (("ecos",), "ecos"),
    "gurobi": (("gurobipy",), "gurobi"),
    "highs": (("highspy",), "highs"),
    "hpipm": (("hpipm_python",), None),
    "jaxopt_osqp": (("jaxopt",), "jaxopt"),
    "kvxopt": (("kvxopt",), "kvxopt"),
    "mosek": (("mosek", "cvxopt"), "mosek"),
    "nppro": (("nppro",), None),
    "pdhcg": (("pdhcg",), None),
    "piqp": (("piqp",), "piqp"),
    "pyqpmad": (("pyqpmad",), "pyqpmad"),
    "qpalm": (("qpalm",), "qpalm"),
    "qpax": (("qpax",), "qpax"),
    "qpoases": (("qpoases",), None),
    "qpswift": (("qpSWIFT",), None),
    "qtqp": (("qtqp",), "qtqp"),
    "scs": (("scs",), "scs"),
    "sip": (("sip-qp-python",), "sip"),
}
"""Packages of each solver that qpsolvers 4.13 knows, and the extra of qpsolvers that installs them, if there is one."""

ROOMS: tuple[tuple[str, ...], ...] = (
    (
        "types",
        "vectors",
        "exceptions",
        "files",
        "interruption",
        "config",
        "sections",
        "settings",
        "provenance",
        "statistics",
        "stored_rows",
        "plugins",
        "plugin_sources",
        "program_traits",
        "problems",
        "neutral_values",
        "model_files",
        "hand_folder",
        "hand_description",
        "robots",
        "scenarios",
    ),
    ("kernels",),
    ("arm",),
    ("tasks", "limits", "qp"),
    ("control",),
    ("trajectories", "primitives", "planning", "plant"),
    ("recording", "recording_parts", "analysis"),
    ("sim",),
    ("recorder", "episode", "programs"),
    ("viewer",),
    ("study", "tuning", "search", "validation", "learning"),
    ("cli", "scripts", "__init__", "__main__"),
)
"""Rooms and files of the package, lowest first: a room imports from its own row and from the rows above it. `scenarios`
and `robots` are the two finders alone. The scripts in `scenarios/` are the room `scripts`."""

DECIDING_ROOMS = tuple(room for row in ROOMS[: ROOMS.index(("viewer",))] for room in row)
"""Rooms whose code decides the result of an attempt."""

PILE_ROOMS = tuple(room for row in ROOMS[: ROOMS.index(("sim",)) + 1] for room in row)
"""Rooms whose code may decide a settled pile: a room imports from rows before it only."""


def python_version() -> str:
    """Return the version of Python without its last part, such as "3.11"."""
    return ".".join(platform.python_version_tuple()[:2])


@cache
def deciding_packages() -> tuple[str, ...]:
    """Return the packages that the deciding code imports, and all that these require, in the order of their names.

    They are read from the code and from the packages' own lists. A solver's package counts if another package requires
    it, as mink does daqp, and else only where a scenario chooses the solver.
    """
    solvers = {package for packages, _ in SOLVER_PACKAGES.values() for package in packages}
    names = {IMPORTED_AS.get(name, name) for file in deciding_files() for name in _imported(file)}
    found: dict[str, set[str]] = {}
    waiting = [(_normal(name), frozenset[str]()) for name in sorted(names - solvers)]
    while waiting:
        name, extras = waiting.pop()
        # A name without a version is a word of a docstring, or a package that this Python does not need.
        if (name in found and extras <= found[name]) or version_of(name) == ABSENT:
            continue
        found[name] = found.get(name, set()) | extras
        waiting += _required(name, found[name])
    return tuple(sorted(found))


def _imported(file: Path) -> set[str]:
    """Return the first names behind `import` and `from` in a file, without those of the standard library."""
    return {name.decode() for name in _IMPORT.findall(file.read_bytes())} - sys.stdlib_module_names - {"pilegrasp_ctrl"}


def _required(package: str, extras: set[str]) -> list[tuple[str, frozenset[str]]]:
    """Return the packages that an installed package requires, and their extras."""
    found = []
    for line in requires(package) or ():
        asked = set(_EXTRA.findall(line))
        name = _REQUIREMENT.match(line)
        if name and (not asked or asked & extras):
            found.append((_normal(name[1]), frozenset(re.findall(r"[\w.-]+", name[2] or ""))))
    return found


def _normal(name: str) -> str:
    """Return the one spelling of a package's name."""
    return re.sub(r"[-_.]+", "-", name).lower()


_IMPORT = re.compile(rb"^\s*(?:from|import)\s+([A-Za-z_]\w*)", re.MULTILINE)
_REQUIREMENT = re.compile(r"([\w.-]+)\s*(?:\[([^\]]*)\])?")
_EXTRA = re.compile(r"""\bextra\s*==\s*["']([^"']+)["']""")


def versions(*more: str) -> dict[str, str]:
    """Return the versions of the library, of `DECIDING_PACKAGES`, and of `more` packages, by name, for a report."""
    return {"pilegrasp": VERSION} | {package: version_of(package) for package in (*DECIDING_PACKAGES, *more)}


def dependencies() -> tuple[str, ...]:
    """Return the required packages without extras; `DECIDING_PACKAGES` if the library is not installed."""
    try:
        lines = requires("pilegrasp") or ()
    except PackageNotFoundError:
        return DECIDING_PACKAGES
    names = (_REQUIREMENT.match(line) for line in lines if "extra ==" not in line)
    return tuple(name[1] for name in names if name)


def digest(parts: Iterable[tuple[str, bytes]]) -> str:
    """Return "sha256:" and 32 digits of named contents."""
    total = hashlib.sha256()
    for name, content in parts:
        total.update(f"{name}\0{len(content)}\0".encode() + content)
    return f"sha256:{total.hexdigest()[:32]}"


@cache
def code_digest(*rooms: str) -> str:
    """Return a digest of the code of some rooms, by default of all that decide a result.

    The code is read once, because imported code does not change.
    """
    return digest((str(file.relative_to(_PACKAGE)), file.read_bytes()) for file in deciding_files(*rooms))


def deciding_files(*rooms: str) -> list[Path]:
    """Return the files of some rooms, by default of all that decide a result, in order."""
    return [file for room in rooms or DECIDING_ROOMS for file in _files(room)]


_PACKAGE = Path(__file__).resolve().parent
_FINDERS = ("scenarios", "robots")


def _files(room: str) -> list[Path]:
    if room in _FINDERS:
        return [_PACKAGE / room / "__init__.py"]
    return [file for file in sorted([*(_PACKAGE / room).rglob("*.py"), _PACKAGE / f"{room}.py"]) if file.is_file()]
