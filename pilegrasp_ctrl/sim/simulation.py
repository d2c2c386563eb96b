"""The backend of an attempt in MuJoCo: arm, hand, objects and wrist sensor."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import mujoco

from ..planning.walls import Wall
from ..types import Array, Observation
from .monitors import RimCheck, Watchdog
from .readout import SceneReadout
from .scene import Scene
from .stepper import Stepper
from .touch_sensor import TouchSensor
from .wrist_sensor import WristSensor


class Simulation:
    """The `Backend` in MuJoCo; what is not described here is described there.

    Attributes:
        scene: Compiled scene.
        data: MuJoCo's state.
        stepper: Stepper of the physics; a study may replace it by a subclass of `Stepper` on the same `data`.
    """

    def __init__(
        self,
        scene: Scene,
        sensor: WristSensor,
        steps: int,
        walls: Sequence[Wall] = (),
        label: str = "attempt",
        touch: TouchSensor | None = None,
    ) -> None:
        """Put a robot and its sensor into a scene.

        Args:
            scene: Compiled scene.
            sensor: Wrist sensor.
            steps: Physics steps in a control period.
            walls: Walls of the scene; the rims of those that belong to a crate are watched.
            label: Part of the name of the file with the last states of a simulation that had to stop.
            touch: Touch of the fingers; None for a hand without.
        """
        self.scene, self._sensor, self._steps, self._touch = scene, sensor, steps, touch
        self._walls, self._label = walls, label
        self.data = mujoco.MjData(scene.model)
        self.stepper = Stepper(scene.model, self.data)
        n = scene.arm_dofs
        # Views, because the lookup of an array in MjData costs more than its reading.
        self._q, self._v = self.data.qpos[:n], self.data.qvel[:n]
        self._torque, self._closure = self.data.ctrl[:n], self.data.ctrl[n:]
        self._objects = self.data.qpos[scene.object_qpos :]
        self._period, self._level = steps * scene.model.opt.timestep, 0.0
        self._watch()

    def _watch(self) -> None:
        """Begin to watch the state and the rims anew."""
        self._watchdog = Watchdog(self._label)
        self._rims = RimCheck(self.scene, self._walls)

    def reset(self, q: Array, object_poses: Array) -> None:
        """Set the arm to `q` (nv,) [rad] and the objects to their settled poses (n, 7), all at rest."""
        mujoco.mj_resetData(self.scene.model, self.data)
        self._q[:] = q
        self._objects[:] = object_poses.ravel()
        self._level = 0.0
        mujoco.mj_forward(self.scene.model, self.data)
        self._watch()

    def set_time(self, time: float) -> None:
        """Set the clock [s], so that it goes on where that of another simulation ended."""
        self.data.time = time
        self._watch()

    def observe(self) -> Observation:
        """Read encoders and wrist sensor."""
        wrench = self._sensor.read(self.data)
        touch = self._touch.count(self.data) if self._touch else (0, 0)
        saturated = self._sensor.saturated or ""
        return Observation(self.data.time, self._q.copy(), self._v.copy(), wrench, saturated, *touch)

    def tare(self) -> None:
        """Take the wrist sensor's last reading as its zero."""
        self._sensor.tare(self.data)

    def apply(self, torque: Array, closure: float) -> None:
        """Set the torques of the joints, and move the hand's drive toward the closure for a control period."""
        drive = self.scene.drive
        self._torque[:] = torque
        self._level = drive.next_closure(self._level, closure, self._period)
        self._closure[:] = drive.command(self._level)

    def step(self) -> None:
        """Advance by one control period with a constant command, and look at the new state.

        Raises:
            SimulationError: The state is not finite, or two bodies overlap too far; see `Watchdog`.
        """
        for _ in range(self._steps):
            self.stepper.step()
            self._sensor.sample(self.data)
        self._watchdog.check(self.data)

    def find_collision(self) -> str | None:
        """Look for a collision of the robot with the rim of a crate; see `RimCheck`."""
        return self._rims.find_collision(self.data)

    def object_poses(self) -> Array:
        """Return the poses (n, 7) of the objects."""
        return self._objects.reshape(-1, 7).copy()

    @cached_property
    def view(self) -> SceneReadout:
        """The drawn bodies and their contacts; made on first use, because most attempts are not recorded."""
        return SceneReadout(self.scene, self.data)
