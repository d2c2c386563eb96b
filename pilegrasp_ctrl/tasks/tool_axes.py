"""Frames, references and wrenches in axes other than the world's, and about other points."""

from __future__ import annotations

import numpy as np

from ..arm.state import ArmState, FrameState
from ..kernels import impedance as kernels
from ..types import Array, Reference


def turn_wrench(rotation: Array, wrench: Array) -> Array:
    """Return (6,) a wrench or twist, given in world axes, in axes with `rotation` (3, 3) to the world."""
    turned = np.empty(6)
    kernels.turn_vector(rotation, wrench, turned)
    return turned


def turn_frame(rotation: Array, view: ArmState | FrameState) -> FrameState:
    """Return a frame whose Jacobian, acceleration and twist are in axes with `rotation` (3, 3) to the world.

    The laws and masks of a task then act along those axes. The axes count as fixed: they are only the directions at
    this instant.
    """
    J = np.empty(view.J.shape)
    kernels.turn_rows(rotation, view.J, J)
    Jdot_v, twist = turn_wrench(rotation, view.Jdot_v), turn_wrench(rotation, view.twist)
    return FrameState(J, Jdot_v, view.translation, view.rotation, twist)


def turn_reference(rotation: Array, reference: Reference) -> Reference:
    """Return a reference whose twist and acceleration are in axes with `rotation` (3, 3) to the world."""
    twist, acceleration = turn_wrench(rotation, reference.twist), turn_wrench(rotation, reference.acceleration)
    return Reference.trusted(reference.pose, twist, acceleration)


def move_wrench(wrench: Array, lever: Array) -> Array:
    """Return (6,) a wrench about another point.

    Args:
        wrench: (6,) Force, and torque about the old point [N, N·m].
        lever: (3,) Vector from the new point to the old one, in the same axes [m].
    """
    moved = wrench.copy()
    x, y, z = lever.tolist()
    a, b, c = wrench[:3].tolist()
    moved[3] += y * c - z * b
    moved[4] += z * a - x * c
    moved[5] += x * b - y * a
    return moved
