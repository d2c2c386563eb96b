"""Feed-forward against joint friction, from where the tool shall go rather than from where it goes."""

from __future__ import annotations

import numpy as np

from ..arm_model import ArmModel
from ..types import Array, Reference
from .inverse_dynamics import InverseDynamics


class FrictionCompensation:
    """Torque `coulomb tanh(v* / scale) + viscous v*` for the joint velocities v* that the reference asks for.

    The measured velocity is not used: its sign flips at rest and the torque would chatter. v* is the damped
    pseudo-inverse's answer to the reference twist plus `error_rate` times the tool's pose error; the second part
    breaks a joint loose that sticks short of its goal. The Coulomb part never exceeds the friction itself, so that it
    only takes away what friction dissipates.

    Attributes:
        scale: joint velocity at which three quarters of the Coulomb friction are compensated [rad/s].
        error_rate: [1/s]; zero compensates the reference's own motion only.
    """

    def __init__(self, arm: ArmModel, scale: float = 0.02, error_rate: float = 8.0) -> None:
        """Take the arm's friction."""
        self.scale, self.error_rate = scale, error_rate
        self._coulomb, self._viscous = arm.friction_coulomb, arm.friction_viscous
        self._none = not (self._coulomb.any() or self._viscous.any())

    def torque(self, dynamics: InverseDynamics, reference: Reference, error: Array) -> Array | None:
        """Return (nv,) the feed-forward torque [N·m], None for an arm without friction.

        Args:
            dynamics: the program, assembled for this period.
            reference: where the tool should be.
            error: (6,) how far it is from there.
        """
        if self._none:
            return None
        v = dynamics.joint_velocity(reference.twist + self.error_rate * error)
        torque = np.tanh(v / self.scale)
        torque *= self._coulomb
        torque += self._viscous * v
        return torque
