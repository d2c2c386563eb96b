"""Measure how deep bodies overlap in valid pushes, by kind of pair; the watchdog's limits are 1.5 times the deepest.

Usage: python docs/studies/overlap.py FILE FIRST LAST

Each seed runs the six conditions of `six_conditions.py` with the hand and three with the shovel. FILE gets a line of
JSON for each attempt; attempts that it holds are not run again.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from pilegrasp_ctrl.episode import run_attempt
from pilegrasp_ctrl.exceptions import SimulationError
from pilegrasp_ctrl.programs.attempt import prepare
from pilegrasp_ctrl.scenarios.paper.conditions import SHOVEL, grasp
from pilegrasp_ctrl.sim.monitors import KINDS, kinds_of
from pilegrasp_ctrl.sim.stepper import Stepper
from pilegrasp_ctrl.statistics import markdown_table
from script import run_script, seed_range
from six_conditions import CONDITIONS

SCOOPED = {f"{name}, shovel": grasp(name, hand=SHOVEL) for name in ("light_sphere", "heavy_sphere", "cube")}
"""Conditions with the shovel."""

FACTOR = 1.5
"""Limit of the watchdog over the deepest valid overlap [-]."""


class DepthStepper(Stepper):
    """A stepper that keeps the deepest overlap of each pair of kinds (3, 3) [m]."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        super().__init__(model, data)
        self._kinds = kinds_of(model)
        self.deepest = np.zeros((len(KINDS), len(KINDS)))

    def step(self) -> None:
        """Advance by one step, and note the overlaps."""
        super().step()
        if self.data.ncon:
            kinds = np.sort(self._kinds[self.data.contact.geom], axis=1)
            np.maximum.at(self.deepest, (kinds[:, 0], kinds[:, 1]), -self.data.contact.dist)


def measure(name: str, seed: int) -> dict[str, Any]:
    """Return the deepest overlaps of an attempt [mm], and whether it ended without an error."""
    attempt = prepare((CONDITIONS | SCOOPED)[name].scenario, seed)
    simulation = attempt.simulation
    simulation.stepper = stepper = DepthStepper(simulation.scene.model, simulation.data)
    valid = True
    try:
        run_attempt(attempt)
    except SimulationError:
        valid = False
    pairs = {
        f"{one}, {other}": round(1e3 * float(stepper.deepest[i, j]), 3)
        for i, one in enumerate(KINDS)
        for j, other in enumerate(KINDS)
        if i <= j and math.isfinite(stepper.deepest[i, j])
    }
    return {"name": name, "seed": seed, "valid": valid, "depths": pairs}


def main(file: Path, first: int, last: int) -> None:
    """Run the missing attempts, and print the deepest overlap of each kind of pair and the limit that follows."""
    rows = [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()] if file.is_file() else []
    known = {(row["name"], row["seed"]) for row in rows}
    for seed in seed_range(first, last):
        for name in CONDITIONS | SCOOPED:
            if (name, seed) not in known:
                rows.append(measure(name, seed))
                with file.open("a", encoding="utf-8") as opened:
                    opened.write(json.dumps(rows[-1]) + "\n")
    valid = [row for row in rows if row["valid"]]
    print(f"{len(valid)} valid attempts of {len(rows)}")
    lines = []
    for pair in valid[0]["depths"]:
        deepest = max(valid, key=lambda row: float(row["depths"][pair]))
        depth = deepest["depths"][pair]
        lines.append((pair, f"{depth:.2f}", f"{FACTOR * depth:.1f}", f"{deepest['name']}, seed {deepest['seed']}"))
    print(markdown_table(("pair", "deepest [mm]", "limit [mm]", "found in"), lines))


if __name__ == "__main__":
    run_script(main)
