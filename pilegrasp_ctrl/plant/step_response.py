"""The answer of a closed loop to a reference that jumps."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from ..arm.model import ArmModel
from ..exceptions import ConfigurationError
from ..trajectories.straight_line import Step
from ..types import Array
from .arm_simulation import ArmSimulation
from .tracking import Controller, simulate_tracking

SETTLING_BAND = 0.02
"""Share of the step within which the error has to stay to count as settled."""

_END = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class StepResponse:
    """What a jump of the reference brought about; n control periods from the jump on.

    Where the reference jumps both in place and in orientation, a metric is that of the worse of the two.

    Attributes:
        time: (n,) since the jump [s].
        error: (n, 6) from the true tool to the reference, world axes, linear part first [m, rad].
        torque: (n, nv) commanded [N·m].
        step: (6,) the jump, displacement then rotation vector [m, rad].
        rise_time: from 10 % to 90 % of the step along its own direction [s]; inf where 90 % is not reached.
        settling_time: until the length of the error stays below 2 % of the step's [s], movement across the step
            included; inf where it does not within the time that was simulated.
        overshoot: largest excess over the step along its direction, as a fraction of it; 0 where there is none.
        steady_state_error: lengths of the mean position and orientation errors over the last tenth of the time
            [m, rad].
        torque_share: largest ratio of a joint's torque to its limit; 1 where a torque limit was reached.
        active_limits: names of the limits that bound at any time. Where there are some, the response is bent: it is
            slower than the gains, and does not scale with the step.
        fallbacks: number of periods in which the controller's program had no solution.
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
    """Let the reference jump from where the tool rests, and measure what follows.

    A step asks for the acceleration `stiffness · step` at once: 18 m/s² for the default gains and 20 mm. Where that
    meets the limits of torque or of joint velocity they bend the response; `active_limits` says so. Halve the step
    until the names are gone to read the gains; keep it to read what the arm does. The duration has to be some times the
    settling time, about `6 / sqrt(stiffness)` seconds at critical damping.

    Args:
        arm: the model that the controller holds.
        controller: an `OperationalSpaceController` or an `ImpedanceController`.
        q: (nv,) where the arm rests [rad].
        displacement: (3,) of the reference, world axes [m].
        rotation: (3,) rotation vector of the reference, world axes [rad].
        duration: [s].
        rate: of the control loop [Hz]; the controller's own.
        simulation: the plant; the arm exactly as its model says, friction included, where absent.

    Raises:
        ModelError: where q does not fit the arm.
        ConfigurationError: where a vector is not three finite numbers, both are zero, or duration or rate is not
            positive.
        SimulationError: where the loop diverges.
    """
    q = np.asarray(q, dtype=np.float64)
    try:
        jump = Step(arm.update(q, np.zeros(arm.nv)).pose, displacement, rotation)
    except (TypeError, ValueError) as error:
        raise ConfigurationError(f"a step takes a displacement and a rotation of three numbers each: {error}") from None
    step = np.concatenate((jump.displacement, jump.rotation))
    if not step.any():
        raise ConfigurationError("a step needs a displacement or a rotation that is not zero")
    simulation = ArmSimulation(arm) if simulation is None else simulation
    motion = simulate_tracking(simulation, controller, jump.at, q, duration, rate)
    parts = [part for part in (slice(0, 3), slice(3, 6)) if step[part].any()]
    metrics = [_metrics(motion.time, motion.error[:, part], step[part], 1.0 / rate) for part in parts]
    rise, settling, overshoot = (max(values) for values in zip(*metrics, strict=True))
    end = motion.error[-max(1, round(_END * len(motion.time))) :].mean(axis=0)
    return StepResponse(
        time=motion.time,
        error=motion.error,
        torque=motion.torque,
        step=step,
        rise_time=rise,
        settling_time=settling,
        overshoot=overshoot,
        steady_state_error=(float(np.linalg.norm(end[:3])), float(np.linalg.norm(end[3:]))),
        torque_share=float((np.abs(motion.torque) / arm.torque_limit).max()),
        active_limits=motion.active_limits(),
        fallbacks=motion.fallbacks,
    )


def _metrics(time: Array, error: Array, step: Array, period: float) -> tuple[float, float, float]:
    """Rise time, settling time and overshoot of one part of the error (n, 3)."""
    covered = 1.0 - error @ step / (step @ step)
    nearly = _crossing(time, covered, 0.9)
    rise = nearly - _crossing(time, covered, 0.1) if nearly < inf else inf
    outside = np.flatnonzero(np.linalg.norm(error, axis=1) > SETTLING_BAND * np.linalg.norm(step))
    last = int(outside[-1]) if outside.size else -1
    settling = inf if last == len(time) - 1 else (last + 1) * period
    return rise, settling, max(0.0, float(covered.max()) - 1.0)


def _crossing(time: Array, values: Array, level: float) -> float:
    """Return when `values` first reach `level`, between samples by interpolation; inf where they never do."""
    above = np.flatnonzero(values >= level)
    if not above.size:
        return inf
    index = int(above[0])
    if index == 0:
        return float(time[0])
    share = (level - values[index - 1]) / (values[index] - values[index - 1])
    return float(time[index - 1] + share * (time[index] - time[index - 1]))
