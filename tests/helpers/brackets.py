"""An angle bracket that is not convex, with pieces as CoACD would store them: two plates."""

import hashlib

import numpy as np

from pilegrasp_ctrl.scenarios import PIECES_SUFFIX
from pilegrasp_ctrl.sim.object_file import write_object

OUTLINE = [(0, 0), (50, 0), (50, 5), (5, 5), (5, 50), (0, 50)]
"""Corners of the bracket's section [mm]."""

DEPTH = 30
"""Depth of the bracket [mm]."""

VERTICES = [(x, y, z) for z in (0, DEPTH) for x, y in OUTLINE]
FACES = [(0, 2, 1), (0, 3, 2), (0, 4, 3), (0, 5, 4), (6, 7, 8), (6, 8, 9), (6, 9, 10), (6, 10, 11)]
FACES += [face for i in range(6) for j in [(i + 1) % 6] for face in ((i, j, j + 6), (i, j + 6, i + 6))]

SECTIONS = (((0, 50), (0, 5)), ((0, 5), (5, 50)))
"""The plates' ranges along x and y [mm]."""

PLATES = [np.array([(x, y, z) for x in xs for y in ys for z in (0, DEPTH)]) for xs, ys in SECTIONS]


def write_bracket(folder, stored=True, vertices=VERTICES, faces=FACES, **keys):
    """Write mesh and file of the bracket, with its pieces if `stored`; return the file."""
    mesh = folder / "bracket.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in vertices]
    mesh.write_text("\n".join(lines + ["f " + " ".join(str(i + 1) for i in face) for face in faces]) + "\n")
    if stored:
        store(mesh)
    return write_object(
        folder / "bracket.toml", **({"shape": "mesh", "file": "bracket.obj", "unit": "mm", "mass": 0.11} | keys)
    )


def store(mesh, pieces=PLATES):
    """Store the pieces of a mesh beside it."""
    lines = [f"# pieces of {hashlib.sha256(mesh.read_bytes()).hexdigest()}"]
    for number, piece in enumerate(pieces):
        lines += [f"o piece_{number}", *(f"v {x} {y} {z}" for x, y, z in piece)]
    mesh.with_name(mesh.name + PIECES_SUFFIX).write_text("\n".join(lines) + "\n")
