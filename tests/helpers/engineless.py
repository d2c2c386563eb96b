"""Backends without an engine, on which whole attempts run: an arm before a table and a wall, objects, and a view."""

from collections.abc import Callable

import numpy as np

from pilegrasp_ctrl.plant.arm_backend import ArmBackend
from pilegrasp_ctrl.plant.arm_simulation import ArmSimulation
from pilegrasp_ctrl.programs.attempt import Attempt
from pilegrasp_ctrl.recording_parts import Body, Shape
from pilegrasp_ctrl.types import Array, Observation
from spring_wall import SpringWall

TABLE = SpringWall([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], stiffness=2000.0, damping=20.0)
WALL = SpringWall([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], stiffness=1000.0, damping=20.0)


def surroundings(*walls: SpringWall) -> Callable:
    """Return an environment that is the sum of several walls."""
    return lambda pose, twist: sum((wall(pose, twist) for wall in walls), np.zeros(6))


def arm_of(attempt: Attempt, *walls: SpringWall, kind: type[ArmBackend] = ArmBackend, **plant) -> ArmBackend:
    """Return the arm of an attempt at its start, before `walls`; `plant` are arguments of `ArmSimulation`."""
    simulation = ArmSimulation(attempt.arm, environment=surroundings(*walls), **plant)
    return kind(simulation, attempt.posture, np.zeros(attempt.arm.nv), 1.0 / attempt.period)


class LoggedArm(ArmBackend):
    """An arm that notes in `calls` which of its methods are called."""

    def __init__(self, *start) -> None:
        super().__init__(*start)
        self.calls: list[str] = []


for _name in ("observe", "tare", "apply", "step", "find_collision", "object_poses"):

    def _logged(self: LoggedArm, *inputs, _name: str = _name):
        self.calls.append(_name)
        return getattr(ArmBackend, _name)(self, *inputs)

    setattr(LoggedArm, _name, _logged)


class CarryingArm(ArmBackend):
    """An arm whose hand takes one object when it closes, and drops it where it opens.

    `poses` (n, 7) are the poses of the objects at the start; the hand takes the first.
    """

    poses: Array
    taken = False

    def apply(self, torque: Array, closure: float = 0.0) -> None:
        super().apply(torque, closure)
        self.taken = closure == 1.0 or (self.taken and closure > 0.0)

    def observe(self) -> Observation:
        observation = super().observe()
        tool = self._simulation.plant.update(self.q, self.v).pose.translation
        if self.taken:
            self.poses[0, :3] = tool
        elif self.poses[0, 2] > 0.1:
            self.poses[0, 2] = 0.03
        return observation

    def object_poses(self) -> Array:
        return self.poses.copy()


class ToolView:
    """A scene that shows the tool as a ball, and what touches it as the force of the ground."""

    bodies = (
        Body("ground", "support", (Shape("plane", [1.0, 1.0]),)),
        Body("tool", "hand", (Shape("sphere", [0.02]),)),
    )

    def __init__(self, arm: ArmBackend, simulation: ArmSimulation) -> None:
        self._arm, self._simulation = arm, simulation

    def poses(self) -> tuple[Array, Array]:
        tool = self._simulation.plant.update(self._arm.q, self._arm.v).pose.translation
        return np.array([np.zeros(3), tool]), np.array([[1.0, 0.0, 0.0, 0.0]] * 2)

    def contacts(self):
        force = self._simulation.wrench(self._arm.q, self._arm.v)[:3]
        count = int(force.any())
        return np.array([[1, 0]] * count).reshape(-1, 2), self.poses()[0][1:][:count], force[None][:count]


class DrawnArm(ArmBackend):
    """An arm that is drawn as its tool."""

    @property
    def view(self) -> ToolView:
        return ToolView(self, self._simulation)
