"""Noise of encoder readings, and of velocities that are differences of these readings."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi, sqrt

import numpy as np
from eigenpy import FullPivLU  # type: ignore[import-untyped]
from numpy.typing import ArrayLike

from ..exceptions import ConfigurationError
from ..types import Array

WAM_COUNTS = 4096
"""Counts per motor revolution of the WAM's magnetic encoders [-] (Barrett's property CTS; WAM User Manual D1001 AH.00,
appendix C, has 40960 for the older optical ones)."""


@dataclass(frozen=True, slots=True, eq=False, init=False)
class SensorNoise:
    """White Gaussian noise on the measured joint positions and velocities, independent from period to period.

    Attributes:
        position: (nv,) Standard deviations, or a scalar for all joints [rad].
        velocity: (nv,) Standard deviations, or a scalar for all joints [rad/s].

    Raises:
        ConfigurationError: A value is negative or not finite.
    """

    position: Array
    velocity: Array

    def __init__(self, position: ArrayLike, velocity: ArrayLike) -> None:
        for name, given in (("position", position), ("velocity", velocity)):
            value = np.array(given, dtype=np.float64)
            if value.ndim > 1 or not np.isfinite(value).all() or (value < 0.0).any():
                raise ConfigurationError(
                    f"the noise of {name} is {value.tolist()}; give finite standard deviations >= 0"
                )
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    @classmethod
    def of_encoders(cls, joint_to_motor: ArrayLike, counts: float = WAM_COUNTS, rate: float = 500.0) -> SensorNoise:
        """Return the noise of encoders at the motors, with velocities as differences of two readings.

        A reading has an error of up to half a count, whose standard deviation is count / sqrt(12). The difference of
        two readings over one period has count · rate / sqrt(6). Barrett's driver computes velocities in this way
        (libbarrett, `LowLevelWam::update`). True rounding repeats while the joint rests, so it disturbs less than white
        noise. A difference also lags by half a period, which is not modelled.

        Args:
            joint_to_motor: (nv, nv) Matrix from joint to motor angles, or (nv,) gear ratios.
            counts: Counts per revolution of a motor.
            rate: Control rate [Hz].

        Raises:
            ConfigurationError: Counts or rate is not positive, or the transmission has no inverse.
        """
        if not (0.0 < counts < inf and 0.0 < rate < inf):
            raise ConfigurationError(f"counts = {counts} and rate = {rate} must be positive and finite")
        ratios = np.atleast_1d(np.asarray(joint_to_motor, dtype=np.float64))
        solver = FullPivLU(np.diag(ratios) if ratios.ndim == 1 else ratios)
        if not solver.isInvertible():
            raise ConfigurationError(
                "joint_to_motor has no inverse, so the encoders do not determine the joints; give a regular matrix"
            )
        motor_to_joint = solver.inverse()
        count: Array = 2.0 * pi / counts * np.sqrt(np.square(motor_to_joint).sum(axis=1))
        return cls(count / sqrt(12.0), count * rate / sqrt(6.0))
