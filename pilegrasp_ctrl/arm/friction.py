"""The friction law of the joints, which all controllers share."""

from __future__ import annotations

import numpy as np

from ..types import Array


def coulomb_torque(v: Array, coulomb: Array, scale: float) -> Array:
    """Return (nv,) the Coulomb friction `coulomb tanh(v / scale)` of moving joints [N·m].

    The whole friction against a motion is this plus `viscous v`. Dry friction jumps at rest, and a control law must not
    follow that jump. The hyperbolic tangent therefore passes through zero. A simulated joint that sticks needs another
    law; see `plant/joint_friction.py`.

    Args:
        v: (nv,) Joint velocities [rad/s].
        coulomb: (nv,) Coulomb friction at full slip [N·m].
        scale: Joint velocity at which three quarters of the Coulomb friction act [rad/s].
    """
    torque: Array = coulomb * np.tanh(v / scale)
    return torque
