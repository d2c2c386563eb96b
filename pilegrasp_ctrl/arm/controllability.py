"""Arms that no controller could move: bodies without mass or with an impossible one, and motors that are too weak."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pinocchio as pin
from eigenpy import SelfAdjointEigenSolver  # type: ignore[import-untyped]

from ..exceptions import ModelError
from ..types import Array
from .options import listed

POSTURES = 64
"""Number of postures at which an arm is examined; chosen."""
_MAX_INDEFINITENESS = 1e-6
"""Largest negative eigenvalue of an inertia that counts as rounding, over its largest one; chosen."""
_MIN_INERTIA = 1e-10
"""Smallest inertia about the axis of a joint that counts as one [kg·m²]; chosen, 1/1000 of that of a small finger."""
_MIN_INDEPENDENCE = 1e-9
"""Smallest eigenvalue of a joint-space inertia scaled to a diagonal of ones that counts as positive; chosen."""


def spread_postures(q_lower: Array, q_upper: Array, count: int = POSTURES) -> Iterator[Array]:
    """Yield postures (nv,) spread evenly between the position limits, the middle first; they are always the same.

    They are a Kronecker sequence on the generalised golden ratio, the root above 1 of x^(nv + 1) = x + 1. A joint
    without a limit turns by half a turn to that side.
    """
    lower = np.where(np.isfinite(q_lower), q_lower, -np.pi)
    upper = np.where(np.isfinite(q_upper), q_upper, np.pi)
    nv, ratio = len(lower), 2.0
    for _ in range(50):
        ratio = math.pow(1.0 + ratio, 1.0 / (nv + 1.0))
    steps = np.array([math.pow(ratio, -joint) for joint in range(1, nv + 1)])
    for sample in range(count):
        yield lower + (upper - lower) * ((0.5 + sample * steps) % 1.0)


def check_model(model: pin.Model, frame: int, q_lower: Array, q_upper: Array, arm: str) -> None:
    """Refuse a model of which the equations of motion have no sense, or whose tool frame stands still.

    Args:
        model: Model of the arm.
        frame: Index of the tool frame.
        q_lower: (nv,) Lower position limits [rad].
        q_upper: (nv,) Upper position limits [rad].
        arm: Name of the arm, for error messages.

    Raises:
        ModelError: The error names the joint.
    """
    if model.frames[frame].parentJoint == 0:
        raise ModelError(
            f"{arm}: no joint moves the tool frame {model.frames[frame].name!r}; the joints are "
            f"{listed(list(model.names)[1:])}, so choose a frame behind one of them"
        )
    _check_bodies(model, arm)
    _check_inertia(model, q_lower, q_upper, arm)


def _check_bodies(model: pin.Model, arm: str) -> None:
    """Refuse masses and inertias that cannot be, and a joint that moves no mass."""
    for index in range(1, model.njoints):
        body = model.inertias[index]
        inertia, what = np.array(body.inertia), f"{arm}: the link on joint {model.names[index]!r}"
        if not (np.isfinite(body.mass) and np.isfinite(body.lever).all() and np.isfinite(inertia).all()):
            raise ModelError(f"{what} has a mass or inertia that is not finite; correct it")
        moments = SelfAdjointEigenSolver(inertia).eigenvalues()
        rounding = _MAX_INDEFINITENESS * abs(moments).max() + _MIN_INERTIA
        if body.mass < 0.0 or moments[0] < -rounding:
            raise ModelError(
                f"{what} has a mass of {body.mass:g} kg and principal moments of inertia "
                f"{', '.join(f'{moment:.3g}' for moment in moments)} kg·m²; none may be negative"
            )
    data = model.createData()
    pin.computeSubtreeMasses(model, data)
    for index in range(1, model.njoints):
        if not data.mass[index] > 0.0:
            raise ModelError(
                f"{arm}: the links that joint {model.names[index]!r} moves have no mass; give them inertials, or give "
                "the tool's mass properties"
            )


def _check_inertia(model: pin.Model, q_lower: Array, q_upper: Array, arm: str) -> None:
    """Refuse a joint that could be accelerated without any torque in every posture: singular joint-space inertia."""
    data, weakest = model.createData(), 0
    for q in spread_postures(q_lower, q_upper):
        M = pin.crba(model, data, q).reshape(model.nv, model.nv)
        diagonal = M.diagonal()
        weakest = int(np.argmin(diagonal))
        if diagonal[weakest] <= _MIN_INERTIA:
            continue
        scale = 1.0 / np.sqrt(diagonal)
        found = SelfAdjointEigenSolver(scale[:, None] * M * scale)
        if found.eigenvalues()[0] > _MIN_INDEPENDENCE:
            return
        weakest = int(np.argmax(np.abs(found.eigenvectors()[:, 0])))
    raise ModelError(
        f"{arm}: what joint {model.names[weakest + 1]!r} moves has no inertia against its motion; give its links "
        "inertias, or give armature"
    )


def check_strength(model: pin.Model, q_lower: Array, q_upper: Array, strength: Array, arm: str) -> None:
    """Refuse an arm with a joint that cannot carry its links in any posture.

    Args:
        model: Model of the arm.
        q_lower: (nv,) Lower position limits [rad].
        q_upper: (nv,) Upper position limits [rad].
        strength: (nv,) Torque limits less the Coulomb friction [N·m].
        arm: Name of the arm, for error messages.

    Raises:
        ModelError: The error names the joint.
    """
    data, least = model.createData(), np.full(model.nv, np.inf)
    for q in spread_postures(q_lower, q_upper):
        least = np.minimum(least, np.abs(pin.computeGeneralizedGravity(model, data, q)))
        if (least < strength).all():
            return
    joint = int(np.argmin(strength - least))
    raise ModelError(
        f"{arm}: joint {model.names[joint + 1]!r} cannot carry its links: gravity takes {least[joint]:.3g} N·m or more "
        f"in every posture, and torque_limit less friction leaves {strength[joint]:.3g} N·m; correct limit or masses"
    )
