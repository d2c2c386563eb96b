"""A simulated arm that is advanced one control period at a time, without a physics engine."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from ..exceptions import ArgumentError, SimulationError
from ..kernels.algebra import length_square
from ..types import Array, Observation

if TYPE_CHECKING:
    from .arm_simulation import ArmSimulation

MAX_SPEED = 1e4
"""Length of the joint velocity beyond which the motion has diverged [rad/s]; chosen."""


class ArmBackend:
    """An arm that moves; `ArmSimulation.start` makes it.

    It has the methods of a backend (`pilegrasp_ctrl.sim.backend.Backend`), so an attempt can run on it. There is no
    engine and no object; the simulation's environment replaces table and pile. Its sensor measures the wrench of the
    environment at the tool's origin.

    Attributes:
        q: (nv,) True joint positions [rad].
        v: (nv,) True joint velocities [rad/s].
        closure: Closure of the hand in the last command, which moves nothing.
        view: None, because an arm without an engine has no shapes.
    """

    view = None

    def __init__(self, simulation: ArmSimulation, q: Array, v: Array, rate: float) -> None:
        """Begin at a state, at time 0; `ArmSimulation.start` checks the arguments.

        Args:
            simulation: Plant, environment and noise.
            q: (nv,) Joint positions [rad].
            v: (nv,) Joint velocities [rad/s].
            rate: Control rate [Hz].
        """
        self.q, self.v, self.closure = q, v, 0.0
        self._simulation, self._rate, self._ticks = simulation, rate, 0
        self._model = simulation.plant.pinocchio_model
        self._data = self._model.createData()
        self._random = np.random.default_rng(simulation.seed)
        self._torque, self._friction = np.zeros(len(q)), np.zeros(len(q))
        self._wrench = np.zeros(6)
        self._zero: Array | None = None

    def __repr__(self) -> str:
        return f"ArmBackend({self._simulation.arm.name!r}, rate={self._rate:g}, time={self._ticks / self._rate:.3f})"

    def observe(self) -> Observation:
        """Return time, joint angles and velocities with the simulation's noise, and the environment's wrench."""
        self._wrench = self._simulation.wrench(self.q, self.v)
        wrench = self._wrench if self._zero is None else self._wrench - self._zero
        q, v, noise = self.q, self.v, self._simulation.noise
        if noise is not None:
            unit = self._random.standard_normal((2, len(q)))
            q, v = q + noise.position * unit[0], v + noise.velocity * unit[1]
        return Observation(self._ticks / self._rate, q, v, wrench)

    def tare(self) -> None:
        """Take the last wrench as zero."""
        self._zero = self._wrench

    def apply(self, torque: ArrayLike, closure: float = 0.0) -> None:
        """Command the joint torques (nv,) [N·m], and keep the closure.

        Raises:
            ArgumentError: The arm has another number of joints.
        """
        torque = np.array(torque, dtype=np.float64)
        if torque.shape != self.q.shape:
            raise ArgumentError(f"torque has shape {torque.shape}; {self.q.shape} is expected")
        self._torque, self.closure = torque, closure

    def step(self) -> None:
        """Integrate one control period with the commanded torques.

        Raises:
            SimulationError: The joint speed exceeds `MAX_SPEED`, so the motion has diverged.
        """
        substeps = self._simulation.substeps
        step = 1.0 / (self._rate * substeps)
        for _ in range(substeps):
            self.q, self.v, self._friction = self._advance(step)
            if not length_square(self.v) < MAX_SPEED**2:
                raise SimulationError(
                    f"{self._simulation.arm.name} diverged at {self._ticks / self._rate:.3f} s: the loop or its "
                    f"environment is too stiff for {self._rate:g} Hz and {substeps} substeps; lower the gains or raise "
                    "one of these"
                )
        self._ticks += 1

    def find_collision(self) -> None:
        """Return None: there is nothing with which the arm must not collide."""

    def object_poses(self) -> Array:
        """Return no poses (0, 7)."""
        return np.zeros((0, 7))

    def _advance(self, step: float) -> tuple[Array, Array, Array]:
        """Integrate `step` [s] by the midpoint rule; return q, v and the torque of friction, each (nv,).

        At the start of the step, the friction of the previous step replaces the unknown one.
        """
        model, data, law = self._model, self._data, self._simulation.friction
        q, v, torque = self.q, self.v, self._torque
        start = torque if law.is_zero else torque + self._friction - law.viscous * v
        a = pin.aba(model, data, q, v, self._total(start, q, v))
        q_middle, v_middle = q + 0.5 * step * v, v + 0.5 * step * a
        v_end = v + step * pin.aba(model, data, q_middle, v_middle, self._total(torque, q_middle, v_middle))
        friction = self._friction
        if not law.is_zero:
            v_end, friction = law.apply(pin.crba(model, data, q_middle), v, v_end, step)
        return q + 0.5 * step * (v + v_end), v_end, friction

    def _total(self, torque: Array, q: Array, v: Array) -> Array:
        """Return the sum of a torque and the environment's at a state, (nv,) [N·m]."""
        external = self._simulation.external(q, v)
        return torque if external is None else torque + external
