"""Prints the table of objects that docs/objects.md holds: `python tests/helpers/object_table.py`."""

import tomllib

from pilegrasp_ctrl.scenarios import object_files
from pilegrasp_ctrl.sim.object_file import VARIANTS, read_object
from pilegrasp_ctrl.sim.object_model import ObjectModel
from pilegrasp_ctrl.statistics import markdown_table


def table() -> str:
    """Return every object and variant as a Markdown table, from the files alone."""
    header = ("object", "variant", "shape and size [mm]", "mass [g]", "moments of inertia [g·cm²]")
    lines = []
    for name, file in object_files().items():
        keys = tomllib.loads(file.read_text(encoding="utf-8"))
        for variant in VARIANTS:
            if variant == "real" or variant in keys:
                source = keys["source"] if variant == "real" else keys[variant]["source"]
                lines.append(_row(name, variant, read_object(file, variant), source))
    return markdown_table((*header, "restitution", "source"), lines)


def _row(name: str, variant: str, object_model: ObjectModel, source: str) -> list[str]:
    moments = [f"{1e7 * object_model.inertia_factor * moment:.0f}" for moment in object_model.solid_inertia()]
    inertia = moments[0] if len(set(moments)) == 1 else ", ".join(moments)
    cells = [f"`{name}`", f"`{variant}`", _size(object_model), f"{1000 * object_model.mass:g}", inertia]
    return [*cells, f"{object_model.surface.restitution:.3g}", source]


def _size(object_model: ObjectModel) -> str:
    shape, net = object_model.shape, object_model.net
    widths = [f"{2000 * half:g}" for half in object_model.half_size]
    size = f"{shape} ⌀ {widths[0]}" if shape in ("sphere", "cylinder") else f"{shape} {' × '.join(widths)}"
    size += f", height {widths[1]}" if shape == "cylinder" else ""
    return size + (f"; {net.members} in a loop of {1000 * net.loop:g}" if net else "")


if __name__ == "__main__":
    print(table())
