"""What the tasks of the joints share: springs and dampers on linear functions of the joint positions."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, sqrt
from typing import Any

import numpy as np
from eigenpy import ColPivHouseholderQR  # type: ignore[import-untyped]
from numpy.typing import ArrayLike

from ..arm.fitting import check_arm
from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ArgumentError, ConfigurationError
from ..kernels import joints as kernels
from ..types import Array
from .sampled_motion import check_motion_gains
from .task import Objective


class LinearTask:
    """The task C q = target with springs and dampers: `C a = a_ref + damping (v_ref - C v) + stiffness (target - C q)`.

    The springs never ask for a speed beyond `max_speed`, as those of `FrameTask`.

    Attributes:
        arm: Arm whose joints they are.
        C: (m, nv) Rows.
        weight: Weight relative to other tasks.
        regular: Whether the rows leave no motion of the joints free.
    """

    def __init__(
        self,
        arm: ArmModel,
        C: Array,
        target: ArrayLike | None,
        stiffness: ArrayLike,
        damping: ArrayLike,
        weight: float,
        max_speed: ArrayLike = inf,
    ) -> None:
        """Set rows, target and gains.

        Args:
            arm: Arm whose joints they are.
            C: (m, nv) Rows.
            target: (m,) Values that C q should have; None only damps.
            stiffness: Scalar or (m,) stiffness [1/s²].
            damping: Scalar or (m,) damping [1/s].
            weight: Weight relative to other tasks.
            max_speed: Scalar or (m,) largest speed of C q that the springs ask for [rad/s].

        Raises:
            ConfigurationError: A gain or the weight is not positive and finite, or a shape is wrong.
        """
        self.arm, self.C = arm, C
        self.regular = len(C) >= arm.nv and ColPivHouseholderQR(C).rank() == arm.nv
        self._zero = np.zeros(len(C))
        self._numbers: tuple[Any, ...] | None = None
        self._stiffness, self._damping = self._gain("stiffness", stiffness), self._gain("damping", damping)
        self._max_speed = self._gain("max_speed", max_speed, largest=inf)
        self.weight = weight
        self._target = self._velocity_target = self._acceleration_target = self._zero
        if target is not None:
            self._target = self._values("target", target)
        self._set_springs(self._zero if target is None else self._stiffness, self._damping)
        self._wanted = np.zeros(len(C))

    def _set_springs(self, stiffness: Array, damping: Array) -> None:
        self._stiffness, self._damping, self._numbers = stiffness, damping, None
        self._rates = np.divide(stiffness, damping, out=np.zeros(len(self.C)), where=damping > 0.0)

    @property
    def stiffness(self) -> Array:
        """(m,) Stiffness [1/s²]; zero leaves the damping alone."""
        return self._stiffness

    @property
    def damping(self) -> Array:
        """(m,) Damping [1/s]."""
        return self._damping

    @property
    def is_linear(self) -> bool:
        """Whether the rows are those of `linear_rows`, with the numbers of `numbers`."""
        return True

    @property
    def numbers(self) -> tuple[Any, ...]:
        """C; rows of target, stiffness / damping, largest speed, v and a of the target, damping; root of the weight.

        The object is another one where a number has changed.
        """
        if self._numbers is None:
            moving = self._velocity_target, self._acceleration_target
            springs = np.array([self._target, self._rates, self._max_speed, *moving, self._damping])
            self._numbers = self.C, springs, self._root
        return self._numbers

    @property
    def target(self) -> Array:
        """(m,) Values that C q should have."""
        return self._target

    @property
    def max_speed(self) -> Array:
        """(m,) Largest speed of C q that the springs ask for [rad/s]."""
        return self._max_speed

    @property
    def weight(self) -> float:
        """Weight relative to other tasks."""
        return self._weight

    @weight.setter
    def weight(self, weight: float) -> None:
        self._weight = positive_number(weight, "weight", self)
        self._root, self._numbers = sqrt(self._weight), None

    def set_target(
        self, target: ArrayLike, velocity: ArrayLike | None = None, acceleration: ArrayLike | None = None
    ) -> None:
        """Set the target for the coming periods.

        Args:
            target: (m,) Values that C q should have, such as joint positions [rad].
            velocity: (m,) Their velocity [rad/s]; at rest by default.
            acceleration: (m,) Their acceleration [rad/s²]; zero by default.

        Raises:
            ConfigurationError: A value is not m finite numbers.
        """
        self._target, self._numbers = self._values("target", target), None
        self._velocity_target = self._zero if velocity is None else self._values("velocity", velocity)
        self._acceleration_target = self._zero if acceleration is None else self._values("acceleration", acceleration)

    def check(self, rate: float) -> None:
        """Refuse gains that a loop sampled at `rate` [Hz] cannot hold.

        Raises:
            ConfigurationError: The loop would diverge.
        """
        check_motion_gains(self.stiffness, self.damping, rate, repr(self))

    def rows(self, state: ArmState) -> Objective:
        """Return the rows at a state."""
        kernels.linear_velocity(self.C, state.q, self.target, self._rates, self.max_speed, self._root, self._wanted)
        A, b = np.empty(self.C.shape), np.empty(len(self.C))
        references = self._velocity_target, self._acceleration_target
        kernels.linear_rows(self.C, state.v, self._wanted, *references, self._damping, self._root, A, b)
        return Objective(A, b)

    def velocity(self, error_rate: float) -> Array:
        """Return (m,) the weighted velocity of the slow mode of springs and dampers; see `Task`."""
        return self._wanted + self._root * self._velocity_target

    def _gain(self, name: str, value: ArrayLike, largest: float = np.finfo(float).max) -> Array:
        array = self._broadcast(name, value)
        if not ((array >= 0.0) & (array <= largest)).all():
            raise ConfigurationError(
                f"{name} = {value!r:.80} of the {type(self).__name__} must be finite and not negative"
            )
        return array

    def _values(self, name: str, value: ArrayLike) -> Array:
        array = self._broadcast(name, value, scalar=len(self.C) == 1)
        if not np.isfinite(array).all():
            raise ConfigurationError(self._wrong(name, value))
        return array

    def _wrong(self, name: str, value: object) -> str:
        wanted = f"{len(self.C)} finite numbers" if len(self.C) > 1 else "one finite number"
        return f"the {name} of the {type(self).__name__} must be {wanted}; it is {value!r:.80}"

    def _broadcast(self, name: str, value: ArrayLike, scalar: bool = True) -> Array:
        m = len(self.C)
        try:
            array = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            array = np.zeros((0, 0))
        if array.shape != (m,) and not (scalar and array.shape == ()):
            raise ConfigurationError(self._wrong(name, value))
        array = np.array(np.broadcast_to(array, (m,)))
        array.setflags(write=False)
        return array


def positive_number(value: Any, name: str, task: object) -> float:
    """Return a positive, finite number.

    Raises:
        ConfigurationError: It is none; the message names the class of `task`.
    """
    good = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    if not good or not 0.0 < value < inf:
        raise ConfigurationError(f"{name} = {value!r:.80} of the {type(task).__name__} must be positive and finite")
    return float(value)


def select_joints(arm: ArmModel, joints: Sequence[str] | None, task: str) -> Array:
    """Return (m, nv) the rows of the identity for the named joints; all of them for None.

    Raises:
        ArgumentError: `arm` is not an arm, or a name is unknown, given twice, or there is none; `task` names the class.
    """
    check_arm(arm, task)
    if joints is None:
        return np.eye(arm.nv)
    known = arm.joint_names
    if isinstance(joints, str) or not joints or len(set(joints)) != len(joints) or not set(joints) <= set(known):
        raise ArgumentError(f"joints = {joints!r:.80} of the {task} must be different names of {', '.join(known)}")
    return np.eye(arm.nv)[[known.index(joint) for joint in joints]]
