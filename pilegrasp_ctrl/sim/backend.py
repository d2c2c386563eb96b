"""The simulated robot: five methods, which a real one could offer as well."""

from __future__ import annotations

import mujoco

from ..types import Array, Observation
from .scene import Scene
from .stepper import Stepper
from .wrist_sensor import WristSensor


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
