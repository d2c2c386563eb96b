"""The simulated robot, and one step of its physics."""

from __future__ import annotations

import mujoco
import numpy as np

from ..types import Array, Observation
from .scene import Scene
from .wrist_sensor import WristSensor

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


class Simulation:
    """MuJoCo behind `reset`, `observe`, `tare`, `apply` and `step`.

    Args:
        scene: the compiled scene.
        sensor: the wrist sensor.
        steps: physics steps in a control period.
    """

    def __init__(self, scene: Scene, sensor: WristSensor, steps: int) -> None:
        self.scene, self._sensor, self._steps = scene, sensor, steps
        self.data = mujoco.MjData(scene.model)
        self._stepper = Stepper(scene.model, self.data)
        self._n = scene.arm_dofs
        # Views: looking an array up in MjData costs more than reading it.
        self._q, self._v = self.data.qpos[: self._n], self.data.qvel[: self._n]
        self._torque, self._closure = self.data.ctrl[: self._n], self.data.ctrl[self._n :]

    def reset(self, q: Array, object_poses: Array) -> None:
        """Put the arm at `q` (nv,) [rad] at rest and the objects at their settled poses (n, 7)."""
        mujoco.mj_resetData(self.scene.model, self.data)
        self.data.qpos[: self._n] = q
        self.data.qpos[self.scene.object_qpos :] = object_poses.ravel()
        mujoco.mj_forward(self.scene.model, self.data)

    def observe(self) -> Observation:
        """Read encoders and wrist sensor; call it once a control period."""
        wrench = self._sensor.read(self.data)
        return Observation(self.data.time, self._q.copy(), self._v.copy(), wrench, self._sensor.saturated)

    def tare(self) -> None:
        """Take the wrist sensor's last reading as its zero; call it while nothing touches the hand."""
        self._sensor.tare(self.data)

    def apply(self, torque: Array, closure: float) -> None:
        """Set the joint torques (nv,) [N·m] and the hand's closure in [0, 1]."""
        self._torque[:] = torque
        self._closure[:] = closure

    def step(self) -> None:
        """Advance by one control period; the command is held."""
        for _ in range(self._steps):
            self._stepper.step()
            self._sensor.sample(self.data)

    def poses(self, bodies: Array) -> tuple[Array, Array]:
        """Return positions (n, 3) [m] and quaternions wxyz (n, 4) of bodies."""
        return self.data.xpos[bodies].copy(), self.data.xquat[bodies].copy()
