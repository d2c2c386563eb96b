"""The numbers of an arm's joints: limits, friction and transmission, each checked and read-only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from eigenpy import ColPivHhJacobiSVD  # type: ignore[import-untyped]
from numpy.typing import ArrayLike

from ..exceptions import ModelError
from ..types import Array
from ..vectors import rotated
from .options import listed

_MAX_CONDITION = 1e6
"""Largest condition number of a `joint_to_motor` that counts as invertible; chosen."""


def joint_array(value: ArrayLike, what: str, arm: str, joints: Sequence[str]) -> Array:
    """Return one number for each joint as a read-only array (nv,).

    Raises:
        ModelError: There are not as many numbers as joints, or one is not a number.
    """
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (len(joints),):
        raise ModelError(f"{arm}: {what} must be {len(joints)} numbers, one for each of {listed(joints)}")
    if np.isnan(array).any():
        joint = joints[int(np.argmax(np.isnan(array)))]
        raise ModelError(f"{arm}: {what} of joint {joint!r} is not a number; give {what}, one number for each joint")
    array.setflags(write=False)
    return array


def check_numbers(numbers: Mapping[str, Array], arm: str, joints: Sequence[str]) -> None:
    """Refuse limits and friction that no controller could use.

    Raises:
        ModelError: A limit or a friction is out of range; the error names the joint.
    """
    for what, good in (
        ("q_lower < q_upper", numbers["q_lower"] < numbers["q_upper"]),
        ("velocity_limit > 0", numbers["velocity_limit"] > 0.0),
        ("friction_coulomb >= 0", (numbers["friction_coulomb"] >= 0.0) & np.isfinite(numbers["friction_coulomb"])),
        ("friction_viscous >= 0", (numbers["friction_viscous"] >= 0.0) & np.isfinite(numbers["friction_viscous"])),
        ("armature >= 0", (numbers["armature"] >= 0.0) & np.isfinite(numbers["armature"])),
    ):
        if not good.all():
            joint = joints[int(np.argmin(good))]
            raise ModelError(f"{arm}: joint {joint!r} does not have {what}; give the limits as arguments")
    torque = numbers["torque_limit"]
    good = (torque > 0.0) & np.isfinite(torque)
    if not good.all():
        index = int(np.argmin(good))
        raise ModelError(
            f"{arm}: joint {joints[index]!r} has a torque_limit of {torque[index]:g}; give torque_limit, a finite and "
            "positive number for each joint [N·m]"
        )


def transmission(
    joint_to_motor: ArrayLike | None, limit: ArrayLike | None, torque_limit: Array, arm: str, joints: Sequence[str]
) -> tuple[Array | None, Array | None]:
    """Return the checked matrix from joint to motor speeds (nv, nv), and the motors' largest torques (nv,).

    Raises:
        ModelError: One of the two is missing, has a wrong shape, or allows a joint more than its torque limit.
    """
    if (joint_to_motor is None) != (limit is None):
        raise ModelError(f"{arm}: joint_to_motor and motor_torque_limit go together; give both or neither")
    if joint_to_motor is None or limit is None:
        return None, None
    nv = len(joints)
    try:
        matrix = np.array(joint_to_motor, dtype=np.float64)
    except (TypeError, ValueError):
        matrix = np.empty(0)
    if matrix.shape != (nv, nv) or not np.isfinite(matrix).all() or not _is_invertible(matrix):
        raise ModelError(f"{arm}: joint_to_motor must be an invertible matrix ({nv}, {nv})")
    motors = joint_array(limit, "motor_torque_limit", arm, joints)
    if not ((motors > 0.0) & np.isfinite(motors)).all():
        raise ModelError(f"{arm}: motor_torque_limit must be positive; it is {motors.tolist()}")
    shared = (np.count_nonzero(matrix, axis=0) > 1) & (rotated(np.abs(matrix).T, motors) > torque_limit)
    if shared.any():
        joint = joints[int(np.argmax(shared))]
        raise ModelError(f"{arm}: the motors give {joint!r} more than its torque_limit; lower motor_torque_limit")
    matrix.setflags(write=False)
    return matrix, motors


def _is_invertible(matrix: Array) -> bool:
    """Return whether the condition number of a square matrix, the ratio of its singular values, is small enough."""
    values = ColPivHhJacobiSVD(matrix).singularValues()
    return bool(values[0] < _MAX_CONDITION * values[-1])
