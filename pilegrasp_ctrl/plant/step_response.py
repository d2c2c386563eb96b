"""The response of a closed loop to a step of the reference."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from ..arm.model import ArmModel
from ..exceptions import ConfigurationError
from ..trajectories.straight_line import Step
from ..types import Array
from ..vectors import components, inner, norm
from .arm_simulation import ArmSimulation
from .tracking import Controller, simulate_tracking

SETTLING_BAND = 0.02
"""Share of the step within which the error must stay to count as settled [-]; the usual 2 %."""

STEADY_SHARE = 0.1
"""Share of the simulated time, at its end, over which the steady-state error is averaged [-]; chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class StepResponse:
    """The response to a step over n control periods, from the step on.

    If the reference steps both in position and in orientation, each metric is the worse of the two.

    Attributes:
        time: (n,) Time since the step [s].
        error: (n, 6) Error from the true tool to the reference, world axes, linear part first [m, rad].
        torque: (n, nv) Commanded torques [N·m].
        step: (6,) Step, displacement then rotation vector [m, rad].
        rise_time: Time from 10 % to 90 % of the step along its direction [s]; inf if 90 % is not reached.
        settling_time: Time until the length of the error stays below 2 % of the step's [s]; inf if it never does.
            Motion across the step counts.
        overshoot: Largest excess over the step along its direction, as a fraction of it; 0 if there is none.
        steady_state_error: Lengths of the mean position and orientation errors over the last tenth of the time
            [m, rad].
        torque_share: Largest ratio of a joint's torque to its limit; 1 if a torque limit was reached.
        active_limits: Names of the limits that were active at any time. If there are any, the response is slower than
            the gains and does not scale with the step.
        fallbacks: Number of periods in which the controller's program had no solution.
    """

    time: Array
    error: Array
    torque: Array
    step: Array
    rise_time: float
    settling_time: float
    overshoot: float
    steady_state_error: tuple[float, float]
    torque_share: float
    active_limits: tuple[str, ...]
    fallbacks: int

    def __repr__(self) -> str:
        return (
            f"StepResponse(rise_time={self.rise_time:.3g} s, settling_time={self.settling_time:.3g} s, "
            f"overshoot={self.overshoot:.1%}, active_limits={self.active_limits})"
        )


def step_response(
    arm: ArmModel,
    controller: Controller,
    q: ArrayLike,
    *,
    displacement: ArrayLike = (0.0, 0.0, 0.02),
    rotation: ArrayLike = (0.0, 0.0, 0.0),
    duration: float = 1.0,
    rate: float = 500.0,
    simulation: ArmSimulation | None = None,
) -> StepResponse:
    """Step the reference away from the resting tool, and measure the response.

    A step asks for the acceleration `stiffness · step` at once: 18 m/s² for the default gains and 20 mm. Limits of
    torque or joint velocity may then change the response, and `active_limits` names them. To measure the gains, halve
    the step until no limit is named. The duration must be several times the settling time, which is about
    `6 / sqrt(stiffness)` seconds at critical damping.

    Args:
        arm: Model that the controller uses.
        controller: An `OperationalSpaceController` or an `ImpedanceController`.
        q: (nv,) Joint positions of the resting arm [rad].
        displacement: (3,) Displacement of the reference, world axes [m].
        rotation: (3,) Rotation vector of the reference, world axes [rad].
        duration: Simulated time [s].
        rate: Control rate [Hz]; it must be the controller's.
        simulation: Plant; by default the arm exactly as its model says, with friction.

    Raises:
        ModelError: q does not fit the arm.
        ConfigurationError: A vector is not three finite numbers, both are zero, or duration or rate is not positive.
        SimulationError: The loop diverges.
    """
    q = np.asarray(q, dtype=np.float64)
    start = arm.update(q, np.zeros(arm.nv)).pose
    try:
        jump = Step(start, displacement, rotation)
    except (TypeError, ValueError) as error:
        raise ConfigurationError(f"a step takes a displacement and a rotation of three numbers each: {error}") from None
    step = np.concatenate((jump.displacement, jump.rotation))
    if not step.any():
        raise ConfigurationError("a step needs a displacement or a rotation that is not zero")
    simulation = ArmSimulation(arm) if simulation is None else simulation
    motion = simulate_tracking(simulation, controller, jump.at, q, duration, rate)
    parts = [part for part in (slice(0, 3), slice(3, 6)) if step[part].any()]
    metrics = [_measure(motion.time, motion.error[:, part], step[part], 1.0 / rate) for part in parts]
    rise, settling, overshoot = (max(values) for values in zip(*metrics, strict=True))
    end = motion.error[-max(1, round(STEADY_SHARE * len(motion.time))) :].mean(axis=0)
    return StepResponse(
        time=motion.time,
        error=motion.error,
        torque=motion.torque,
        step=step,
        rise_time=rise,
        settling_time=settling,
        overshoot=overshoot,
        steady_state_error=(norm(end[:3]), norm(end[3:])),
        torque_share=float((np.abs(motion.torque) / arm.torque_limit).max()),
        active_limits=motion.active_limits(),
        fallbacks=motion.fallbacks,
    )


def _measure(time: Array, error: Array, step: Array, period: float) -> tuple[float, float, float]:
    """Return rise time [s], settling time [s] and overshoot [-] of one part of the error (n, 3)."""
    covered = 1.0 - components(error, step) / inner(step, step)
    nearly = _crossing(time, covered, 0.9)
    rise = nearly - _crossing(time, covered, 0.1) if nearly < inf else inf
    outside = np.flatnonzero(np.linalg.norm(error, axis=1) > SETTLING_BAND * norm(step))
    last = int(outside[-1]) if outside.size else -1
    settling = inf if last == len(time) - 1 else (last + 1) * period
    return rise, settling, max(0.0, float(covered.max()) - 1.0)


def _crossing(time: Array, values: Array, level: float) -> float:
    """Return the interpolated time at which `values` first reach `level` [s]; inf if they never do."""
    above = np.flatnonzero(values >= level)
    if not above.size:
        return inf
    index = int(above[0])
    if index == 0:
        return float(time[0])
    share = (level - values[index - 1]) / (values[index] - values[index - 1])
    return float(time[index - 1] + share * (time[index] - time[index - 1]))
