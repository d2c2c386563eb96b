"""What a result depends on beside its scenario: versions, code, and files of robots and objects."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from ..config import Scenario
from ..exceptions import ConfigurationError
from ..provenance import code_digest, digest, version_of, versions
from ..robots import path as robot_file
from ..scenarios import object_digests, object_files

SOLVERS = {"osqp": "osqp", "proxqp": "proxsuite", "quadprog": "quadprog"}
"""Packages of those solvers that not every attempt uses."""


def origins_of(scenarios: Iterable[Scenario], measure: str | None = None) -> dict[str, str]:
    """Return everything that ships and that the scenarios' results depend on: a version or digest by name.

    What a scenario says and the files of the user count in its `config_hash`.

    Raises:
        ConfigurationError: A file cannot be read, or the module of `measure` cannot be found.
        ModelError: A robot or hand is not known.
    """
    found = versions() | {"the simulation's code": code_digest()}
    found["measure"] = measure or "none"
    if measure is not None:
        found["the measure's code"] = _measure(measure)
    shipped = object_files()
    for scenario in scenarios:
        for folder in ((scenario.robot,), ("hands", scenario.hand)):
            found["/".join(("robots", *folder))] = _folder(robot_file(*folder))
        if scenario.pile.count and scenario.pile.object in shipped:
            found[f"objects/{scenario.pile.object}"] = _object(shipped[scenario.pile.object])
        if package := SOLVERS.get(scenario.controller.solver):
            found[package] = version_of(package)
        if scenario.controller.compiled:
            found["numba"] = version_of("numba")
    return found


def compare(known: Mapping[str, str], asked: Mapping[str, str], where: str, remedy: str) -> None:
    """Refuse origins that differ; a name that is only in one of the two is no difference.

    Raises:
        ConfigurationError: An identity differs; the sentence gives the first such name, and the remedy.
    """
    for name, identity in asked.items():
        if known.get(name, identity) != identity:
            if _is_digest(known[name]):
                reason = f"{name} differs from what it was for {where}"
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
    """Refuse an attempt whose origins in this process differ from the planned ones; done once for each configuration.

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


def _folder(folder: Path) -> str:
    """Return a digest of the files of a robot or hand, without README and Python files, which decide nothing."""
    files = sorted(file for file in folder.rglob("*") if file.is_file() and file.suffix not in (".md", ".py", ".pyc"))
    return digest((str(file.relative_to(folder)), file.read_bytes()) for file in files)


def _object(file: Path) -> str:
    return digest(("", digest.encode()) for digest in object_digests(file))


def _measure(name: str) -> str:
    """Return a digest of the measure's module and of the other modules of its package, which it may use."""
    module = name.rpartition(".")[0]
    try:
        file = import_module(module).__file__
    except (ImportError, ValueError) as error:
        raise ConfigurationError(
            f"measure = {name!r} cannot be imported ({error}); give package.module.function"
        ) from None
    if file is None:
        return "none"
    files = sorted(Path(file).parent.rglob("*.py")) if "." in module else [Path(file)]
    return digest((other.name, other.read_bytes()) for other in files)
