"""MuJoCo's contact solver as a choice that a model can be given after it is compiled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import mujoco

from pilegrasp_ctrl.sim.scene import SOLVER_ITERATIONS


@dataclass(frozen=True, slots=True)
class ContactSolver:
    """Its kind, most iterations, and the tolerance [-] at which it stops, as MuJoCo's `opt.tolerance` says."""

    kind: Literal["CG", "Newton"] = "CG"
    iterations: int = SOLVER_ITERATIONS
    tolerance: float = 1e-8

    @property
    def label(self) -> str:
        """Words for a table."""
        return f"{self.kind}, {self.iterations}"

    def put_into(self, model: Any) -> None:
        """Let the model be solved by this from its next step on."""
        kind = mujoco.mjtSolver.mjSOL_CG if self.kind == "CG" else mujoco.mjtSolver.mjSOL_NEWTON
        model.opt.solver, model.opt.iterations, model.opt.tolerance = kind, self.iterations, self.tolerance


EXACT = ContactSolver("CG", 1000, 1e-14)
"""What the others are judged by: CG does not stall, and 100 iterations or so take it to where it no longer improves."""
