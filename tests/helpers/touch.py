"""What the tests of contact share: arms in touch with a wall whose stiffness is known, and a sensor that is late."""

import numpy as np

from arms import HOME, load, without_friction
from pilegrasp_ctrl.plant.arm_simulation import ArmSimulation
from pilegrasp_ctrl.types import Observation

SENSOR_CUTOFF = 8.0
LAG = 0.5 / (np.pi * SENSOR_CUTOFF) + 1.0 / 500.0
"""Of the simulated wrist sensor at 500 Hz: its low-pass and one control period [s]."""


def rubbing(name):
    """The arm with its joint friction, in the model as in the plant; the Panda's URDF names no Coulomb friction."""
    return load(name)


def smooth(name):
    return without_friction(name)


def home(arm):
    return arm.update(HOME[arm.name], np.zeros(arm.nv))


class Wall:
    """A spring without damping: nothing but the controller keeps the hand from bouncing."""

    def __init__(self, point, normal, stiffness):
        self.normal = np.asarray(normal, dtype=float)
        self._point, self._stiffness = np.asarray(point), stiffness

    def __call__(self, pose, twist):
        depth = self.normal @ (self._point - pose.translation)
        return np.concatenate((max(0.0, self._stiffness * depth) * self.normal, np.zeros(3)))


class WristSensor:
    """First-order low-pass and noise, as in `sim/wrist_sensor.py`, whose engine these tests do without."""

    def __init__(self, cutoff=SENSOR_CUTOFF, rate=500.0, noise=0.05, seed=0):
        self._blend = 1.0 - np.exp(-2.0 * np.pi * cutoff / rate)
        self._noise, self._random, self._value = noise, np.random.default_rng(seed), None

    def __call__(self, wrench):
        wrench = wrench + self._noise * self._random.standard_normal(6)
        self._value = wrench if self._value is None else self._value + self._blend * (wrench - self._value)
        return self._value


def run(arm, control, environment, duration, *, sensor=None, substeps=2, friction=1.0):
    """Return times (n,), the environment's wrenches (n, 6) and the states, one a period.

    `control(observation, state)` gives an output; without a sensor it sees the exact wrench. The plant rubs `friction`
    times as much as the model says.
    """
    states = []

    def torque(observation):
        states.append(arm.update(observation.q, observation.v))
        wrench = observation.wrench if sensor is None else sensor(observation.wrench)
        seen = Observation(observation.time, observation.q, observation.v, wrench)
        output = control(seen, states[-1])
        assert output.fallback == ""
        return output.command.torque

    plant = ArmSimulation(
        arm,
        environment=environment,
        substeps=substeps,
        friction_coulomb=friction * arm.friction_coulomb,
        friction_viscous=friction * arm.friction_viscous,
    )
    samples = list(plant.run(torque, HOME[arm.name], duration))
    return np.array([s.time for s in samples]), np.array([s.wrench for s in samples]), states
