"""Calibrations of the ATI Gamma force/torque sensor: what a channel can show, and in which steps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..types import Array

CHANNELS = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")
UNITS = ("N", "N", "N", "N·m", "N·m", "N·m")


class SensorCalibration(NamedTuple):
    """One of the vendor's calibrations; channels are Fx, Fy, Fz, Tx, Ty, Tz in sensor axes.

    Attributes:
        name: the vendor's, which states the ranges of Fx and of the torques.
        range: (6,) largest load that a channel shows, either way [N, N·m].
        resolution: (6,) step of a channel [N, N·m].
    """

    name: str
    range: Array
    resolution: Array

    def limits(self) -> Array:
        """Return (6,) the range in steps of the resolution."""
        return self.range / self.resolution

    def beyond(self, steps: Array) -> str:
        """Return a text that names the first channel at its range, or "" where none is.

        Args:
            steps: (6,) what the channels would show, in steps of the resolution.
        """
        for channel, unit, step, limit, end in zip(CHANNELS, UNITS, steps, self.limits(), self.range, strict=True):
            if abs(step) >= limit:
                return f"{channel} beyond {end:g} {unit} of {self.name}"
        return ""


def _calibration(name: str, ends: tuple[float, float, float], steps: tuple[float, float, float]) -> SensorCalibration:
    """Return a calibration of ranges [N, N, N·m] and steps in one unit, each of Fx and Fy, of Fz and of the torques."""
    channels = [0, 0, 1, 2, 2, 2]
    values, resolution = np.array(ends)[channels], 1.0 / np.array(steps)[channels]
    for array in (values, resolution):
        array.setflags(write=False)
    return SensorCalibration(name, values, resolution)


CALIBRATIONS = {
    calibration.name: calibration
    for calibration in (
        _calibration("SI-32-2.5", (32.0, 100.0, 2.5), (160.0, 80.0, 2000.0)),
        _calibration("SI-65-5", (65.0, 200.0, 5.0), (80.0, 40.0, 1333.3)),
        _calibration("SI-130-10", (130.0, 400.0, 10.0), (40.0, 20.0, 800.0)),
    )
}
"""By name, after ATI Industrial Automation's tables; `docs/sensor.md` says what was compared with what."""
