"""How much stiffer the gains could be before the closed loop rings."""

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
"""A torque that swings by more than this share of its limit, peak to peak, in the last quarter of the response rings. A
loop that has come to rest swings by less than 2e-3, one past its limit by 2, from one end of its range to the other."""
OVERSHOOT = 0.25
"""More than this share of the step beyond it rings too: a damping ratio below 0.4 where all axes have one frequency."""
LARGEST_STEP = (0.005, 0.05)
"""The step along every axis at once, so that no mode is left out [m, rad]; smaller where the gains would answer it with
more than the following, so that limits bend no response."""
LARGEST_ACCELERATION = (5.0, 25.0)
"""[m/s², rad/s²] for the gains of a motion."""
LARGEST_FORCE = (10.0, 0.5)
"""[N, N·m] for an impedance."""
DURATION = 1.0
MOST = 2.0 / SWING
"""Ringing where the torques swing over their whole range, or the loop diverges."""
HIGHEST = 16.0
"""Factors beyond this are not tried."""
RESOLUTION = 1.05
"""Ratio of the two factors between which the bisection ends."""

Probe = Callable[[float], float]
"""From a factor on the stiffness to the ringing at it; 1 and more is ringing."""


@dataclass(frozen=True, slots=True)
class Margin:
    """Where on the scale of stiffness the ringing begins.

    Attributes:
        factor: largest factor found without ringing; 0 where even the smallest one rings.
        limited: whether ringing was found at all; where it was not, `factor` is the largest one tried.
        probes: what was tried, by factor: pairs of factor and ringing.
    """

    factor: float
    limited: bool
    probes: tuple[tuple[float, float], ...]

    def __str__(self) -> str:
        """Return the factor as a person would write it."""
        return f"{self.factor:.2g}" if self.limited else f"at least {self.factor:g}"


def find_margin(probe: Probe, highest: float = HIGHEST, resolution: float = RESOLUTION) -> Margin:
    """Return the factor at which ringing begins, by doubling or halving from 1 and then by bisection on a log scale.

    Args:
        probe: the ringing at a factor; it is taken to begin once and to stay.
        highest: largest factor tried; its inverse is the smallest.
        resolution: ratio of the factors around the border, above 1.

    Raises:
        ConfigurationError: where `highest` or `resolution` is not above 1.
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
    """Return how much a response rings; 1 and more is ringing.

    The larger of two: the swing of the torques in the last quarter over `SWING`, which does not ask whether the tool
    moves with them; and the overshoot over `OVERSHOOT`.

    Args:
        response: of the loop.
        torque_limit: (nv,) [N·m].
    """
    tail = response.torque[-(len(response.time) // 4) :] / torque_limit
    return max(float(np.ptp(tail, axis=0).max()) / SWING, response.overshoot / OVERSHOOT)


def make_controller(
    arm: ArmModel, gains: MotionGains | Impedance, q: Array, rate: float, solver: str, friction: bool = True
) -> Controller:
    """Return the controller that these gains are for in free motion, with `q` (nv,) as its posture [rad].

    Feedback of a measured force plays no part there.

    Args:
        arm: the arm with its tool.
        gains: of the tool.
        q: (nv,) [rad].
        rate: of the control [Hz].
        solver: of the quadratic program.
        friction: whether it feeds the joint friction forward.

    Raises:
        ConfigurationError: where the gains could not be held.
    """
    if isinstance(gains, MotionGains):
        return OperationalSpaceController(arm, gains, q, solver=solver, rate=rate, friction=friction)
    free = replace(gains, force_gain=0.0)
    return ImpedanceController(arm, free, q, solver=solver, rate=rate, friction=friction)


def stiffness_probe(
    arm: ArmModel, gains: MotionGains | Impedance, q: Array, *, rate: float, solver: str = "daqp", late: int = 0
) -> Probe:
    """Return the ringing of a step response as a function of a factor on the stiffness, at the same damping ratio.

    Joint friction is left out of the plant and of the feed-forward: it steadies a loop, and changes with temperature
    and wear, so that no margin may count on it.

    Args:
        arm: the arm with its tool.
        gains: at factor 1.
        q: (nv,) where it rests [rad].
        rate: of the control [Hz].
        solver: of the quadratic program.
        late: control periods by which the torque comes late, beside the one for which it is held.
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
            return MOST
        return min(ringing(response, arm.torque_limit), MOST)

    return probe


def _step(gains: MotionGains | Impedance) -> Array:
    most = LARGEST_ACCELERATION if isinstance(gains, MotionGains) else LARGEST_FORCE
    stiffness = np.maximum(gains.stiffness, 1e-9)
    return np.minimum(np.repeat(LARGEST_STEP, 3), np.repeat(most, 3) / stiffness)


class LateController:
    """Gives the answer to the observation of some control periods ago; until there is one, the first.

    It remembers answers, so that one instance serves one run.
    """

    def __init__(self, controller: Controller, periods: int) -> None:
        """Take a controller and by how many periods it is late."""
        self._controller = controller
        self._waiting: deque[ControllerOutput] = deque(maxlen=periods + 1)

    def step(self, observation: Observation, reference: Reference, /) -> ControllerOutput:
        """Return the torques for one control period."""
        self._waiting.append(self._controller.step(observation, reference))
        return self._waiting[0]
