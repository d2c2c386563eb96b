"""The task of a preferred posture, which uses the freedom that other tasks leave."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from ..arm.model import ArmModel
from .linear_task import LinearTask, positive_number, select_joints

POSTURE_WEIGHT = 1e-4
"""Default weight of the posture against the tool's weight of 1; chosen so that it does not disturb the tool."""
STIFFNESS = 100.0
"""Default stiffness toward a posture [1/s²]; chosen."""
DAMPING = 20.0
"""Default damping of joints without a preferred posture [1/s]; chosen, critical for the default stiffness."""


class PostureTask(LinearTask):
    """The task of a preferred posture: rows sqrt(weight) (a - stiffness (q* - q) + damping v) for all joints.

    The weight is small against the tool's, so this task decides only what the tool leaves free. A redundant arm needs
    it: without a posture, the joints of a tool that returns to its pose do not return to theirs. For small
    accelerations it also bounds the joint accelerations near singular postures, as damped least squares do;
    `SingularDirections` does this for large ones.
    """

    def __init__(
        self,
        arm: ArmModel,
        target: ArrayLike | None = None,
        stiffness: float = STIFFNESS,
        damping_ratio: float = 1.0,
        weight: float = POSTURE_WEIGHT,
    ) -> None:
        """Set the target and the gains.

        Args:
            arm: Arm whose joints they are.
            target: (nv,) Preferred joint positions [rad]; None only damps.
            stiffness: Stiffness [1/s²].
            damping_ratio: Damping ratio; 1 is critical damping.
            weight: Weight relative to other tasks.

        Raises:
            ConfigurationError: A number is not positive and finite, or the target does not fit the arm.
            ArgumentError: `arm` is not an arm.
        """
        stiffness = positive_number(stiffness, "stiffness", self)
        damping = 2.0 * positive_number(damping_ratio, "damping_ratio", self) * sqrt(stiffness)
        super().__init__(arm, select_joints(arm, None, "PostureTask"), target, stiffness, damping, weight)
        self._spring = stiffness

    def __repr__(self) -> str:
        target = self.target.tolist() if self.stiffness.any() else None
        return f"PostureTask({target}, stiffness={self._spring:g}, weight={self.weight:g})"

    def set_target(
        self, target: ArrayLike, velocity: ArrayLike | None = None, acceleration: ArrayLike | None = None
    ) -> None:
        """Set the preferred posture for the coming periods; a task that only damped gets its springs."""
        super().set_target(target, velocity, acceleration)
        self._set_springs(np.full(len(self.C), self._spring), self.damping)

    @contextmanager
    def instead(self, target: ArrayLike | None) -> Iterator[None]:
        """Prefer another posture (nv,) within a `with` block; None changes nothing."""
        if target is None:
            yield
            return
        kept = self.target, self.stiffness, self._velocity_target, self._acceleration_target
        self.set_target(target)
        try:
            yield
        finally:
            self._target, stiffness, self._velocity_target, self._acceleration_target = kept
            self._set_springs(stiffness, self.damping)


class DampingTask(LinearTask):
    """The task of joints at rest, rows sqrt(weight) (a + damping v): motion that other tasks leave free dies out."""

    def __init__(self, arm: ArmModel, damping: ArrayLike = DAMPING, weight: float = POSTURE_WEIGHT) -> None:
        """Set the damping.

        Args:
            arm: Arm whose joints they are.
            damping: Scalar or (nv,) damping [1/s].
            weight: Weight relative to other tasks.

        Raises:
            ConfigurationError: A number is negative or not finite.
            ArgumentError: `arm` is not an arm.
        """
        super().__init__(arm, select_joints(arm, None, "DampingTask"), None, 0.0, damping, weight)

    def __repr__(self) -> str:
        return f"DampingTask({self.damping.tolist()}, weight={self.weight:g})"
