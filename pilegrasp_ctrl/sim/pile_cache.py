"""Settled piles on disk: one file for each hash of everything on which a pile depends, believed after a check only."""

from __future__ import annotations

import hashlib
import io
import json
from typing import Any

import numpy as np

from ..exceptions import PilegraspError
from ..files import cache_folder, read_file, write_whole
from ..types import Array

MAX_NORM_ERROR = 1e-6
"""Largest deviation of a quaternion's squared length from 1 [-], chosen; MuJoCo keeps 1e-15."""

_DIGEST_SIZE = 32
_BYTES_FOR_A_BODY = 64
_BYTES_BESIDE = 4096


class PileCache:
    """The file of one pile in `~/.cache/pilegrasp`. Errors of reading and writing are ignored.

    The file is an `.npz`, and behind it a digest of what the pile depends on and of the `.npz`.
    """

    def __init__(self, *content: Any) -> None:
        """Name the file by a hash of the JSON values `content`, on which the pile depends."""
        self._key = hashlib.sha256(json.dumps(content).encode()).hexdigest()
        self.file = cache_folder() / "pilegrasp" / "piles" / f"{self._key[:24]}.npz"

    def read(self, count: int) -> tuple[Array, float] | None:
        """Return poses (count, 7) and packing density, or None if the file is missing or is not what was written."""
        try:
            content = read_file(self.file, _BYTES_BESIDE + _BYTES_FOR_A_BODY * count)
        except PilegraspError:
            return None
        body, digest = content[:-_DIGEST_SIZE], content[-_DIGEST_SIZE:]
        if digest != self._digest(body):
            return None
        with np.load(io.BytesIO(body), allow_pickle=False) as arrays:
            poses, density = arrays["poses"], arrays["packing_density"]
        return (poses, float(density)) if _is_pile(poses, count) and np.isfinite(density) else None

    def write(self, poses: Array, density: float) -> None:
        """Write the file whole, so that a killed process leaves nothing half-written."""
        buffer = io.BytesIO()
        np.savez(buffer, poses=poses, packing_density=density)
        body = buffer.getvalue()
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            write_whole(self.file, body + self._digest(body))
        except OSError:
            return

    def _digest(self, body: bytes) -> bytes:
        return hashlib.sha256(self._key.encode() + body).digest()


def _is_pile(poses: Array, count: int) -> bool:
    """Return whether poses (n, 7) can be those of `count` bodies: finite, with quaternions of unit length."""
    if poses.shape != (count, 7) or not np.isfinite(poses).all():
        return False
    squares = poses[:, 3:] * poses[:, 3:]
    lengths = squares[:, 0] + squares[:, 1] + squares[:, 2] + squares[:, 3]
    return bool((np.abs(lengths - 1.0) < MAX_NORM_ERROR).all())
