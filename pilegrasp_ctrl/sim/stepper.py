"""The step of the physics, computed again where a contact is suspicious."""

from __future__ import annotations

import mujoco
import numpy as np

DEPTH_JUMP = 3e-4
"""Growth of the deepest penetration in one step above which the step is computed again, more exactly [m]; chosen."""

LEAST_STIFFNESS = 2e4
"""Least stiffness of a contact that counts, per unit of mass [1/s²]; chosen between hard contacts and a hand's rubber,
which is flattened by more than a false depth and stores little of it."""

EXACT_TOLERANCE = 1e-10
"""Tolerance of the collision search in the second computation [m]; chosen. MuJoCo's 1e-6 fails on some of the same
contacts."""

EXACT_ITERATIONS = 200
"""Iterations of the collision search in the second computation [-]; chosen. MuJoCo's 35 fail on some of the same
contacts."""


class Stepper:
    """Advances a simulation step by step, and computes steps with suspicious contacts again.

    MuJoCo's search for several contacts (4.0) reports centimetres of penetration for two cylinders that touch along
    their flanks, about once in ten thousand steps, which would throw them apart. Without the search a flat end rests on
    a single point, and slips and bounces wrongly. Therefore a step is computed again if the deepest penetration jumps.
    The second computation finds one contact for each pair, and is more exact. A real jump is found again.

    Attributes:
        model: MuJoCo model.
        data: State that `step` advances.
        depth: Deepest penetration of the contacts that count in the last step [m]; 0 without cylinders.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self.model, self.data = model, data
        free = model.jnt_bodyid[model.jnt_type == mujoco.mjtJoint.mjJNT_FREE]
        cylinders = model.geom_bodyid[model.geom_type == mujoco.mjtGeom.mjGEOM_CYLINDER]
        self._has_cylinders = bool(np.isin(cylinders, free).any())
        self.depth = 0.0

    def step(self) -> None:
        """Advance by one step."""
        model, data = self.model, self.data
        if not self._has_cylinders:
            mujoco.mj_step(model, data)
            return
        mujoco.mj_step1(model, data)
        depth = self._measure_depth()
        if depth > self.depth + DEPTH_JUMP:
            self._step_exactly()
            depth = self._measure_depth()
        else:
            mujoco.mj_step2(model, data)
        self.depth = depth

    def _step_exactly(self) -> None:
        """Step with one contact a pair and all bodies awake, because new contacts may be with sleeping bodies."""
        option = self.model.opt
        usual = option.disableflags, option.enableflags, option.ccd_tolerance, option.ccd_iterations
        option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_MULTICCD)
        option.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        option.ccd_tolerance, option.ccd_iterations = EXACT_TOLERANCE, EXACT_ITERATIONS
        mujoco.mj_step(self.model, self.data)
        option.disableflags, option.enableflags, option.ccd_tolerance, option.ccd_iterations = usual

    def _measure_depth(self) -> float:
        """Return the deepest penetration [m]."""
        contact = self.data.contact
        if not self.data.ncon:
            return 0.0
        return -float(np.min(contact.dist, where=contact.solref[:, 0] < -LEAST_STIFFNESS, initial=0.0))
