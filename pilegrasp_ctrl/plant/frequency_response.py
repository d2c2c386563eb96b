"""Gain and phase of a closed loop: the response of the tool to an oscillating reference."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, exp, hypot, inf, log, pi, pow, sqrt

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..arm.model import ArmModel
from ..exceptions import ConfigurationError
from ..kernels.algebra import add_normal_equations, cholesky, solve_factored
from ..types import Array, Pose, Reference
from ..vectors import components, product
from .arm_simulation import ArmSimulation
from .tracking import Controller, simulate_tracking

FREQUENCIES = tuple(0.5 * pow(40.0, index / 16.0) for index in range(17))
"""Default frequencies of the reference [Hz]; chosen on both sides of the default gains' natural frequencies, 4.8 and
6.4 Hz."""

_DEFAULT_AMPLITUDES = (0.005, 0.02)
"""Default amplitudes of the reference along [m] and about [rad] an axis; chosen."""

_HALF_POWER = pow(10.0, -3.0 / 20.0)
"""Gain of -3 dB [-], which defines the bandwidth."""

_MIN_SAMPLES_PER_PERIOD = 4.0
"""Fewest control periods in a period of the reference [-]; chosen."""


@dataclass(frozen=True, slots=True, eq=False)
class FrequencyResponse:
    """The response from the reference's motion along one axis to the tool's, at n frequencies.

    Attributes:
        frequency: (n,) Rising frequencies [Hz].
        gain: (n,) Amplitude of the tool's motion over that of the reference [-].
        phase: (n,) Phase of the tool relative to the reference [rad], continuous over the frequency; negative if the
            tool lags.
        distortion: (n,) Rms of the motion along the axis at other frequencies, over the rms at the reference's [-]. A
            linear loop has no distortion. With friction or limits, gain and phase hold for this amplitude only.
        amplitude: Amplitude of the reference [m or rad].
        active_limits: Names of the limits that were active at any frequency, after the transient.
        fallbacks: Number of periods in which the controller's program had no solution.
    """

    frequency: Array
    gain: Array
    phase: Array
    distortion: Array
    amplitude: float
    active_limits: tuple[str, ...]
    fallbacks: int

    def __repr__(self) -> str:
        return (
            f"FrequencyResponse(n={len(self.frequency)}, bandwidth={self.bandwidth:.3g} Hz, "
            f"resonance_peak={self.resonance_peak:.3g}, active_limits={self.active_limits})"
        )

    @property
    def bandwidth(self) -> float:
        """Frequency at which the gain first falls 3 dB below 1 [Hz], interpolated in log frequency and decibel.

        It is inf if the gain stays above at all frequencies, and 0 if it is below at the lowest.
        """
        below = np.flatnonzero(self.gain < _HALF_POWER)
        if not below.size:
            return inf
        index = int(below[0])
        if index == 0:
            return 0.0
        level, frequency = (
            [log(value) for value in values[index - 1 : index + 1].tolist()] for values in (self.gain, self.frequency)
        )
        share = (level[0] - log(_HALF_POWER)) / (level[0] - level[1])
        return exp(frequency[0] + share * (frequency[1] - frequency[0]))

    @property
    def resonance_peak(self) -> float:
        """Largest gain among the frequencies [-]; 1 or less without resonance."""
        return float(self.gain.max())

    @property
    def resonance_frequency(self) -> float:
        """Frequency at which the gain is largest [Hz]."""
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
    """Oscillate the reference along one axis at each frequency, and correlate the tool's motion with it.

    By default the reference is a position only, as in a drive's Bode plot. The loop of `OperationalSpaceController` is
    then `stiffness / (s² + damping s + stiffness)`. With `feedforward` the reference also carries its velocity and
    acceleration, as every trajectory does. The same loop is then 1 at all frequencies if the model is right, and a
    deviation from 1 comes from model error, friction, limits and sampling.

    Args:
        arm: Model that the controller uses.
        controller: An `OperationalSpaceController` or an `ImpedanceController`.
        q: (nv,) Posture around which the arm oscillates [rad].
        axis: Axis of the twist, world axes: 0 to 2 along x, y, z, 3 to 5 about them.
        frequencies: Frequencies [Hz].
        amplitude: Amplitude of the reference [m or rad]; by default 5 mm or 0.02 rad.
        feedforward: Whether the reference carries its velocity and acceleration.
        transient: Time before the correlation starts [s]; several times the loop's settling time.
        periods: Number of periods of the reference over which to correlate.
        rate: Control rate [Hz]; it must be the controller's.
        simulation: Plant; by default the arm exactly as its model says, with friction.

    Raises:
        ModelError: q does not fit the arm.
        ConfigurationError: The axis is none of the six, a frequency is not between 0 and a quarter of the rate, or
            another number is not positive.
        SimulationError: The loop diverges.
    """
    q, frequency = np.asarray(q, dtype=np.float64), np.unique(np.asarray(frequencies, dtype=np.float64))
    if axis not in range(6):
        raise ConfigurationError(f"axis = {axis!r} must be 0 to 2 for x, y, z or 3 to 5 for rotations about them")
    highest = rate / _MIN_SAMPLES_PER_PERIOD
    if not frequency.size or not (np.isfinite(frequency).all() and frequency[0] > 0.0 and frequency[-1] <= highest):
        raise ConfigurationError(f"frequencies must be positive and at most a quarter of the rate, {highest:g} Hz")
    size = _DEFAULT_AMPLITUDES[axis // 3] if amplitude is None else amplitude
    for name, value in (("amplitude", size), ("transient", transient), ("periods", periods)):
        if not 0.0 < value < inf:
            raise ConfigurationError(f"{name} = {value} must be positive and finite")
    start = arm.update(q, np.zeros(arm.nv)).pose
    simulation = ArmSimulation(arm) if simulation is None else simulation
    rows, fallbacks = [], 0
    limits: set[str] = set()
    for hertz in frequency.tolist():
        oscillation = _Oscillation(start, axis, size, 2.0 * pi * hertz, feedforward)
        motion = simulate_tracking(simulation, controller, oscillation.at, q, transient + periods / hertz, rate)
        kept = motion.time >= transient
        wave = oscillation.pulsation * motion.time[kept]
        rows.append(_fit(wave, size * np.sin(wave) - motion.error[kept, axis], size))
        limits.update(motion.active_limits(transient))
        fallbacks += motion.fallbacks
    gain, phase, distortion = np.array(rows).T
    return FrequencyResponse(frequency, gain, np.unwrap(phase), distortion, size, tuple(sorted(limits)), fallbacks)


@dataclass(frozen=True, slots=True)
class _Oscillation:
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
        pose = Pose(self.start.translation + shift[:3], product(pin.exp3(shift[3:]), self.start.rotation))
        if not self.feedforward:
            return Reference(pose)
        twist, acceleration = self.pulsation * np.cos(wave), -(self.pulsation**2) * np.sin(wave)
        return Reference(pose, twist * direction, acceleration * direction)


def _fit(wave: Array, motion: Array, amplitude: float) -> tuple[float, float, float]:
    """Return gain [-], phase [rad] and distortion [-] by least squares on sine, cosine and a constant.

    Over whole periods this equals correlation. It is also right if a period is not a whole number of samples.
    """
    columns = np.column_stack((np.sin(wave), np.cos(wave), np.ones(len(wave))))
    gram, moments, factor = np.zeros((3, 3)), np.zeros(3), np.empty((3, 3))
    add_normal_equations(columns, motion, gram, moments)
    cholesky(gram, factor)
    weights = -moments
    solve_factored(factor, weights)
    size = hypot(weights[0], weights[1])
    rest = sqrt(np.mean(np.square(motion - components(columns, weights))))
    return size / amplitude, atan2(weights[1], weights[0]), rest / (size / sqrt(2.0)) if size else inf
