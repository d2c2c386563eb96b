"""Write the table of licences into docs/licences.md, from the metadata of the installed packages.

Usage: python tests/helpers/licence_table.py (or `make licences`)
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from pilegrasp_ctrl.statistics import markdown_table
from places import DOCS, ROOT

PAGE = DOCS / "licences.md"
"""Page of the table."""

START, END = "<!-- table -->", "<!-- end of the table -->"
"""Comments around the table."""

STATED = {
    "asttokens": "Apache-2.0",
    "cmeel-qhull": "Qhull",
    "imageio-ffmpeg": "BSD-2-Clause; the ffmpeg in its wheel is GPL-3.0-or-later",
    "matplotlib": "PSF-2.0 based",
    "pin-pink": "Apache-2.0",
    "pybullet": "Zlib",
    "scipy": "BSD-3-Clause",
}
"""Licences as the projects' pages state them, where the metadata say nothing or hold a whole text."""

SHORT = {
    "Apache 2.0": "Apache-2.0",
    "Apache Software License": "Apache-2.0",
    "BSD License": "BSD",
    "BSD 3-Clause License": "BSD-3-Clause",
    "GNU General Public License v2 or later (GPLv2+)": "GPL-2.0-or-later",
    "GNU Lesser General Public License v3 (LGPLv3)": "LGPL-3.0",
    "GPLv2+": "GPL-2.0-or-later",
    "ISC License": "ISC",
    "ISC License (ISCL)": "ISC",
    "ISC license": "ISC",
    "MIT License": "MIT",
    "Mozilla Public License 2.0 (MPL 2.0)": "MPL-2.0",
    "Python Software Foundation License": "PSF-2.0",
}
"""Shorter names of licences."""


def packages() -> dict[str, str]:
    """Return the names of all packages that constraints.txt pins or pyproject.toml names, by canonical name."""
    pinned = [line.split("==")[0] for line in (ROOT / "constraints.txt").read_text(encoding="utf-8").split()]
    named = [requirement.name for found in requirements().values() for requirement in found]
    return {canonicalize_name(name): name for name in (*named, *pinned)}


@cache
def requirements() -> dict[str, list[Requirement]]:
    """Return the direct requirements of the library and of each extra."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    groups = {"library": project["dependencies"], **project["optional-dependencies"]}
    return {name: [Requirement(line) for line in lines] for name, lines in groups.items()}


def licence(name: str) -> str | None:
    """Return the licence of a package; None if it is neither installed nor stated above."""
    if canonicalize_name(name) in STATED:
        return STATED[canonicalize_name(name)]
    try:
        metadata = distribution(name).metadata
    except PackageNotFoundError:
        return None
    classified = [line.split(" :: ")[-1] for line in metadata.get_all("Classifier") or () if line.startswith("License")]
    free = (metadata.get("License") or "").strip().split("\n")[0]
    plain = free if re.fullmatch(r"[\w.+ -]{2,30}", free) and free != "UNKNOWN" else ""
    found = metadata.get("License-Expression") or SHORT.get(plain, plain) or ", ".join(classified)
    return SHORT.get(found, found) or None


def needs(roots: Iterable[Requirement]) -> set[str]:
    """Return the canonical names of the packages that these need, directly or not, as far as they are installed."""
    found: set[str] = set()
    waiting = [(requirement, ("",)) for requirement in roots]
    while waiting:
        requirement, extras = waiting.pop()
        name = canonicalize_name(requirement.name)
        marker = requirement.marker
        if name in found or (marker and not any(marker.evaluate({"extra": extra}) for extra in extras)):
            continue
        found.add(name)
        try:
            lines = distribution(name).requires or []
        except PackageNotFoundError:
            continue
        waiting += [(Requirement(line), ("", *requirement.extras)) for line in lines]
    return found


def uses() -> dict[str, str]:
    """Return what each package is for, by canonical name: the library, extras, or tests and checks alone."""
    library = needs(requirements()["library"])
    found: dict[str, list[str]] = {}
    for extra, roots in requirements().items():
        if extra not in ("library", "dev"):
            for name in needs(roots) - library:
                found.setdefault(name, []).append(extra)
    shown = {name: f"extra {', '.join(extras)}" for name, extras in found.items()}
    return {name: "library" if name in library else shown.get(name, "tests") for name in packages()}


def rows() -> list[tuple[str, str, str]]:
    """Return package, licence and use of all packages; those of the library first."""
    order = {"library": 0, "tests": 2}
    use = uses()
    listed = [(name, licence(name) or "?", use[key]) for key, name in packages().items()]
    return sorted(listed, key=lambda row: (order.get(row[2], 1), row[2], row[0].lower()))


if __name__ == "__main__":
    text = PAGE.read_text(encoding="utf-8")
    head, _, rest = text.partition(START)
    table = markdown_table(("package", "licence", "for"), rows())
    PAGE.write_text(f"{head}{START}\n\n{table}\n\n{END}{rest.partition(END)[2]}", encoding="utf-8")
