"""How far the tool follows a reference that swings, and how late: the closed loop as a control engineer plots it."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..arm.model import ArmModel
from ..exceptions import ConfigurationError
from ..types import Array, Pose, Reference
from .arm_simulation import ArmSimulation
from .tracking import Controller, simulate_tracking

FREQUENCIES = tuple(np.geomspace(0.5, 20.0, 17).tolist())
"""[Hz]; from well below to well above the default gains' natural frequencies of 4.8 and 6.4 Hz."""

_HALF_POWER = 10.0 ** (-3.0 / 20.0)
_SAMPLES_PER_PERIOD = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class FrequencyResponse:
    """From the reference's motion along one axis to the tool's, at n frequencies.

    Attributes:
        frequency: (n,) rising [Hz].
        gain: (n,) amplitude of the tool's motion over that of the reference.
        phase: (n,) by which the tool leads the reference, continuous over the frequency; negative where it lags [rad].
        distortion: (n,) rms of the motion along the axis that is not at the reference's frequency, over the rms of
            what is. A linear loop has none; friction and limits have, and then gain and phase hold for this amplitude
            only.
        amplitude: of the reference [m or rad].
        active_limits: names of the limits that bound at any frequency, after the transient.
        fallbacks: number of periods in which the controller's program had no solution.
    """

    frequency: Array
    gain: Array
    phase: Array
    distortion: Array
    amplitude: float
    active_limits: tuple[str, ...]
    fallbacks: int

    @property
    def bandwidth(self) -> float:
        """Where the gain first falls 3 dB below 1 [Hz], interpolated in log frequency and decibel.

        inf where it stays above at all frequencies, 0 where it is below at the lowest already.
        """
        below = np.flatnonzero(self.gain < _HALF_POWER)
        if not below.size:
            return inf
        index = int(below[0])
        if index == 0:
            return 0.0
        level, frequency = np.log(self.gain[index - 1 : index + 1]), np.log(self.frequency[index - 1 : index + 1])
        share = (level[0] - np.log(_HALF_POWER)) / (level[0] - level[1])
        return float(np.exp(frequency[0] + share * (frequency[1] - frequency[0])))

    @property
    def resonance_peak(self) -> float:
        """The largest gain among the frequencies; 1 or less where nothing resonates."""
        return float(self.gain.max())

    @property
    def resonance_frequency(self) -> float:
        """Where the gain is largest [Hz]."""
        return float(self.frequency[np.argmax(self.gain)])


def frequency_response(
    arm: ArmModel,
    controller: Controller,
    q: ArrayLike,
    axis: int = 0,
    frequencies: ArrayLike = FREQUENCIES,
    amplitude: float | None = None,
    *,
    feedforward: bool = False,
    transient: float = 1.0,
    periods: int = 4,
    rate: float = 500.0,
    simulation: ArmSimulation | None = None,
) -> FrequencyResponse:
    """Swing the reference along one axis, one frequency after the other, and correlate the tool's motion with it.

    By default the reference is a position only, as in a drive's Bode plot: the loop of `OperationalSpaceController`
    then is `stiffness / (s² + damping s + stiffness)`. With `feedforward` it also carries its velocity and
    acceleration, as every trajectory does, and the same loop is 1 at all frequencies where the model is right: what is
    left of 1 is model error, friction, limits and the sampling.

    Args:
        arm: the model that the controller holds.
        controller: an `OperationalSpaceController` or an `ImpedanceController`.
        q: (nv,) around which posture to swing [rad].
        axis: of the twist, world axes: 0 to 2 along x, y, z, 3 to 5 about them.
        frequencies: [Hz].
        amplitude: of the reference [m or rad]; 5 mm or 0.02 rad where absent.
        feedforward: whether the reference carries its velocity and acceleration.
        transient: time that passes before the correlation starts [s]; some times the loop's settling time.
        periods: of the reference over which to correlate.
        rate: of the control loop [Hz]; the controller's own.
        simulation: the plant; the arm exactly as its model says, friction included, where absent.

    Raises:
        ModelError: where q does not fit the arm.
        ConfigurationError: where the axis is none of the six, a frequency is not between 0 and a quarter of the rate,
            or another number is not positive.
        SimulationError: where the loop diverges.
    """
    q, frequency = np.asarray(q, dtype=np.float64), np.unique(np.asarray(frequencies, dtype=np.float64))
    if axis not in range(6):
        raise ConfigurationError(f"axis = {axis!r} must be 0 to 2 for x, y, z or 3 to 5 for turns about them")
    highest = rate / _SAMPLES_PER_PERIOD
    if not frequency.size or not (np.isfinite(frequency).all() and frequency[0] > 0.0 and frequency[-1] <= highest):
        raise ConfigurationError(f"frequencies must be positive and at most a quarter of the rate, {highest:g} Hz")
    size = (0.005 if axis < 3 else 0.02) if amplitude is None else amplitude
    for name, value in (("amplitude", size), ("transient", transient), ("periods", periods)):
        if not 0.0 < value < inf:
            raise ConfigurationError(f"{name} = {value} must be positive and finite")
    start = arm.update(q, np.zeros(arm.nv)).pose
    simulation = ArmSimulation(arm) if simulation is None else simulation
    rows, fallbacks = [], 0
    limits: set[str] = set()
    for hertz in frequency.tolist():
        swing = _Swing(start, axis, size, 2.0 * pi * hertz, feedforward)
        motion = simulate_tracking(simulation, controller, swing.at, q, transient + periods / hertz, rate)
        kept = motion.time >= transient
        wave = swing.pulsation * motion.time[kept]
        rows.append(_fit(wave, size * np.sin(wave) - motion.error[kept, axis], size))
        limits.update(motion.active_limits(transient))
        fallbacks += motion.fallbacks
    gain, phase, distortion = np.array(rows).T
    return FrequencyResponse(frequency, gain, np.unwrap(phase), distortion, size, tuple(sorted(limits)), fallbacks)


@dataclass(frozen=True, slots=True)
class _Swing:
    """A sine along or about one world axis."""

    start: Pose
    axis: int
    amplitude: float
    pulsation: float
    feedforward: bool

    def at(self, time: float) -> Reference:
        """Return the reference at `time` [s]."""
        direction = np.zeros(6)
        direction[self.axis] = self.amplitude
        wave = self.pulsation * time
        shift = np.sin(wave) * direction
        pose = Pose(self.start.translation + shift[:3], pin.exp3(shift[3:]) @ self.start.rotation)
        if not self.feedforward:
            return Reference(pose)
        twist, acceleration = self.pulsation * np.cos(wave), -(self.pulsation**2) * np.sin(wave)
        return Reference(pose, twist * direction, acceleration * direction)


def _fit(wave: Array, motion: Array, amplitude: float) -> tuple[float, float, float]:
    """Gain, phase and distortion by least squares on sine, cosine and a constant.

    The same as correlation over whole periods, and right also where a period is no whole number of samples.
    """
    columns = np.column_stack((np.sin(wave), np.cos(wave), np.ones(len(wave))))
    weights = np.linalg.lstsq(columns, motion, rcond=None)[0]
    size = float(np.hypot(weights[0], weights[1]))
    rest = float(np.sqrt(np.mean(np.square(motion - columns @ weights))))
    return size / amplitude, float(np.arctan2(weights[1], weights[0])), rest / (size / np.sqrt(2.0)) if size else inf
