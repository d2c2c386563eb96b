"""A simulated arm for testing controllers without a physics engine."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import inf
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError
from ..kernels.algebra import multiply_transposed
from ..types import Array, Observation, Pose
from .arm_backend import ArmBackend
from .joint_friction import JointFriction
from .sensor_noise import SensorNoise

Environment = Callable[[Pose, Array], ArrayLike]
"""Type of an environment: a function from `transform_tool_to_world` and the tool's twist (6,) to a wrench (6,).

The wrench acts on the tool at its origin, in world axes.
"""


class ArmSample(NamedTuple):
    """The true state of the arm at the start of a control period, with command and wrench.

    Attributes:
        time: Time [s].
        q: (nv,) Joint positions [rad].
        v: (nv,) Joint velocities [rad/s].
        torque: (nv,) Commanded torque, held over the period that begins [N·m].
        wrench: (6,) Wrench of the environment on the tool at its origin, world axes [N, N·m].
    """

    time: float
    q: Array
    v: Array
    torque: Array
    wrench: Array


class ArmSimulation:
    """A plant whose mass, payload, friction, contact and sensor noise may differ from the controller's model.

    Torques are held for a control period, which is integrated in `substeps` steps of the midpoint rule. Joint friction
    is an impulse at the end of each step (`JointFriction`). Joints have no end stops. `run` simulates a controlled arm;
    `start` returns the arm, to be advanced one control period at a time. Neither changes anything in the simulation, so
    the same run gives the same samples again.

    Attributes:
        arm: Controller's model.
        plant: True arm, with its mass error and payload.
        friction: Friction of the plant's joints.
        substeps: Integration steps per control period.
        noise: Noise on the observations; None for none.
        seed: Seed of the noise.
    """

    def __init__(
        self,
        arm: ArmModel,
        *,
        substeps: int = 2,
        friction_coulomb: ArrayLike | None = None,
        friction_viscous: ArrayLike | None = None,
        mass_factor: float = 1.0,
        payload: float = 0.0,
        environment: Environment | None = None,
        noise: SensorNoise | None = None,
        seed: int = 0,
    ) -> None:
        """Build the plant.

        Args:
            arm: Model that controllers use.
            substeps: Integration steps per control period.
            friction_coulomb: Coulomb friction of the plant [N·m], (nv,) or a scalar; by default the model's.
            friction_viscous: Viscous friction of the plant [N·m·s/rad], (nv,) or a scalar; by default the model's.
            mass_factor: Mass and inertia of every link over the model's [-]. The drives' reflected inertia stays,
                because it is known better than the links'.
            payload: Point mass at the tool frame's origin that the model does not know [kg].
            environment: Environment that touches the tool. Every stage of the integration evaluates it, so a stiffness
                k on a tool of mass m needs steps well below sqrt(m / k).
            noise: Noise on the controller's observations; None for none.
            seed: Seed of the noise.

        Raises:
            ConfigurationError: A number is out of range or does not fit the arm.
        """
        if not (isinstance(substeps, int) and substeps >= 1):
            raise ConfigurationError(f"substeps = {substeps} must be a whole number of 1 or more")
        if not 0.0 < mass_factor < inf:
            raise ConfigurationError(f"mass_factor = {mass_factor} must be positive and finite")
        if not 0.0 <= payload < inf:
            raise ConfigurationError(f"payload = {payload} kg must be finite and not negative")
        self.arm = arm
        self.friction = JointFriction(
            _frictions(arm, friction_coulomb, arm.friction_coulomb, "friction_coulomb"),
            _frictions(arm, friction_viscous, arm.friction_viscous, "friction_viscous"),
        )
        if noise is not None and any(value.shape not in ((), (arm.nv,)) for value in (noise.position, noise.velocity)):
            raise ConfigurationError(
                f"the noise has another number of joints than {arm.name}; give one value or {arm.nv}"
            )
        self.plant = _with_errors(arm, mass_factor, payload)
        self.substeps, self._environment, self.noise, self.seed = substeps, environment, noise, seed

    def __repr__(self) -> str:
        return f"ArmSimulation({self.arm.name!r}, nv={self.arm.nv}, substeps={self.substeps})"

    def run(
        self,
        torque: Callable[[Observation], Array],
        q: ArrayLike,
        duration: float,
        *,
        v: ArrayLike | None = None,
        rate: float = 500.0,
    ) -> Iterator[ArmSample]:
        """Yield one sample per control period, from time 0 to one period before `duration`.

        Args:
            torque: Function from an observation to the torque (nv,) [N·m]. It is called once a period; the observation
                holds the environment's exact wrench at the tool's origin.
            q: (nv,) Joint positions at time 0 [rad].
            duration: Simulated time [s].
            v: (nv,) Joint velocities at time 0 [rad/s]; by default zero.
            rate: Control rate [Hz].

        Raises:
            ConfigurationError: The start does not fit the arm, or the duration holds no whole control period.
            SimulationError: The joint speed exceeds `MAX_SPEED`, so the motion has diverged.
        """
        arm = self.start(q, v=v, rate=rate)
        if not (0.0 < duration < inf and round(duration * rate) >= 1):
            raise ConfigurationError(
                f"duration = {duration} s and rate = {rate} Hz must be finite and hold at least one period"
            )
        return _samples(arm, torque, round(duration * rate))

    def start(self, q: ArrayLike, *, v: ArrayLike | None = None, rate: float = 500.0) -> ArmBackend:
        """Return the arm at time 0, to be advanced one control period at a time.

        Args:
            q: (nv,) Joint positions [rad].
            v: (nv,) Joint velocities [rad/s]; by default zero.
            rate: Control rate [Hz].

        Raises:
            ConfigurationError: The start does not fit the arm, or the rate is not positive and finite.
        """
        nv = self.arm.nv
        q, v = np.array(q, dtype=np.float64), np.zeros(nv) if v is None else np.array(v, dtype=np.float64)
        if q.shape != (nv,) or v.shape != (nv,) or not np.isfinite((q, v)).all():
            raise ConfigurationError(f"{self.arm.name} needs {nv} finite start positions and as many velocities")
        if not 0.0 < rate < inf:
            raise ConfigurationError(f"rate = {rate} Hz must be positive and finite")
        return ArmBackend(self, q, v, rate)

    def wrench(self, q: Array, v: Array) -> Array:
        """Return the environment's wrench (6,) on the tool at its origin, world axes [N, N·m]."""
        return np.zeros(6) if self._environment is None else _wrench(self._environment, self.plant.update(q, v))

    def external(self, q: Array, v: Array) -> Array | None:
        """Return the joint torque (nv,) of the environment at a state [N·m]; None without an environment."""
        if self._environment is None:
            return None
        state = self.plant.update(q, v)
        torque = np.empty(self.arm.nv)
        multiply_transposed(state.J, _wrench(self._environment, state), torque)
        return torque


def _samples(arm: ArmBackend, torque: Callable[[Observation], Array], ticks: int) -> Iterator[ArmSample]:
    """Yield the samples of a run."""
    for _ in range(ticks):
        observation = arm.observe()
        held = torque(observation)
        yield ArmSample(observation.time, arm.q, arm.v, held, observation.wrench)
        arm.apply(held)
        arm.step()


def _frictions(arm: ArmModel, given: ArrayLike | None, model: Array, name: str) -> Array:
    value = np.asarray(model if given is None else given, dtype=np.float64)
    if value.shape not in ((), (arm.nv,)) or not np.isfinite(value).all() or (value < 0.0).any():
        raise ConfigurationError(f"{name} must be one number or {arm.nv} for {arm.name}, finite and not negative")
    return np.array(np.broadcast_to(value, (arm.nv,)))


def _wrench(environment: Environment, state: ArmState) -> Array:
    wrench = np.asarray(environment(state.pose, state.twist), dtype=np.float64)
    if wrench.shape != (6,):
        raise ConfigurationError(
            f"the environment's wrench has the shape {wrench.shape}; return six numbers, force first"
        )
    return wrench


def _with_errors(arm: ArmModel, mass_factor: float, payload: float) -> ArmModel:
    """Return the arm with heavier links and a point mass at the origin of its tool frame."""
    model = arm.pinocchio_model
    for joint in range(1, model.njoints):
        body = model.inertias[joint]
        heavier = pin.Inertia(mass_factor * body.mass, body.lever, np.zeros((3, 3)))
        heavier.inertia = mass_factor * body.inertia
        model.inertias[joint] = heavier
    plant = arm.replace(model=model)
    return plant.with_payload(payload, np.zeros(3)) if payload > 0.0 else plant
