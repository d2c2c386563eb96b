"""What the tab key offers in a shell: scenarios, files, and keys of a scenario."""

from __future__ import annotations

import os
from glob import escape, glob


def complete_scenario(incomplete: str) -> list[str]:
    """Return names of shipped scenarios, and folders and TOML files, that begin with a text."""
    from ..scenarios import names

    paths = sorted(glob(f"{escape(incomplete)}*"))
    folders = [f"{path}/" for path in paths if os.path.isdir(path)]
    files = [path for path in paths if path.endswith(".toml")]
    return [name for name in names() if name.startswith(incomplete)] + files + folders


def complete_setting(incomplete: str) -> list[str]:
    """Return the keys that begin with a text, each with its equals sign."""
    from ..config import dotted_keys

    return [f"{key}=" for key in dotted_keys() if key.startswith(incomplete)]
