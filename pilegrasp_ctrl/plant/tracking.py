"""A controller follows a reference on a simulated arm; what was to follow is compared with what the tool truly did."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..tasks.frame_task import pose_error
from ..types import Array, ControllerOutput, Observation, Reference
from .arm_simulation import ArmSimulation


class Controller(Protocol):
    """Torques from an observation and a reference, such as `OperationalSpaceController` and `ImpedanceController`."""

    def step(self, observation: Observation, reference: Reference, /) -> ControllerOutput:
        """Return the torques for one control period."""


class Motion(NamedTuple):
    """How a reference was followed; n control periods.

    Attributes:
        time: (n,) [s].
        error: (n, 6) from the true tool to its reference, world axes, linear part first [m, rad].
        torque: (n, nv) commanded [N·m].
        limits: (n,) the names of the limits that bound in each period.
        fallbacks: number of periods in which the controller's program had no solution.
    """

    time: Array
    error: Array
    torque: Array
    limits: tuple[tuple[str, ...], ...]
    fallbacks: int

    def active_limits(self, start: float = 0.0) -> tuple[str, ...]:
        """Return the names of the limits that bound at `start` [s] or later, sorted.

        Where there are some, the error is theirs as well as the gains'.
        """
        late = (names for time, names in zip(self.time, self.limits, strict=True) if time >= start)
        return tuple(sorted(set().union(*late)))


def simulate_tracking(
    simulation: ArmSimulation,
    controller: Controller,
    reference: Callable[[float], Reference],
    q: ArrayLike,
    duration: float,
    rate: float = 500.0,
) -> Motion:
    """Run the closed loop from rest.

    Args:
        simulation: the plant.
        controller: asked once a period.
        reference: where the tool should be at a time [s], for example `StraightLine(...).at`.
        q: (nv,) joint positions at time 0 [rad].
        duration: [s].
        rate: of the control loop [Hz]; the controller's own.

    Raises:
        ConfigurationError: where q does not fit the arm, or duration or rate is not positive.
        SimulationError: where the loop diverges.
    """
    limits: list[tuple[str, ...]] = []
    fallbacks = 0

    def torque(observation: Observation) -> Array:
        nonlocal fallbacks
        output = controller.step(observation, reference(observation.time))
        limits.append(output.active_limits)
        fallbacks += bool(output.fallback)
        return output.command.torque

    plant = simulation.plant
    times, errors, torques = [], [], []
    for sample in simulation.run(torque, q, duration, rate=rate):
        times.append(sample.time)
        errors.append(pose_error(plant.update(sample.q, sample.v), reference(sample.time)))
        torques.append(sample.torque)
    return Motion(np.array(times), np.array(errors), np.array(torques), tuple(limits), fallbacks)
