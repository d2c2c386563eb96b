"""The force/torque sensor at the wrist: calibrations, faults and reading."""

from __future__ import annotations

import math
from typing import NamedTuple

import mujoco
import numpy as np

from ..sections import SensorConfig
from ..types import Array, MassProperties

CHANNELS = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")
"""Names of the channels, in sensor axes."""

UNITS = ("N", "N", "N", "N·m", "N·m", "N·m")
"""Units of the channels."""

NOISE_BLOCK = 512
"""Number of readings whose faults are drawn at once [-], chosen; single draws would be much slower."""


class SensorCalibration(NamedTuple):
    """Calibration of the ATI Gamma; channels are Fx, Fy, Fz, Tx, Ty, Tz in sensor axes.

    Attributes:
        name: Vendor's name, which contains the ranges of Fx and of the torques.
        range: (6,) largest load of each channel in both directions [N, N·m].
        resolution: (6,) step of each channel [N, N·m].
    """

    name: str
    range: Array
    resolution: Array

    def limits(self) -> Array:
        """Return the range (6,) in steps of the resolution."""
        return self.range / self.resolution

    def find_saturated(self, steps: Array) -> str | None:
        """Return a text that names the first channel at its range, or None.

        Args:
            steps: Unlimited readings (6,), in steps of the resolution.
        """
        for channel, unit, step, limit, end in zip(CHANNELS, UNITS, steps, self.limits(), self.range, strict=True):
            if abs(step) >= limit:
                return f"{channel} beyond {end:g} {unit} of {self.name}"
        return None


def _calibration(name: str, ends: tuple[float, float, float], steps: tuple[float, float, float]) -> SensorCalibration:
    """Return a calibration from ranges [N, N, N·m] and steps per unit, each for Fx and Fy, Fz, and the torques."""
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
"""Calibrations by name, from ATI Industrial Automation's tables; `docs/sensor.md` describes how they were checked."""


class WristSensor:
    """Reads the wrench of the environment on the hand, at the flange's origin, in world axes, linear part first.

    MuJoCo's sensors give the wrench of the flange on the tool. At rest it balances the environment's wrench and the
    tool's weight. The weight of the nominal tool is removed, but not its inertial force (0.2 N at 0.5 m/s²).

    The steps are those of the instrument. It measures the load about the centre of the sensor's tool side, in sensor
    axes, including the tool's weight. Offset, drift and noise are added, then range and steps are applied. Software
    removes the tool's weight and the tare, changes to world axes, and applies the low-pass. `docs/sensor.md` gives the
    source of every number.

    Attributes:
        saturated: Text that names the first channel at its range since the last tare, or None.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        tool: MassProperties,
        config: SensorConfig,
        period: float,
        seed: int,
        axes: Array | None = None,
    ) -> None:
        """Draw the offset and the drift of this attempt.

        Args:
            model: MuJoCo model with the sensor's housing, site and MuJoCo sensors, as `Hand.add_to` makes them.
            tool: Nominal mass properties of everything beyond the flange.
            config: Calibration and faults.
            period: Control period, in which `read` is called once [s].
            seed: Seed of offset, drift and noise.
            axes: (3, 3) rotation from the scene's axes to those that the arm takes for the world's; None means the
                identity.
        """
        first = int(model.sensor("wrist_force").adr[0])
        self._channels = slice(first, first + 6)
        self._sum, self._count = np.zeros(6), 0
        self._site = model.site("wrist_sensor").id
        self._calibration = CALIBRATIONS[config.calibration]
        self._limits = tuple(self._calibration.limits()[[0, 2, 3]].tolist())
        shift = np.eye(6)
        housing = model.geom("sensor")
        shift[3:, :3] = _cross(np.array([0.0, 0.0, housing.pos[2] + housing.size[1]]))
        # The minus converts the wrench on the tool into the wrench on the flange.
        self._to_steps = -np.linalg.inv(shift) / self._calibration.resolution[:, None]
        self._from_steps = shift * self._calibration.resolution
        # Correction of the tool's weight, linear in the vertical in sensor axes.
        mass = tool.mass * (1.0 + config.tool_mass_error)
        gravity = np.linalg.norm(model.opt.gravity)
        self._axes = np.eye(3) if axes is None else axes
        self._up = -self._axes.dot(model.opt.gravity) / gravity
        self._lift = gravity * mass * np.vstack((np.eye(3), _cross(tool.center_of_mass)))
        self._sigma = np.repeat(np.array([config.force_noise, config.torque_noise], dtype=float), 3)
        self._rng = np.random.default_rng([seed, 0x5E])
        # A separate stream, so that the faults do not change the noise of a seed.
        faults = np.random.default_rng([seed, 0xB1]).uniform(-1.0, 1.0, (2, 6)) * self._calibration.range
        self._offset, self._rate = config.bias * faults[0], config.drift * faults[1] / 60.0
        self._period, self._time = period, 0.0
        self._blend = 1.0 - math.exp(-2.0 * math.pi * config.cutoff * period)
        self._zero = np.zeros(6)
        self._filtered: Array | None = None
        self._block, self._used = np.zeros((0, 6)), 0
        self.saturated: str | None = None

    def sample(self, data: mujoco.MjData) -> None:
        """Take one sample; call it after every physics step."""
        self._sum += data.sensordata[self._channels]
        self._count += 1

    def read(self, data: mujoco.MjData) -> Array:
        """Average the samples since the last call, measure, compensate and filter; call it once a control period.

        Without the average, a contact that chatters from step to step might be read only at its peaks. A channel at its
        range is limited to it, and `saturated` names the channel until the next tare.

        Returns:
            The wrench (6,) [N, N·m].
        """
        if self._count == 0:
            self.sample(data)
        steps = self._to_steps.dot(self._sum / self._count)
        self._sum.fill(0.0)
        self._count = 0
        steps += self._faults()
        np.rint(steps, steps)
        lateral, axial, moment = self._limits
        # Plain floats, because numpy takes several times as long for six numbers.
        a, b, c, d, e, f = steps.tolist()
        if not (
            -lateral < a < lateral
            and -lateral < b < lateral
            and -axial < c < axial
            and -moment < d < moment
            and -moment < e < moment
            and -moment < f < moment
        ):
            self._saturate(steps)
        local = self._from_steps.dot(steps)
        rotation = self._rotation(data)
        local += self._lift.dot(self._up.dot(rotation))
        local -= self._zero
        wrench = local.reshape(2, 3).dot(rotation.T).reshape(6)
        self._filtered = wrench if self._filtered is None else self._filtered + self._blend * (wrench - self._filtered)
        return self._filtered

    def tare(self, data: mujoco.MjData) -> None:
        """Set the zero to the present reading; call it at rest, while nothing touches the hand.

        The zero is in sensor axes, in which the offset is constant, so that the hand may turn afterwards. It is the
        output of the low-pass, not one noisy sample.
        """
        held = self.read(data) if self._filtered is None else self._filtered
        rotation = self._rotation(data)
        self._zero += held.reshape(2, 3).dot(rotation).reshape(6)
        self._filtered = np.zeros(6)
        self.saturated = None

    def _rotation(self, data: mujoco.MjData) -> Array:
        """Return the sensor's rotation (3, 3) to the world, as encoders and base give it."""
        return self._axes.dot(data.site_xmat[self._site].reshape(3, 3))

    def _saturate(self, steps: Array) -> None:
        """Limit the channels to their ranges, in place, and store the first saturated one; NaN is not reported."""
        self.saturated = self.saturated or self._calibration.find_saturated(steps)
        limits = self._calibration.limits()
        np.clip(steps, -limits, limits, out=steps)

    def _faults(self) -> Array:
        """Return offset, drift and noise of the next reading, in steps."""
        if self._used == len(self._block):
            times = self._time + self._period * np.arange(NOISE_BLOCK)
            noise = self._sigma * self._rng.standard_normal((NOISE_BLOCK, 6))
            self._block = (noise + self._offset + times[:, None] * self._rate) / self._calibration.resolution
            self._time, self._used = self._time + NOISE_BLOCK * self._period, 0
        self._used += 1
        return self._block[self._used - 1]


def _cross(vector: Array) -> Array:
    """Return the matrix (3, 3) of the cross product with `vector` (3,)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
