"""Settled piles on disk: one file for each hash of everything on which a pile depends."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from ..files import whole_file
from ..types import Array


class PileCache:
    """The file of one pile in `~/.cache/pilegrasp`. Errors of reading and writing are ignored."""

    def __init__(self, *content: Any) -> None:
        """Name the file by a hash of the JSON values `content`, on which the pile depends."""
        digest = hashlib.sha256(json.dumps(content).encode()).hexdigest()[:24]
        self.file = cache_folder() / "pilegrasp" / "piles" / f"{digest}.npz"

    def read(self, count: int) -> tuple[Array, float] | None:
        """Return poses (count, 7) and packing density, or None if the file is missing or damaged."""
        try:
            with np.load(self.file, allow_pickle=False) as arrays:
                poses, density = arrays["poses"], arrays["packing_density"]
        except (OSError, ValueError, EOFError, KeyError, zipfile.BadZipFile):
            return None
        fits = poses.shape == (count, 7) and np.isfinite(poses).all() and density.shape == () and np.isfinite(density)
        return (poses, float(density)) if fits else None

    def write(self, poses: Array, density: float) -> None:
        """Write through a temporary file, so that a killed process leaves nothing half-written."""
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            with whole_file(self.file) as beside, beside.open("wb") as file:
                np.savez(file, poses=poses, packing_density=density)
        except OSError:
            return


def cache_folder() -> Path:
    """Return the user's folder for caches."""
    root = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if root.is_absolute():
        return root
    try:
        return Path.home() / ".cache"
    except RuntimeError:  # a user without a home, as in some containers
        return Path(tempfile.gettempdir())
