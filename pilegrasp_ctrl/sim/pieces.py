"""Convex pieces of a mesh: computed by CoACD, stored beside the part, or kept in the user's cache."""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import sys
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path

import numpy as np

from ..exceptions import ConfigurationError
from ..files import MAX_MESH_SIZE, read_file, write_whole
from ..scenarios import PIECES_SUFFIX
from ..types import Array
from .pile_cache import cache_folder
from .triangles import Triangles

THRESHOLD = 0.05
"""Largest concavity of a piece, over the size of the mesh [-]: CoACD's own value."""

MAX_PIECES = 24
"""Largest number of pieces of a mesh [-]; chosen: the time of a step grows with the square of the pieces in a pile."""

MAX_VERTICES = 64
"""Largest number of vertices of a piece [-]; chosen, because the time of a collision grows with it."""

SEED = 0
"""Seed of the decomposition."""

TIME_LIMIT = 300.0
"""Longest time of a decomposition [s]; chosen."""

_WORKER = """
import sys
import numpy as np
import coacd
coacd.set_log_level("off")
numbers = np.load(sys.argv[1])
found = coacd.run_coacd(
    coacd.Mesh(numbers["vertices"], numbers["faces"]), threshold=float(sys.argv[3]), max_convex_hull=int(sys.argv[4]),
    preprocess_mode="off", decimate=True, max_ch_vertex=int(sys.argv[5]), seed=int(sys.argv[6]),
)
np.savez(sys.argv[2], **{f"piece_{index}": np.asarray(vertices) for index, (vertices, _) in enumerate(found)})
"""
"""Program that decomposes a mesh; a process of its own has one thread, a time limit, and may crash."""

_HEADER = re.compile(r"# pieces of ([0-9a-f]{64})\n")


def pieces_path(mesh: Path) -> Path:
    """Return the file of the pieces beside a mesh: `bracket.stl.pieces.obj` for `bracket.stl`."""
    return mesh.with_name(f"{mesh.name}{PIECES_SUFFIX}")


def decompose(mesh: Triangles, name: str) -> list[Array]:
    """Return the vertices (n, 3) of each convex piece, in the axes and unit of the mesh.

    The same mesh gives the same pieces on the same machine: the seed is fixed, and CoACD runs on one thread in a
    process of its own. Its result on another processor is outside the guarantee of equal bits; stored pieces are not.

    Raises:
        ConfigurationError: CoACD is not installed, fails, or does not end.
    """
    import tempfile

    with tempfile.TemporaryDirectory(prefix="pilegrasp-pieces-") as folder:
        source, result = Path(folder) / "mesh.npz", Path(folder) / "pieces.npz"
        np.savez(source, vertices=mesh.vertices, faces=mesh.faces)
        numbers = (THRESHOLD, MAX_PIECES, MAX_VERTICES, SEED)
        command = [sys.executable, "-c", _WORKER, str(source), str(result), *map(str, numbers)]
        threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        try:
            done = subprocess.run(
                command, env=os.environ | threads, stdin=subprocess.DEVNULL, capture_output=True, timeout=TIME_LIMIT
            )
        except subprocess.TimeoutExpired:
            raise ConfigurationError(
                f"{name}: its mesh of {len(mesh.faces)} triangles is not decomposed within {TIME_LIMIT:.0f} s; reduce "
                "it in your CAD program, or make hull = true"
            ) from None
        if done.returncode or not result.is_file():
            why = done.stderr.decode("utf-8", "replace").strip().splitlines()[-1:] or ["it crashed"]
            raise ConfigurationError(f"{name}: CoACD cannot decompose its mesh: {why[0]:.120}; make hull = true")
        with np.load(result) as arrays:
            return [arrays[f"piece_{index}"] for index in range(len(arrays.files))]


def pieces_text(pieces: list[Array], mesh_digest: str) -> str:
    """Return the pieces as the text of an OBJ file, one object each, with all digits."""
    lines = [f"# pieces of {mesh_digest}", f"# CoACD {version('coacd')}, threshold {THRESHOLD}, seed {SEED}"]
    for index, vertices in enumerate(pieces):
        lines.append(f"o piece_{index}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    return "\n".join(lines) + "\n"


def read_pieces(file: Path, mesh_digest: str) -> list[Array]:
    """Return the vertices (n, 3) of each piece of a stored file.

    Raises:
        ConfigurationError: The file is damaged, or belongs to another mesh.
    """
    text = read_file(file, MAX_MESH_SIZE, "of convex pieces").decode("utf-8", "replace")
    header = _HEADER.match(text)
    remedy = "make it anew by `pilegrasp check PART --write`, or remove it"
    if header is None:
        raise ConfigurationError(f"{file}: is not a file of convex pieces; {remedy}")
    if header[1] != mesh_digest:
        raise ConfigurationError(f"{file}: holds the pieces of another mesh; {remedy}")
    pieces: list[list[list[float]]] = []
    try:
        for line in text.splitlines():
            kind, _, rest = line.partition(" ")
            if kind == "o":
                pieces.append([])
            elif kind == "v":
                x, y, z = map(float, rest.split())
                pieces[-1].append([x, y, z])
    except (ValueError, IndexError):
        raise ConfigurationError(f"{file}: has a line that is not three numbers; {remedy}") from None
    arrays = [np.array(piece) for piece in pieces]
    if not arrays or any(len(piece) < 4 or not np.isfinite(piece).all() for piece in arrays):
        raise ConfigurationError(f"{file}: has a piece without four finite corners; {remedy}")
    return arrays


def write_pieces(mesh: Path, pieces: list[Array], mesh_digest: str) -> Path:
    """Store the pieces beside a mesh, and return their file.

    Raises:
        ConfigurationError: The file cannot be written.
    """
    path = pieces_path(mesh)
    try:
        write_whole(path, pieces_text(pieces, mesh_digest).encode())
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be written: {error.strerror}") from None
    return path


@lru_cache(maxsize=32)
def _read_cached(file: Path, digest: str) -> tuple[Array, ...]:
    return tuple(read_pieces(file, digest))


def cached_pieces(mesh: Triangles, mesh_digest: str, name: str) -> list[Array]:
    """Return the pieces of a mesh whose part has none beside it, from the user's cache or computed now."""
    settings = f"{mesh_digest} {THRESHOLD} {MAX_PIECES} {MAX_VERTICES} {SEED} {version('coacd')}"
    key = hashlib.sha256(settings.encode()).hexdigest()[:24]
    file = cache_folder() / "pilegrasp" / "pieces" / f"{key}.obj"
    if file.is_file():
        try:
            return list(_read_cached(file, mesh_digest))
        except ConfigurationError:
            pass  # damaged: made anew
    pieces = decompose(mesh, name)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, pieces_text(pieces, mesh_digest).encode())
    except OSError:
        pass
    return pieces
