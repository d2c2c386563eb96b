"""One step of the physics, with a second look at contacts that come out of nowhere."""

from __future__ import annotations

import mujoco
import numpy as np

JUMP = 3e-4
"""A contact that is deeper than all of the step before by more than this [m] is looked at again."""
TOLERANCE, ITERATIONS = 1e-10, 200
"""Of the second look; at MuJoCo's 1e-6 [m] and 35 it falls for some of the same contacts."""


class Stepper:
    """Advances a simulation step by step.

    MuJoCo's search for several contacts (4.0) reports two cylinders that touch along their flanks as centimetres deep,
    once in some ten thousand steps, and would throw them apart. Without it a flat end stands on a single point, and
    slips and bounces as it should not. So a step in which a contact has become deeper by a jump is looked at again, one
    contact at a time and more exactly; where the jump was real, nothing is lost by it.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data
        free = model.jnt_bodyid[model.jnt_type == mujoco.mjtJoint.mjJNT_FREE]
        cylinders = model.geom_bodyid[model.geom_type == mujoco.mjtGeom.mjGEOM_CYLINDER]
        self._wary = bool(np.isin(cylinders, free).any())
        self._deepest = 0.0

    def step(self) -> None:
        """Advance by one step."""
        model, data = self._model, self._data
        if not self._wary:
            mujoco.mj_step(model, data)
            return
        mujoco.mj_step1(model, data)
        deepest = self._depth()
        if deepest > self._deepest + JUMP:
            self._look_again()
            deepest = self._depth()
        else:
            mujoco.mj_step2(model, data)
        self._deepest = deepest

    def _look_again(self) -> None:
        """Make the step with one contact at a time, everything awake: other contacts may touch what sleeps."""
        option = self._model.opt
        usual = option.disableflags, option.enableflags, option.ccd_tolerance, option.ccd_iterations
        option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_MULTICCD)
        option.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        option.ccd_tolerance, option.ccd_iterations = TOLERANCE, ITERATIONS
        mujoco.mj_step(self._model, self._data)
        option.disableflags, option.enableflags, option.ccd_tolerance, option.ccd_iterations = usual

    def _depth(self) -> float:
        return max(0.0, -float(self._data.contact.dist.min())) if self._data.ncon else 0.0
