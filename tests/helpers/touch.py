"""Arms in contact with an environment, and a delayed measurement of the wrench, for the tests of contact."""

import numpy as np

from arms import HOME
from pilegrasp_ctrl.plant.arm_simulation import ArmSimulation
from pilegrasp_ctrl.types import Observation

SENSOR_CUTOFF = 8.0
LAG = 0.5 / (np.pi * SENSOR_CUTOFF) + 1.0 / 500.0
"""Lag of the simulated wrist sensor at 500 Hz: its low-pass and one control period [s]."""


def home(arm):
    return arm.update(HOME[arm.name], np.zeros(arm.nv))


class WristSensor:
    """A first-order low-pass with noise, as in `sim/wrist_sensor.py`, but without its engine."""

    def __init__(self, cutoff=SENSOR_CUTOFF, rate=500.0, noise=0.05, seed=0):
        self._blend = 1.0 - np.exp(-2.0 * np.pi * cutoff / rate)
        self._noise, self._random, self._value = noise, np.random.default_rng(seed), None

    def __call__(self, wrench):
        wrench = wrench + self._noise * self._random.standard_normal(6)
        self._value = wrench if self._value is None else self._value + self._blend * (wrench - self._value)
        return self._value


def run(arm, control, environment, duration, *, sensor=None, substeps=2, friction=1.0):
    """Return times (n,), the environment's wrenches (n, 6) and the states, one a period.

    `control(observation, state)` gives an output; without a sensor it sees the exact wrench. The plant has `friction`
    times the model's friction.
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
