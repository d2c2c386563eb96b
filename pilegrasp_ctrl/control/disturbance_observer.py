"""What acts on the joints beside the commanded torque, from how the arm's momentum changes."""

from __future__ import annotations

from math import exp, hypot, inf, isfinite

import numpy as np
import pinocchio as pin

from ..arm.friction import coulomb_torque
from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError, ModelError
from ..types import Array, ControllerOutput, Observation, Reference
from .friction_compensation import FEED_FORWARD_SCALE
from .operational_space import OperationalSpaceController

_LARGEST_STEP = 0.5
_LONGEST_GAP = 10.0


class DisturbanceObserver:
    """Generalized-momentum observer of the joint torques that the model does not explain.

    With the momentum p = M v, whose rate is `tau + Cᵀ v - g + tau_ext`, the estimate is

        r = K (p - p(0) - ∫ (tau + Cᵀ v - g - friction(v) + r) dt),    so that    dr/dt = K (tau_ext - r):

    a first-order low-pass of the external torque that needs no acceleration. After A. De Luca, R. Mattone, "Actuator
    failure detection and isolation using generalized momenta", ICRA 2003, and "Sensorless robot collision detection
    and hybrid force/motion control", ICRA 2005. Here the torque is held over a period, the other terms are integrated
    by the trapezoidal rule, and the low-pass is solved exactly: no bandwidth makes the observer itself unstable.

    `friction(v)` is the arm's own Coulomb and viscous friction at the measured velocity. The controllers feed it
    forward, and it must not be cancelled twice. What the estimate then holds is the error of that model, payloads,
    errors of the masses, and contact. Nothing here tells these apart: see `docs/disturbances.md` before using it in
    contact.

    Attributes:
        bandwidth: K [rad/s]; the estimate follows a step with the time constant 1 / K.
        bound: (nv,) the largest estimate [N·m].
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
            arm: the model that the controller holds.
            bandwidth: K [rad/s].
            rate: how often `update` is called [Hz].
            share: largest estimate, as a share of the torque limits.
            friction: whether the controller feeds the arm's friction forward; if not, the estimate holds all of it.
            friction_scale: `FrictionCompensation.scale` of the controller [rad/s].

        Raises:
            ConfigurationError: where a number is not positive and finite, or the bandwidth is beyond half the rate.
        """
        numbers = {"bandwidth": bandwidth, "rate": rate, "share": share, "friction_scale": friction_scale}
        for name, value in numbers.items():
            if not 0.0 < value < inf:
                raise ConfigurationError(f"{name} = {value} of the disturbance observer must be positive and finite")
        if bandwidth > _LARGEST_STEP * rate:
            largest = _LARGEST_STEP * rate
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

    def reset(self) -> None:
        """Forget the estimate and the momentum."""
        self._estimate = np.zeros(self.arm.nv)
        self._last: tuple[float, Array, Array] | None = None

    @property
    def estimate(self) -> Array:
        """(nv,) what the last update returned [N·m]."""
        return self._estimate.copy()

    def update(
        self, observation: Observation, torque: Array, state: ArmState | None = None, hold: bool = False
    ) -> Array:
        """Return (nv,) the estimated torque of the environment on the joints [N·m].

        Args:
            observation: what the arm measures now.
            torque: (nv,) what was commanded since the observation before [N·m]; ignored at the first call.
            state: `arm.update(observation.q, observation.v)` where the caller has it already.
            hold: keep the estimate as it is, for periods in contact. The momentum is followed all the same, so that the
                estimate goes on without a jump.

        Raises:
            ModelError: where the observation or the torque has a wrong shape or is not finite; the estimate stays.
        """
        state = self.arm.update(observation.q, observation.v) if state is None else state
        torque = np.asarray(torque, dtype=np.float64)
        if torque.shape != state.v.shape or not isfinite(torque.dot(torque)):
            raise ModelError(f"the commanded torque must be {self.arm.nv} finite numbers; it is {torque.tolist()}")
        momentum, passive = state.M.dot(state.v), self._passive(state)
        last, self._last = self._last, (observation.time, momentum, passive)
        if last is None:
            return self._estimate.copy()
        elapsed = observation.time - last[0]
        # A repeated observation says nothing new, and one after a long gap nothing about the torque in between.
        if hold or not 0.0 < elapsed <= _LONGEST_GAP * self._period:
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
        passive: Array = C.T.dot(v) + C.dot(v) - state.h
        passive -= coulomb_torque(v, self._coulomb, self._scale)
        passive -= self._viscous * v
        return passive


class ObservedController:
    """Asks the observer, hands its estimate to the controller, and remembers the torque for the next period.

    One instance serves one run.
    """

    def __init__(self, controller: OperationalSpaceController, observer: DisturbanceObserver) -> None:
        """Take a controller and an observer of the same arm."""
        self._controller, self._observer = controller, observer
        self._torque = observer.estimate

    def step(self, observation: Observation, reference: Reference, /) -> ControllerOutput:
        """Return the torques for one control period."""
        estimate = self._observer.update(observation, self._torque)
        output = self._controller.step(observation, reference, disturbance=estimate)
        self._torque = output.command.torque
        return output
