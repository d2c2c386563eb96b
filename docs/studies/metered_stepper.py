"""A stepper that times each step, and makes it once more with an exact solution, from the same state."""

from __future__ import annotations

import time

import mujoco
import numpy as np

from contact_solver import EXACT, ContactSolver
from pilegrasp_ctrl.sim.backend import Stepper
from step_samples import StepSamples

FREE_DOFS = 6


class MeteredStepper(Stepper):
    """Steps as `Stepper` does, with a chosen solver; the exact step is not timed and leaves no trace.

    Args:
        model: which is given the solver.
        data: its state.
        solver: that is measured.
        arm_dofs: number of leading joints that are neither the hand's nor an object's.
        objects: number of objects; their free joints come last.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, solver: ContactSolver, arm_dofs: int, objects: int
    ) -> None:
        super().__init__(model, data)
        self._solver = solver
        self._first_object = model.nv - FREE_DOFS * objects
        self._hand = slice(arm_dofs, self._first_object)
        self._exact = mujoco.MjData(model)
        self._rows: list[tuple[float, ...]] = []
        solver.put_into(model)

    def step(self) -> None:
        """Advance by one step."""
        data, depth = self.data, self.depth
        mujoco.mj_copyData(self._exact, self.model, data)
        start = time.perf_counter()
        super().step()
        seconds = time.perf_counter() - start
        iterations = data.solver_niter[: data.nisland].max(initial=0)
        self._rows.append((data.time, seconds, data.ncon, iterations, *self._errors(depth)))

    def samples(self) -> StepSamples:
        """Return the steps so far."""
        return StepSamples(*np.array(self._rows).T)

    def _errors(self, depth: float) -> tuple[float, float]:
        """Return by how much a joint of the hand [rad/s] and an object [m/s] are off, at most."""
        own, own_depth = self.data, self.depth
        self.data, self.depth = self._exact, depth
        EXACT.put_into(self.model)
        super().step()
        self._solver.put_into(self.model)
        self.data, self.depth = own, own_depth
        error = own.qvel - self._exact.qvel
        objects = error[self._first_object :].reshape(-1, FREE_DOFS)[:, :3]
        finger = np.abs(error[self._hand]).max(initial=0.0)
        return float(finger), float(np.linalg.norm(objects, axis=1).max(initial=0.0))
