"""Values that every room shares; they need numpy alone."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .exceptions import ArgumentError
from .vectors import product, rotated

Array = NDArray[np.float64]
"""Type of every array of numbers."""

STANDARD_GRAVITY = (0.0, 0.0, -9.81)
"""Acceleration of gravity (3,) if the world's z axis points up [m/s²]."""


def frozen_array(value: ArrayLike, shape: tuple[int, ...], name: str) -> Array:
    """Return a read-only float64 copy of `value`.

    Raises:
        ArgumentError: The shape differs, or an entry is not a finite number.
    """
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        expected = f"an array of numbers of the shape {shape}" if shape else "a number"
        raise ArgumentError(f"{name} is {value!r:.80}; {expected} is expected") from None
    if array.shape != shape:
        raise ArgumentError(f"{name} has shape {array.shape}; {shape} is expected")
    # Plain floats, because numpy takes several times as long for a few numbers.
    if not all(map(isfinite, array.ravel().tolist())):
        raise ArgumentError(f"{name} holds a value that is not finite: {array.tolist()}")
    array.setflags(write=False)
    return array


def rotation_matrices(quaternion: ArrayLike) -> Array:
    """Return the rotation matrices (..., 3, 3) of unit quaternions (..., 4), wxyz."""
    w, x, y, z = np.moveaxis(np.asarray(quaternion, dtype=np.float64), -1, 0)
    rows = (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """A rigid transform: `rotation` (3, 3) and `translation` (3,) [m] map the named frame into its parent.

    Raises:
        ArgumentError: A shape is wrong, a value is not finite, or the rotation is not orthonormal to 1e-6.
    """

    translation: Array
    rotation: Array = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        translation = frozen_array(self.translation, (3,), "translation")
        rotation = frozen_array(self.rotation, (3, 3), "rotation")
        if not _is_rotation(rotation):
            raise ArgumentError(
                "rotation is not a right-handed orthonormal matrix; its rows must be orthonormal to 1e-6"
            )
        object.__setattr__(self, "translation", translation)
        object.__setattr__(self, "rotation", rotation)

    @classmethod
    def trusted(cls, translation: Array, rotation: Array) -> Pose:
        """Return a pose of arrays that need no check, because they follow from checked ones.

        The checks cost more than the arithmetic of a whole control law. Use `Pose` for arrays from outside.
        """
        pose = object.__new__(cls)
        object.__setattr__(pose, "translation", translation)
        object.__setattr__(pose, "rotation", rotation)
        return pose

    def __matmul__(self, other: Pose) -> Pose:
        """Compose: (a to world) @ (b to a) = (b to world)."""
        translation = self.translation + rotated(self.rotation, other.translation)
        return Pose(translation, product(self.rotation, other.rotation))

    def inverse(self) -> Pose:
        """Return the transform from the parent into this frame."""
        return Pose(-rotated(self.rotation.T, self.translation), self.rotation.T)

    def moved(self, displacement: ArrayLike) -> Pose:
        """Return this pose translated by `displacement` (3,) [m] in the parent's axes."""
        return Pose(self.translation + np.asarray(displacement, dtype=np.float64), self.rotation)


def _is_rotation(matrix: Array) -> bool:
    """Return whether the first two rows are orthonormal and the third is their cross product, to 1e-6.

    Each control period makes a pose. For nine numbers, plain floats are ten times as fast as numpy.
    """
    (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()
    return (
        abs(a * a + b * b + c * c - 1.0) < 1e-6
        and abs(d * d + e * e + f * f - 1.0) < 1e-6
        and abs(a * d + b * e + c * f) < 1e-6
        and abs(b * f - c * e - g) < 1e-6
        and abs(c * d - a * f - h) < 1e-6
        and abs(a * e - b * d - i) < 1e-6
    )


def _is_positive(matrix: Array, rounding: float) -> bool:
    """Return whether no eigenvalue of a symmetric matrix (3, 3) is below -`rounding`.

    That is so if Gaussian elimination of `matrix + rounding 1` finds positive pivots only.
    """
    (a, b, c), (_, d, e), (_, _, f) = (matrix + rounding * np.eye(3)).tolist()
    if not a > 0.0:
        return False
    d, e, f = d - b * b / a, e - b * c / a, f - c * c / a
    return d > 0.0 and f - e * e / d > 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """Desired motion of the tool.

    Attributes:
        pose: Pose of the tool frame.
        twist: (6,) Twist of the tool frame's origin, linear part first, in world axes [m/s, rad/s].
        acceleration: (6,) Derivative of the twist [m/s², rad/s²].

    Raises:
        ArgumentError: A shape is wrong or a value is not finite.
    """

    pose: Pose
    twist: Array = field(default_factory=lambda: np.zeros(6))
    acceleration: Array = field(default_factory=lambda: np.zeros(6))

    def __post_init__(self) -> None:
        if not isinstance(self.pose, Pose):
            raise ArgumentError(f"the pose of a reference is a Pose, not {type(self.pose).__name__}")
        object.__setattr__(self, "twist", frozen_array(self.twist, (6,), "twist"))
        object.__setattr__(self, "acceleration", frozen_array(self.acceleration, (6,), "acceleration"))

    @classmethod
    def trusted(cls, pose: Pose, twist: Array, acceleration: Array) -> Reference:
        """Return a reference of arrays that need no check; see `Pose.trusted`."""
        reference = object.__new__(cls)
        object.__setattr__(reference, "pose", pose)
        object.__setattr__(reference, "twist", twist)
        object.__setattr__(reference, "acceleration", acceleration)
        return reference


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """Measurements of one control period.

    Attributes:
        time: Time of the measurement [s].
        q: (nv,) Joint positions [rad].
        v: (nv,) Joint velocities [rad/s].
        wrench: (6,) Wrench of the environment on the hand [N, N·m]: linear part first, at the sensor frame's origin, in
            world axes, tool weight removed.
        saturated: Sensor channel beyond its range, which makes the wrench unusable; "" if there is none.
        touched: Number of objects that touch the fingers; 0 for a hand without touch.
        inside: Number of objects that touch a finger behind its tip.
    """

    time: float
    q: Array
    v: Array
    wrench: Array = field(default_factory=lambda: np.zeros(6))
    saturated: str = ""
    touched: int = 0
    inside: int = 0

    @property
    def touch(self) -> tuple[int, int]:
        """What a primitive gets of the touch: `touched` and `inside`."""
        return self.touched, self.inside


class Command(NamedTuple):
    """Command to the arm.

    Attributes:
        torque: (nv,) Joint torques [N·m].
    """

    torque: Array


class ControllerOutput(NamedTuple):
    """Output of a controller for one control period.

    Attributes:
        command: Joint torques.
        acceleration: (nv,) Joint accelerations that the QP chose [rad/s²].
        active_limits: Names of the active limits, such as "torque[2] upper".
        solve_time: Wall-clock time of the QP [s]; recordings do not hold it.
        fallback: Reason why the QP's answer was not used; "" if it was.
        refused: What the environment refused the solver, such as memory or a file; "" if nothing. An attempt in which
            this happens has no result.
    """

    command: Command
    acceleration: Array
    active_limits: tuple[str, ...] = ()
    solve_time: float = 0.0
    fallback: str = ""
    refused: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class MassProperties:
    """Mass properties of a rigid body, in the axes of the frame that carries it; a tool is carried by the arm's flange.

    Attributes:
        mass: Mass [kg].
        center_of_mass: (3,) Centre of mass [m].
        inertia: (3, 3) Inertia about the centre of mass [kg·m²].

    Raises:
        ArgumentError: The mass is negative or not finite, or the inertia is not symmetric positive semi-definite.
    """

    mass: float
    center_of_mass: Array
    inertia: Array

    def __post_init__(self) -> None:
        mass = frozen_array(self.mass, (), "mass").item()
        if mass < 0.0:
            raise ArgumentError(f"mass is {mass:g} kg; it must not be negative")
        inertia = frozen_array(self.inertia, (3, 3), "inertia")
        if np.abs(inertia - inertia.T).max() > 1e-9 or not _is_positive(inertia, 1e-12):
            raise ArgumentError("inertia is not symmetric positive semi-definite; give it about the centre of mass")
        object.__setattr__(self, "mass", mass)
        object.__setattr__(self, "center_of_mass", frozen_array(self.center_of_mass, (3,), "center_of_mass"))
        object.__setattr__(self, "inertia", inertia)


@dataclass(frozen=True, slots=True)
class Outcome:
    """Outcome of a primitive.

    Attributes:
        name: Name of the primitive.
        status: "ended" or "failed".
        trigger: Event that ended the primitive or, after a failure, the reason.
        start: Start time [s].
        end: End time [s].
        travel: Path length of the tool [m].
        peak_force: Largest filtered force along the primitive's own direction, relative to its start [N].
        fault: Whether a collision, a saturated sensor or the time limit ended it; no further try makes sense then.
    """

    name: str
    status: str
    trigger: str
    start: float
    end: float
    travel: float
    peak_force: float
    fault: bool = False

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as plain JSON values; a fault is told by its trigger."""
        return {name: getattr(self, name) for name in self.__slots__ if name != "fault"}
