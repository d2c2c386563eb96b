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
from ..exceptions import ConfigurationError, SimulationError
from ..types import Array, Observation, Pose
from .joint_friction import JointFriction
from .sensor_noise import SensorNoise

MAX_SPEED = 1e4
"""Length of the joint velocity beyond which the motion has diverged [rad/s]; chosen."""

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
    is an impulse at the end of each step (`JointFriction`). Joints have no end stops. A run changes nothing in the
    simulation, so the same run gives the same samples again.

    Attributes:
        arm: Controller's model.
        plant: True arm, with its mass error and payload.
        friction: Friction of the plant's joints.
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
        self._model = self.plant.pinocchio_model
        self._substeps, self._environment, self._noise, self._seed = substeps, environment, noise, seed

    def __repr__(self) -> str:
        return f"ArmSimulation({self.arm.name!r}, nv={self.arm.nv}, substeps={self._substeps})"

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
        nv = self.arm.nv
        q, v = np.array(q, dtype=np.float64), np.zeros(nv) if v is None else np.array(v, dtype=np.float64)
        if q.shape != (nv,) or v.shape != (nv,) or not np.isfinite((q, v)).all():
            raise ConfigurationError(f"{self.arm.name} needs {nv} finite start positions and as many velocities")
        if not (0.0 < duration < inf and 0.0 < rate < inf and round(duration * rate) >= 1):
            raise ConfigurationError(
                f"duration = {duration} s and rate = {rate} Hz must be finite and hold at least one period"
            )
        return self._run(torque, q, v, round(duration * rate), rate)

    def _run(
        self, torque: Callable[[Observation], Array], q: Array, v: Array, ticks: int, rate: float
    ) -> Iterator[ArmSample]:
        data = self._model.createData()
        random = np.random.default_rng(self._seed)
        step = 1.0 / (rate * self._substeps)
        friction = np.zeros(len(q))
        for tick in range(ticks):
            time = tick / rate
            wrench = self.wrench(q, v)
            held = torque(Observation(time, *self._measured(q, v, random), wrench))
            yield ArmSample(time, q, v, held, wrench)
            for _ in range(self._substeps):
                q, v, friction = self._advance(data, q, v, held, friction, step)
                if not v.dot(v) < MAX_SPEED**2:
                    raise SimulationError(
                        f"{self.arm.name} diverged at {time:.3f} s: the loop or its environment is too stiff for "
                        f"{rate:g} Hz and {self._substeps} substeps; lower the gains or raise one of these"
                    )

    def wrench(self, q: Array, v: Array) -> Array:
        """Return the environment's wrench (6,) on the tool at its origin, world axes [N, N·m]."""
        return np.zeros(6) if self._environment is None else _wrench(self._environment, self.plant.update(q, v))

    def external(self, q: Array, v: Array) -> Array | None:
        """Return the joint torque (nv,) of the environment at a state [N·m]; None without an environment."""
        if self._environment is None:
            return None
        state = self.plant.update(q, v)
        return state.J.T.dot(_wrench(self._environment, state))

    def _measured(self, q: Array, v: Array, random: np.random.Generator) -> tuple[Array, Array]:
        if self._noise is None:
            return q, v
        unit = random.standard_normal((2, len(q)))
        return q + self._noise.position * unit[0], v + self._noise.velocity * unit[1]

    def _advance(
        self, data: pin.Data, q: Array, v: Array, torque: Array, friction: Array, step: float
    ) -> tuple[Array, Array, Array]:
        """Integrate one step; at its start, the friction of the previous step replaces the unknown one."""
        model, friction_law = self._model, self.friction
        start = torque if friction_law.is_zero else torque + friction - friction_law.viscous * v
        a = pin.aba(model, data, q, v, self._total(start, q, v))
        q_middle, v_middle = q + 0.5 * step * v, v + 0.5 * step * a
        v_end = v + step * pin.aba(model, data, q_middle, v_middle, self._total(torque, q_middle, v_middle))
        if not friction_law.is_zero:
            v_end, friction = friction_law.apply(pin.crba(model, data, q_middle), v, v_end, step)
        return q + 0.5 * step * (v + v_end), v_end, friction

    def _total(self, torque: Array, q: Array, v: Array) -> Array:
        external = self.external(q, v)
        return torque if external is None else torque + external


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
        model.inertias[joint] = pin.Inertia(mass_factor * body.mass, body.lever, mass_factor * body.inertia)
    frame = model.frames[model.getFrameId(arm.tool_frame)]
    if payload > 0.0:
        model.appendBodyToJoint(frame.parentJoint, pin.Inertia(payload, np.zeros(3), np.zeros((3, 3))), frame.placement)
    return ArmModel(
        model,
        frame.name,
        name=arm.name,
        q_lower=arm.q_lower,
        q_upper=arm.q_upper,
        velocity_limit=arm.velocity_limit,
        torque_limit=arm.torque_limit,
        friction_coulomb=arm.friction_coulomb,
        friction_viscous=arm.friction_viscous,
    )
