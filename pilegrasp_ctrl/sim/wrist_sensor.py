"""The force/torque sensor at the wrist: calibrations, faults and reading."""

from __future__ import annotations

import math
from collections import deque
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..kernels.algebra import product
from ..kernels.impedance import turn_vector
from ..kernels.wrist import reading, whole_steps
from ..sections import SensorConfig
from ..types import Array, MassProperties
from ..vectors import norm, rotated

CHANNELS = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")
"""Names of the channels, in sensor axes."""

UNITS = ("N", "N", "N", "N·m", "N·m", "N·m")
"""Units of the channels."""

NOISE_BLOCK = 512
"""Number of readings whose faults are drawn at once [-], chosen; single draws would be much slower."""

_NOTHING = np.zeros(6)
"""Reading (6,) before the first one, which does not count [N, N·m]."""


DRIFT_RISE = 10.0
"""Time in which the slow drift grows to its size, and in which it goes back [s], chosen: about that of an attempt."""


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

    def describe_saturation(self, channel: int) -> str:
        """Return a text that names a channel, given by its index, that is at its range."""
        return f"{CHANNELS[channel]} beyond {self.range[channel]:g} {UNITS[channel]} of {self.name}"


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
        self._limits, self._steps = self._calibration.limits(), np.empty(6)
        housing = model.geom("sensor")
        lever = _cross(np.array([0.0, 0.0, housing.pos[2] + housing.size[1]]))
        # The minus converts the wrench on the tool into the wrench on the flange.
        self._to_steps = -_shift(-lever) / self._calibration.resolution[:, None]
        self._from_steps = _shift(lever) * self._calibration.resolution
        # Correction of the tool's weight, linear in the vertical in sensor axes.
        mass = tool.mass * (1.0 + config.tool_mass_error)
        gravity = norm(model.opt.gravity)
        self._axes, self._rotation = np.eye(3) if axes is None else axes, np.empty((3, 3))
        self._up = -rotated(self._axes, model.opt.gravity) / gravity
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
        # The oldest reading that is kept is the one that has arrived.
        self._readings: deque[tuple[Array, int]] = deque(maxlen=round(config.delay / period) + 1)
        self._slow_drift = _random_force(config.slow_drift, seed)
        self._block, self._used = np.zeros((0, 6)), 0
        self._data: mujoco.MjData | None = None
        self.saturated: str | None = None

    def sample(self, data: mujoco.MjData) -> None:
        """Take one sample; call it after every physics step."""
        if data is not self._data:
            self._look_at(data)
        self._sum += self._load
        self._count += 1

    def _look_at(self, data: mujoco.MjData) -> None:
        """Keep views of a state, because the lookup of an array in MjData costs more than its reading."""
        self._data = data
        self._load = data.sensordata[self._channels]
        self._site_rotation = data.site_xmat[self._site].reshape(3, 3)

    def read(self, data: mujoco.MjData) -> Array:
        """Average the samples since the last call, measure, compensate and filter; call it once a control period.

        Without the average, a contact that chatters from step to step might be read only at its peaks. A channel at its
        range is limited to it, and `saturated` names the channel until the next tare.

        Returns:
            The wrench (6,) [N, N·m].
        """
        if self._count == 0:
            self.sample(data)
        saturated = whole_steps(self._sum, self._count, self._to_steps, self._faults(), self._limits, self._steps)
        self._sum.fill(0.0)
        self._count = 0
        arrived = self._steps
        if self._readings.maxlen != 1:
            self._readings.append((self._steps.copy(), saturated))
            arrived, saturated = self._readings[0]
        if saturated >= 0:
            self.saturated = self.saturated or self._calibration.describe_saturation(saturated)
        wrench = np.empty(6)
        # The first reading passes the filter as it is.
        last, blend = (_NOTHING, 1.0) if self._filtered is None else (self._filtered, self._blend)
        # The sensor's rotation to the world follows from that of its site, as encoders and base give it.
        rotations = self._axes, self._site_rotation
        reading(arrived, self._from_steps, self._lift, self._up, *rotations, self._zero, last, blend, wrench)
        self._filtered = wrench
        return wrench

    def tare(self, data: mujoco.MjData) -> None:
        """Set the zero to the present reading; call it at rest, while nothing touches the hand.

        The zero is in sensor axes, in which the offset is constant, so that the hand may turn afterwards. It is the
        output of the low-pass, not one noisy sample.
        """
        held, local = self.read(data) if self._filtered is None else self._filtered, np.empty(6)
        if data is not self._data:
            self._look_at(data)
        product(self._axes, self._site_rotation, self._rotation)
        turn_vector(self._rotation, held, local)
        self._zero += local
        self._filtered = np.zeros(6)
        self.saturated = None

    def _faults(self) -> Array:
        """Return offset, drift and noise of the next reading, in steps."""
        if self._used == len(self._block):
            times = self._time + self._period * np.arange(NOISE_BLOCK)
            noise = self._sigma * self._rng.standard_normal((NOISE_BLOCK, 6))
            faults = noise + self._offset + times[:, None] * self._rate
            if self._slow_drift is not None:
                faults += swing(times)[:, None] * self._slow_drift
            self._block = faults / self._calibration.resolution
            self._time, self._used = self._time + NOISE_BLOCK * self._period, 0
        self._used += 1
        return self._block[self._used - 1]


def swing(times: NDArray[Any]) -> Array:
    """Return the share (n,) of its size that the slow drift has at `times` (n,) [s]: up and down in straight lines."""
    share: Array = 1.0 - np.abs(1.0 - np.mod(times, 2.0 * DRIFT_RISE) / DRIFT_RISE)
    return share


def _random_force(size: float, seed: int) -> Array | None:
    """Return a force of a size [N] and a random direction as channels (6,); None for no force."""
    if size == 0.0:
        return None
    direction = np.random.default_rng([seed, 0xD7]).standard_normal(3)
    return np.array([*(size / norm(direction) * direction), 0.0, 0.0, 0.0])


def _cross(vector: Array) -> Array:
    """Return the matrix (3, 3) of the cross product with `vector` (3,)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _shift(lever: Array) -> Array:
    """Return the matrix (6, 6) of a wrench about another point, for the cross product (3, 3) with the lever."""
    shift = np.eye(6)
    shift[3:, :3] = lever
    return shift
