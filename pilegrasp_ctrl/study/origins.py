"""The origins of a result, beside its scenario: versions, code, and files of robots and objects."""

from __future__ import annotations

import json
import platform
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ..config import Scenario
from ..exceptions import ConfigurationError
from ..hand_folder import is_path
from ..plugins import plugin_digest
from ..provenance import (
    SOLVER_PACKAGES,
    code_digest,
    deciding_packages,
    digest,
    python_version,
    version_of,
    versions,
)
from ..robots import folder_digest, is_folder
from ..scenarios import object_digests, object_files, object_parts


def origins_of(scenarios: Iterable[Scenario], measure: str | None = None) -> dict[str, str]:
    """Return the version or digest of everything in this installation that the scenarios' results depend on, by name.

    Names and files are found from the code and the scenarios. The scenario's own values, the files of the user and the
    code of a plan are part of its `config_hash`.

    Raises:
        ConfigurationError: A file cannot be read, or the module of `measure` cannot be found.
        ModelError: A robot or hand is not known.
    """
    found = {"Python": python_version(), "machine": platform.machine()} | versions()
    found |= {package: version_of(package) for package in deciding_packages()}
    found |= {"the simulation's code": code_digest(), "measure": measure or "none"}
    if measure is not None:
        found["the measure's code"] = plugin_digest(measure, "measure", ("recording",))
    shipped = object_files()
    for scenario in scenarios:
        # A user's folder counts in config_hash, and its path may differ between two workers.
        arms = [scenario.robot] if not is_folder(scenario.robot) else []
        used = [scenario.hand, *filter(None, [scenario.strategy.pushing_hand])]
        hands = [f"hands/{hand}" for hand in used if not is_path(hand)]
        for robot in (*arms, *hands):
            found[f"robots/{robot}"] = folder_digest(robot)
        if scenario.pile.count:
            for name in object_parts(scenario.pile.object):
                if name in shipped:
                    found[f"objects/{name}"] = _object_digest(shipped[name])
        packages, _ = SOLVER_PACKAGES[scenario.controller.solver]
        found |= {package: version_of(package) for package in packages}
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


def _object_digest(file: Path) -> str:
    return digest(("", part.encode()) for part in object_digests(file))
