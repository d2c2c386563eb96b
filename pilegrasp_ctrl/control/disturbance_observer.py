"""Disturbance observer: an estimate of external joint torques from the change of the arm's momentum."""

from __future__ import annotations

from math import exp, hypot, inf, isfinite

import numpy as np
import pinocchio as pin

from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError, ModelError
from ..kernels.algebra import length_square, multiply, multiply_transposed
from ..kernels.friction import friction_torque
from ..types import Array, ControllerOutput, Observation, Reference
from .friction_compensation import FEED_FORWARD_SCALE
from .operational_space import OperationalSpaceController

_MAX_BANDWIDTH = 0.5
"""Largest bandwidth over control rate; chosen: quiet even with torques one period late (`docs/disturbances.md`)."""
_MAX_GAP = 10.0
"""Longest time between observations, in periods, that still updates the estimate; chosen."""


class DisturbanceObserver:
    """Generalized-momentum observer of the joint torques that the model does not explain.

    With the momentum p = M v, whose rate is `tau + Cᵀ v - g + tau_ext`, the estimate is

        r = K (p - p(0) - ∫ (tau + Cᵀ v - g - friction(v) + r) dt),    so that    dr/dt = K (tau_ext - r):

    The estimate is a first-order low-pass of the external torque, and needs no acceleration. After A. De Luca, R.
    Mattone, "Actuator failure detection and isolation using generalized momenta", ICRA 2003, and "Sensorless robot
    collision detection and hybrid force/motion control", ICRA 2005. Here the torque is held over a period, the other
    terms are integrated by the trapezoidal rule, and the low-pass is solved exactly. No bandwidth makes the observer
    unstable.

    `friction(v)` is the arm's own Coulomb and viscous friction at the measured velocity. The controllers feed it
    forward, and it must not be cancelled twice. The estimate then holds the error of that model, payloads, errors of
    the masses, and contact. It cannot distinguish these; read `docs/disturbances.md` before you use it in contact.

    Attributes:
        arm: Model that the controller uses.
        bandwidth: Bandwidth K [rad/s]; the estimate follows a step with the time constant 1 / K.
        bound: (nv,) Largest estimate [N·m].
    """

    def __init__(
        self,
        arm: ArmModel,
        bandwidth: float = 10.0,
        rate: float = 500.0,
        *,
        share: float = 0.3,
        friction: bool = True,
        friction_scale: float = FEED_FORWARD_SCALE,
    ) -> None:
        """Start with an estimate of zero.

        Args:
            arm: Model that the controller uses.
            bandwidth: Bandwidth K [rad/s].
            rate: Rate at which you call `update` [Hz].
            share: Largest estimate, as a share of the torque limits.
            friction: Whether the controller feeds the arm's friction forward; if not, the estimate holds all of it.
            friction_scale: Scale of the controller's `FrictionCompensation` [rad/s].

        Raises:
            ConfigurationError: A number is not positive and finite, or the bandwidth is above half the rate.
        """
        numbers = {"bandwidth": bandwidth, "rate": rate, "share": share, "friction_scale": friction_scale}
        for name, value in numbers.items():
            if not 0.0 < value < inf:
                raise ConfigurationError(f"{name} = {value} of the disturbance observer must be positive and finite")
        if bandwidth > _MAX_BANDWIDTH * rate:
            largest = _MAX_BANDWIDTH * rate
            raise ConfigurationError(f"bandwidth = {bandwidth} rad/s is too fast for {rate} Hz; take at most {largest}")
        self.arm, self.bandwidth = arm, float(bandwidth)
        self.bound: Array = share * arm.torque_limit
        self._period = 1.0 / rate
        self._scale = friction_scale
        self._coulomb = arm.friction_coulomb if friction else np.zeros(arm.nv)
        self._viscous = arm.friction_viscous if friction else np.zeros(arm.nv)
        self._model = arm.pinocchio_model
        self._data = self._model.createData()
        self.reset()

    def __repr__(self) -> str:
        return f"DisturbanceObserver({self.arm!r}, bandwidth={self.bandwidth:g})"

    def reset(self) -> None:
        """Forget the estimate and the momentum."""
        self._estimate = np.zeros(self.arm.nv)
        self._last: tuple[float, Array, Array] | None = None

    @property
    def estimate(self) -> Array:
        """(nv,) Estimate of the last update [N·m]."""
        return self._estimate.copy()

    def update(
        self, observation: Observation, torque: Array, state: ArmState | None = None, hold: bool = False
    ) -> Array:
        """Return (nv,) the estimated torque of the environment on the joints [N·m].

        Args:
            observation: Measurement of the arm.
            torque: (nv,) Torque commanded since the last observation [N·m]; ignored at the first call.
            state: `arm.update(observation.q, observation.v)`, if you have it already.
            hold: Whether to keep the estimate unchanged, for periods in contact. The momentum is still tracked, so
                the estimate continues without a jump.

        Raises:
            ModelError: The observation or the torque has a wrong shape or is not finite; the estimate stays.
        """
        state = self.arm.update(observation.q, observation.v) if state is None else state
        torque = np.asarray(torque, dtype=np.float64)
        if torque.shape != state.v.shape or not isfinite(length_square(torque)):
            raise ModelError(f"the commanded torque must be {self.arm.nv} finite numbers; it is {torque.tolist()}")
        momentum, passive = np.empty(len(state.v)), self._passive(state)
        multiply(state.M, state.v, momentum)
        last, self._last = self._last, (observation.time, momentum, passive)
        if last is None:
            return self._estimate.copy()
        elapsed = observation.time - last[0]
        # A repeated observation holds nothing new. After a long gap, the torque in between is unknown.
        if hold or not 0.0 < elapsed <= _MAX_GAP * self._period:
            return self._estimate.copy()
        external = (momentum - last[1]) / elapsed - torque - 0.5 * (passive + last[2])
        if not isfinite(hypot(*external.tolist())):
            return self._estimate.copy()
        kept = exp(-self.bandwidth * elapsed)
        estimate = kept * self._estimate + (1.0 - kept) * external
        self._estimate = np.minimum(np.maximum(estimate, -self.bound), self.bound)
        return self._estimate.copy()

    def _passive(self, state: ArmState) -> Array:
        """Return (nv,) the momentum's rate without torques: Cᵀ v - g - friction, with C v + g = h."""
        C, v = pin.computeCoriolisMatrix(self._model, self._data, state.q, state.v), state.v
        passive, along, friction = np.empty((3, len(v)))
        multiply_transposed(C, v, passive)
        multiply(C, v, along)
        passive += along - state.h
        friction_torque(v, self._coulomb, self._viscous, self._scale, friction)
        passive -= friction
        return passive


class ObservedController:
    """A motion controller that cancels the estimate of an observer.

    It remembers the torque of the last period for the observer, so use a new instance for each run.
    """

    def __init__(self, controller: OperationalSpaceController, observer: DisturbanceObserver) -> None:
        """Join a controller and an observer of the same arm."""
        self._controller, self._observer = controller, observer
        self._torque = observer.estimate

    def __repr__(self) -> str:
        return f"ObservedController({self._controller!r}, {self._observer!r})"

    def step(self, observation: Observation, reference: Reference, /) -> ControllerOutput:
        """Return the torques for one control period."""
        estimate = self._observer.update(observation, self._torque)
        output = self._controller.step(observation, reference, disturbance=estimate)
        self._torque = output.command.torque
        return output
