"""The force/torque sensor at the wrist: sign, frame, tool weight, noise and low-pass."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from ..config import SensorConfig
from ..types import Array, MassProperties

GRAVITY = 9.81
NOISE_BLOCK = 512


class WristSensor:
    """Reads what the environment does to the hand, at the flange's origin, in world axes, linear part first.

    MuJoCo's sensors give what the flange does to the tool. At rest that balances the environment's wrench and the
    tool's weight; the weight of the nominal tool is taken off, its inertial force is not (0.2 N at 0.5 m/s²).
    """

    def __init__(
        self, model: mujoco.MjModel, tool: MassProperties, config: SensorConfig, period: float, seed: int
    ) -> None:
        first = int(model.sensor("wrist_force").adr[0])
        self._channels = slice(first, first + 6)
        self._sum, self._count = np.zeros(6), 0
        self._site = model.site("wrist_sensor").id
        # What takes the tool's weight off, as a linear map of the world's vertical in sensor axes.
        self._lift = GRAVITY * np.vstack((tool.mass * np.eye(3), tool.mass * _cross(tool.center_of_mass)))
        self._sigma = np.repeat([config.force_noise, config.torque_noise], 3)
        self._rng = np.random.default_rng([seed, 0x5E])
        self._blend = 1.0 - math.exp(-2.0 * math.pi * config.cutoff * period)
        self._filtered: Array | None = None
        self._block, self._used = np.zeros((0, 6)), 0

    def sample(self, data: mujoco.MjData) -> None:
        """Take one sample; call it after every physics step."""
        self._sum += data.sensordata[self._channels]
        self._count += 1

    def read(self, data: mujoco.MjData) -> Array:
        """Average the samples since the last call, compensate and filter; call it once a control period.

        The average is what keeps a contact that chatters from step to step from being read at its crests only.

        Returns:
            The wrench (6,) [N, N·m].
        """
        if self._count == 0:
            self.sample(data)
        local = self._sum / -self._count
        self._sum.fill(0.0)
        self._count = 0
        rotation = data.site_xmat[self._site].reshape(3, 3)
        local += self._lift.dot(rotation[2])
        wrench = local.reshape(2, 3).dot(rotation.T).reshape(6)
        wrench += self._noise()
        self._filtered = wrench if self._filtered is None else self._filtered + self._blend * (wrench - self._filtered)
        return self._filtered

    def _noise(self) -> Array:
        """Return the next sample of noise; drawn in blocks, which a generator does much faster."""
        if self._used == len(self._block):
            self._block, self._used = self._sigma * self._rng.standard_normal((NOISE_BLOCK, 6)), 0
        self._used += 1
        return self._block[self._used - 1]


def _cross(vector: Array) -> Array:
    """Return the matrix (3, 3) of the cross product with `vector` (3,)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
