"""The origins of a result, beside its scenario: versions, code, and files of robots and objects."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from ..config import Scenario
from ..exceptions import ConfigurationError
from ..provenance import code_digest, digest, version_of, versions
from ..robots import path as robot_file
from ..scenarios import object_digests, object_files

SOLVERS = {"osqp": "osqp", "proxqp": "proxsuite", "quadprog": "quadprog"}
"""Package of each solver that only some attempts use."""


def origins_of(scenarios: Iterable[Scenario], measure: str | None = None) -> dict[str, str]:
    """Return the version or digest of everything in this installation that the scenarios' results depend on, by name.

    The scenario's own values and the files of the user are part of its `config_hash`.

    Raises:
        ConfigurationError: A file cannot be read, or the module of `measure` cannot be found.
        ModelError: A robot or hand is not known.
    """
    found = versions() | {"the simulation's code": code_digest()}
    found["measure"] = measure or "none"
    if measure is not None:
        found["the measure's code"] = _measure_digest(measure)
    shipped = object_files()
    for scenario in scenarios:
        for folder in ((scenario.robot,), ("hands", scenario.hand)):
            found["/".join(("robots", *folder))] = _folder_digest(robot_file(*folder))
        if scenario.pile.count and scenario.pile.object in shipped:
            found[f"objects/{scenario.pile.object}"] = _object_digest(shipped[scenario.pile.object])
        if package := SOLVERS.get(scenario.controller.solver):
            found[package] = version_of(package)
        if scenario.controller.compiled:
            found["numba"] = version_of("numba")
    return found


def compare(known: Mapping[str, str], asked: Mapping[str, str], where: str, remedy: str) -> None:
    """Refuse origins that differ; a name that only one of the two has does not count.

    Raises:
        ConfigurationError: An identity differs; the error gives the first such name and the remedy.
    """
    for name, identity in asked.items():
        if known.get(name, identity) != identity:
            if _is_digest(known[name]):
                reason = f"{name} has another digest here than for {where}"
            else:
                reason = f"{name} is {known[name]} for {where}, and {identity} here"
            raise ConfigurationError(f"{reason}; {remedy}")


def difference(known: Mapping[str, Any], asked: Mapping[str, Any], prefix: str = "") -> str:
    """Return a sentence with the first key in which two configurations differ, and both values."""
    for key in [*known, *(key for key in asked if key not in known)]:
        old, new = known.get(key), asked.get(key)
        if old != new:
            if isinstance(old, dict) and isinstance(new, dict):
                return difference(old, new, f"{prefix}{key}.")
            return f"{prefix}{key} = {_shown(old)} there, and {_shown(new)} is asked for"
    return "it was made by another version of this program"


def _shown(value: Any) -> str:
    return "absent" if value is None else f"{json.dumps(value, ensure_ascii=False):.80}"


_checked: set[tuple[str, str | None, str]] = set()


def check_origins(planned: Mapping[str, str], scenario: Scenario, measure: str | None) -> None:
    """Refuse an attempt whose origins in this process differ from the planned ones; each configuration is checked once.

    Raises:
        ConfigurationError: An origin differs.
    """
    key = (scenario.config_hash(), measure, repr(sorted(planned.items())))
    if key not in _checked:
        here = origins_of([scenario], measure)
        compare(planned, here, "the study", "give every worker the same installation and start the workers anew")
        _checked.add(key)


def _is_digest(identity: str) -> bool:
    return identity.startswith("sha256:")


def _folder_digest(folder: Path) -> str:
    """Return a digest of a robot's or hand's files; README and Python files are left out, as no result uses them."""
    files = sorted(file for file in folder.rglob("*") if file.is_file() and file.suffix not in (".md", ".py", ".pyc"))
    return digest((str(file.relative_to(folder)), file.read_bytes()) for file in files)


def _object_digest(file: Path) -> str:
    return digest(("", part.encode()) for part in object_digests(file))


def measure_module(name: str) -> ModuleType:
    """Return the module of a measure with the dotted name `package.module.function`.

    Raises:
        ConfigurationError: The module cannot be imported.
    """
    try:
        return import_module(name.rpartition(".")[0])
    except (ImportError, ValueError) as error:
        raise ConfigurationError(
            f"measure = {name!r} cannot be imported ({error}); give package.module.function"
        ) from None


def _measure_digest(name: str) -> str:
    """Return a digest of the measure's module and of the other modules of its package, which it may use."""
    file = measure_module(name).__file__
    if file is None:
        return "none"
    in_package = "." in name.rpartition(".")[0]
    files = sorted(Path(file).parent.rglob("*.py")) if in_package else [Path(file)]
    return digest((other.name, other.read_bytes()) for other in files)
