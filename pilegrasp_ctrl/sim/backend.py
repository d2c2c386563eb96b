"""The simulated robot and the step of its physics, behind five methods that a real robot could offer as well."""

from __future__ import annotations

import mujoco
import numpy as np

from ..types import Array, Observation
from .scene import Scene
from .wrist_sensor import WristSensor

DEPTH_JUMP = 3e-4
"""Growth of the deepest penetration in one step above which the step is computed again, more exactly [m]; chosen."""

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
        depth: Deepest penetration in the last step [m]; 0 without cylinders.
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
        return max(0.0, -float(self.data.contact.dist.min())) if self.data.ncon else 0.0


class Simulation:
    """MuJoCo behind `reset`, `observe`, `tare`, `apply` and `step`.

    Attributes:
        scene: Compiled scene.
        data: MuJoCo's state.
        stepper: Stepper of the physics; a study may replace it by a subclass of `Stepper` on the same `data`.
    """

    def __init__(self, scene: Scene, sensor: WristSensor, steps: int) -> None:
        """Put a robot and its sensor into a scene.

        Args:
            scene: Compiled scene.
            sensor: Wrist sensor.
            steps: Physics steps in a control period.
        """
        self.scene, self._sensor, self._steps = scene, sensor, steps
        self.data = mujoco.MjData(scene.model)
        self.stepper = Stepper(scene.model, self.data)
        self._n = scene.arm_dofs
        # Views, because the lookup of an array in MjData costs more than its reading.
        self._q, self._v = self.data.qpos[: self._n], self.data.qvel[: self._n]
        self._torque, self._closure = self.data.ctrl[: self._n], self.data.ctrl[self._n :]

    def reset(self, q: Array, object_poses: Array) -> None:
        """Set the arm to `q` (nv,) [rad] and the objects to their settled poses (n, 7), all at rest."""
        mujoco.mj_resetData(self.scene.model, self.data)
        self.data.qpos[: self._n] = q
        self.data.qpos[self.scene.object_qpos :] = object_poses.ravel()
        mujoco.mj_forward(self.scene.model, self.data)

    def observe(self) -> Observation:
        """Read encoders and wrist sensor; call it once a control period."""
        wrench = self._sensor.read(self.data)
        return Observation(self.data.time, self._q.copy(), self._v.copy(), wrench, self._sensor.saturated or "")

    def tare(self) -> None:
        """Take the wrist sensor's last reading as its zero; call it while nothing touches the hand."""
        self._sensor.tare(self.data)

    def apply(self, torque: Array, closure: float) -> None:
        """Set the joint torques (nv,) [N·m] and the hand's closure in [0, 1]."""
        self._torque[:] = torque
        self._closure[:] = closure

    def step(self) -> None:
        """Advance by one control period with a constant command."""
        for _ in range(self._steps):
            self.stepper.step()
            self._sensor.sample(self.data)

    def poses(self, bodies: Array) -> tuple[Array, Array]:
        """Return positions (n, 3) [m] and quaternions wxyz (n, 4) of bodies."""
        return self.data.xpos[bodies].copy(), self.data.xquat[bodies].copy()
