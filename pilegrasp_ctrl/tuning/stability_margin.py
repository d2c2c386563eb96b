"""The stability margin: the factor by which the stiffness can grow before the closed loop rings."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..arm.model import ArmModel
from ..control.impedance import ImpedanceController
from ..control.operational_space import OperationalSpaceController
from ..exceptions import ConfigurationError, SimulationError
from ..plant.arm_simulation import ArmSimulation
from ..plant.step_response import StepResponse, step_response
from ..plant.tracking import Controller
from ..tasks.gains import Impedance, MotionGains
from ..types import Array, ControllerOutput, Observation, Reference
from .gain_space import scaled

SWING = 0.02
"""Peak-to-peak swing of a torque in the last quarter of the response that counts as ringing, as a share of its limit
(chosen). A loop at rest swings by less than 2e-3; an unstable loop by 2, from one end of its range to the other."""
OVERSHOOT = 0.25
"""Overshoot that counts as ringing, as a share of the step (chosen): a damping ratio below 0.4 if all axes have one
frequency."""
MAX_STEP = (0.005, 0.05)
"""Largest step along each axis [m, rad] (chosen). All axes step at once, so that every mode is excited. The step is
smaller if the gains would answer with more than the following values, so that no limit changes the response."""
MAX_ACCELERATION = (5.0, 25.0)
"""Largest acceleration that answers a step with motion gains [m/s², rad/s²] (chosen)."""
MAX_FORCE = (10.0, 0.5)
"""Largest force that answers a step with an impedance [N, N·m] (chosen)."""
DURATION = 1.0
"""Duration of a response [s] (chosen)."""
MAX_RINGING = 2.0 / SWING
"""Ringing of torques that swing over their whole range, and of a loop that diverges."""
MAX_FACTOR = 16.0
"""Largest factor on the stiffness that is tried (chosen)."""
RESOLUTION = 1.05
"""Ratio of the two factors at which the bisection ends (chosen)."""

Probe = Callable[[float], float]
"""A function from a factor on the stiffness to the ringing; 1 and more rings."""


@dataclass(frozen=True, slots=True)
class Margin:
    """The factor on the stiffness at which ringing begins.

    Attributes:
        factor: Largest factor without ringing; 0 if even the smallest one rings.
        limited: Whether ringing was found at all; if not, `factor` is the largest one that was tried.
        probes: Pairs of factor and ringing that were tried, sorted by factor.
    """

    factor: float
    limited: bool
    probes: tuple[tuple[float, float], ...]

    def __str__(self) -> str:
        """Return the factor in two digits."""
        return f"{self.factor:.2g}" if self.limited else f"at least {self.factor:g}"


def find_margin(probe: Probe, highest: float = MAX_FACTOR, resolution: float = RESOLUTION) -> Margin:
    """Return the factor at which ringing begins, by doubling or halving from 1 and then by bisection on a log scale.

    Args:
        probe: Ringing at a factor; it is assumed to begin at one factor and to stay above it.
        highest: Largest factor that is tried; its inverse is the smallest.
        resolution: Ratio of the two factors around the border, above 1.

    Raises:
        ConfigurationError: `highest` or `resolution` is not above 1.
    """
    if not (highest > 1.0 and resolution > 1.0):
        raise ConfigurationError(f"highest = {highest} and resolution = {resolution} must both be above 1")
    probes: dict[float, float] = {}

    def rings(factor: float) -> bool:
        probes[factor] = probe(factor)
        return probes[factor] >= 1.0

    quiet, loud = 1.0, 1.0
    if rings(1.0):
        while True:
            quiet = max(loud / 2.0, 1.0 / highest)
            if not rings(quiet):
                break
            loud = quiet
            if loud <= 1.0 / highest:
                return Margin(0.0, True, tuple(sorted(probes.items())))
    else:
        while True:
            loud = min(quiet * 2.0, highest)
            if rings(loud):
                break
            quiet = loud
            if quiet >= highest:
                return Margin(quiet, False, tuple(sorted(probes.items())))
    while loud / quiet > resolution:
        middle = float(np.sqrt(quiet * loud))
        if rings(middle):
            loud = middle
        else:
            quiet = middle
    return Margin(quiet, True, tuple(sorted(probes.items())))


def ringing(response: StepResponse, torque_limit: Array) -> float:
    """Return how much a response rings; 1 and more rings.

    It is the larger of two ratios: the swing of the torques in the last quarter over `SWING`, and the overshoot over
    `OVERSHOOT`. The swing counts even if the tool does not move.

    Args:
        response: Step response of the loop.
        torque_limit: Torque limits (nv,) [N·m].
    """
    tail = response.torque[-(len(response.time) // 4) :] / torque_limit
    return max(float(np.ptp(tail, axis=0).max()) / SWING, response.overshoot / OVERSHOOT)


def make_controller(
    arm: ArmModel, gains: MotionGains | Impedance, q: Array, rate: float, solver: str, friction: bool = True
) -> Controller:
    """Return the controller of these gains for free motion, without feedback of a measured force.

    Args:
        arm: Arm with its tool.
        gains: Gains of the tool.
        q: Posture (nv,) [rad].
        rate: Control rate [Hz].
        solver: Solver of the quadratic program.
        friction: Whether the controller compensates joint friction.

    Raises:
        ConfigurationError: The control rate is too low for the gains.
    """
    if isinstance(gains, MotionGains):
        return OperationalSpaceController(arm, gains, q, solver=solver, rate=rate, friction=friction)
    free = replace(gains, force_gain=0.0)
    return ImpedanceController(arm, free, q, solver=solver, rate=rate, friction=friction)


def stiffness_probe(
    arm: ArmModel, gains: MotionGains | Impedance, q: Array, *, rate: float, solver: str = "daqp", late: int = 0
) -> Probe:
    """Return the ringing of a step response as a function of a factor on the stiffness, at the same damping ratio.

    Joint friction is left out of the plant and of the controller. It damps a loop, but changes with temperature and
    wear, so a margin must not depend on it.

    Args:
        arm: Arm with its tool.
        gains: Gains at factor 1.
        q: Posture at rest (nv,) [rad].
        rate: Control rate [Hz].
        solver: Solver of the quadratic program.
        late: Control periods by which the torque is late, beside the one for which it is held.
    """
    plant = ArmSimulation(arm, friction_coulomb=0.0, friction_viscous=0.0)

    def probe(factor: float) -> float:
        stiffer = scaled(gains, factor)
        step = _step(stiffer)
        try:
            controller = make_controller(arm, stiffer, q, rate, solver, friction=False)
            if late:
                controller = LateController(controller, late)
            response = step_response(
                arm,
                controller,
                q,
                displacement=step[:3],
                rotation=step[3:],
                duration=DURATION,
                rate=rate,
                simulation=plant,
            )
        # An impedance whose sampled loop would diverge is refused before it moves.
        except (SimulationError, ConfigurationError):
            return MAX_RINGING
        return min(ringing(response, arm.torque_limit), MAX_RINGING)

    return probe


def _step(gains: MotionGains | Impedance) -> Array:
    most = MAX_ACCELERATION if isinstance(gains, MotionGains) else MAX_FORCE
    stiffness = np.maximum(gains.stiffness, 1e-9)
    return np.minimum(np.repeat(MAX_STEP, 3), np.repeat(most, 3) / stiffness)


class LateController:
    """A controller whose torques arrive some control periods late, as over a bus or after a slow sensor.

    Until the first late torque arrives, it repeats the first answer. It stores answers, so use one instance for each
    run.
    """

    def __init__(self, controller: Controller, periods: int) -> None:
        """Take a controller and the number of control periods by which it is late."""
        self._controller = controller
        self._waiting: deque[ControllerOutput] = deque(maxlen=periods + 1)

    def step(self, observation: Observation, reference: Reference, /) -> ControllerOutput:
        """Return the torques for one control period."""
        self._waiting.append(self._controller.step(observation, reference))
        return self._waiting[0]
