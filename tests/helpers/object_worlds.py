"""Small worlds of objects alone: compiled models, settled piles, and object files with a mesh."""

from pilegrasp_ctrl.config import PileConfig, SupportConfig
from pilegrasp_ctrl.planning.layout import make_layout
from pilegrasp_ctrl.sim.object_file import write_object
from pilegrasp_ctrl.sim.pile import settle_pile
from pilegrasp_ctrl.sim.scene import add_objects, new_spec

BRICK = [(x, y, z) for x in (0, 40) for y in (0, 60) for z in (0, 30)]
"""Corners of a brick [mm]."""

BRICK_FACES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
BRICK_FACES += [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]


def compile_objects(objects, count=1):
    """Return the MuJoCo model of the objects alone, without gravity."""
    spec = new_spec(1e-3)
    add_objects(spec, objects, count, [], "paper")
    spec.option.gravity = [0.0, 0.0, 0.0]
    return spec.compile()


def settled_poses(objects, count, **pile):
    """Return the poses (count, 7) of a pile on the open table with a wall."""
    layout = make_layout(SupportConfig(), PileConfig(count=count, **pile), objects.diameter)
    return settle_pile(objects, count, layout, 0, "paper", 1e-3).poses


def write_ball(folder, name="thing", **keys):
    """Write the file of an object, by default a ball of 30 g."""
    return write_object(folder / f"{name}.toml", **({"shape": "sphere", "radius": 0.02, "mass": 0.03} | keys))


def write_mesh(path, vertices=BRICK, faces=BRICK_FACES):
    """Write an OBJ file, by default of a brick."""
    lines = [f"v {x} {y} {z}" for x, y, z in vertices]
    path.write_text("\n".join(lines + ["f " + " ".join(str(i + 1) for i in face) for face in faces]) + "\n")
    return path
