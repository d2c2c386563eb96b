"""Print the lowest version of each package that pyproject.toml allows, as constraints for pip.

Usage: python tests/helpers/lowest_versions.py > build/lowest.txt
"""

import re
import tomllib

from places import ROOT


def lowest_versions() -> dict[str, str]:
    """Return the lowest allowed version of each direct dependency, by package; those of the tests are left out."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    lines = [*project["dependencies"], *(line for name, found in extras.items() if name != "dev" for line in found)]
    found = {}
    for line in lines:
        match = re.match(r"([\w.-]+)(?:\[\w+\])?\s*>=\s*([\d.]+)", line)
        if match:
            found[match[1]] = match[2]
    return found


if __name__ == "__main__":
    print("\n".join(f"{name}=={version}" for name, version in lowest_versions().items()))
