"""Tracking: a controller moves a simulated arm along a reference, from which the true motion deviates."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..tasks.pose_task import pose_error
from ..types import Array, ControllerOutput, Observation, Reference
from .arm_simulation import ArmSimulation


class Controller(Protocol):
    """A controller such as `OperationalSpaceController` or `ImpedanceController`."""

    def step(self, observation: Observation, reference: Reference, /) -> ControllerOutput:
        """Return the torques for one control period."""


class Motion(NamedTuple):
    """The tracked motion over n control periods.

    Attributes:
        time: (n,) Times [s].
        error: (n, 6) Error from the true tool to its reference, world axes, linear part first [m, rad].
        torque: (n, nv) Commanded torques [N·m].
        limits: (n,) Names of the limits that were active in each period.
        fallbacks: Number of periods in which the controller's program had no solution.
    """

    time: Array
    error: Array
    torque: Array
    limits: tuple[tuple[str, ...], ...]
    fallbacks: int

    def active_limits(self, start: float = 0.0) -> tuple[str, ...]:
        """Return the names of the limits that were active at `start` [s] or later, sorted.

        If there are any, the error comes from them as well as from the gains.
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
    """Run the closed loop from rest, and return the motion.

    Args:
        simulation: Plant.
        controller: Controller, called once per period.
        reference: Function from a time [s] to the tool's reference, for example `StraightLine(...).at`.
        q: (nv,) Joint positions at time 0 [rad].
        duration: Simulated time [s].
        rate: Control rate [Hz]; it must be the controller's.

    Raises:
        ConfigurationError: q does not fit the arm, or duration or rate is not positive.
        SimulationError: The loop diverges.
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
