"""Bounds on springs and dampers that are computed once in each period of a sampled loop."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..exceptions import ConfigurationError
from ..kernels import spectrum as kernels
from ..types import Array
from ..vectors import product


def check_motion_gains(stiffness: ArrayLike, damping: ArrayLike, rate: float, task: str) -> None:
    """Refuse springs and dampers that a sampled loop cannot hold.

    The acceleration `-K e - D e'` of the start of a period h acts for the whole period. Jury's criterion for that loop
    is `D h < 2` and `K h < 2 D`. With D = 2 ratio sqrt(K) it is `sqrt(K) h < min(1 / ratio, 4 ratio)`.

    Args:
        stiffness: (m,) Stiffness K of each axis [1/s²].
        damping: (m,) Damping D of each axis [1/s].
        rate: Control rate [Hz].
        task: Description of the task, for the error message.

    Raises:
        ConfigurationError: The loop would diverge along an axis.
    """
    for K, D in zip(np.ravel(stiffness).tolist(), np.ravel(damping).tolist(), strict=True):
        # A spring without any damper is never stable; a row without gains is.
        needed = max(0.5 * D, 0.5 * K / D if D > 0.0 else (np.inf if K > 0.0 else 0.0))
        if needed >= rate:
            raise ConfigurationError(
                f"{task}: a stiffness of {K:g} 1/s² with a damping of {D:.4g} 1/s diverges at {rate:g} Hz; take lower "
                f"gains, or more than {needed:.4g} Hz"
            )


def spectral_radius(mobility: Array, stiffness: Array, damping: Array, rate: float) -> float:
    """Return the factor by which the slowest-decaying motion of sampled springs and dampers changes in a period h.

    A mechanism accelerates with `-L (K e + D e')` of the period's start for the whole period:

        [e ]⁺   [1 - ½ h² L K    h - ½ h² L D] [e ]
        [e']  = [   - h L K        1 - h L D ] [e'],      L the mobility.

    Above 1 the loop diverges. If all damping comes from a ratio zeta, the modes of (Lambda, K) stay apart. The
    criterion of Jury then gives `omega h < min(1 / zeta, 4 zeta)` for each natural frequency omega. Critically damped
    springs need more control periods a second than their fastest mode has radians.

    Args:
        mobility: (m, m) Inverse of the inertia [1/kg, 1/(kg m), 1/(kg m²)].
        stiffness: (m, m) Stiffness [N/m, N·m/rad].
        damping: (m, m) Damping [N·s/m, N·m·s/rad].
        rate: Control rate [Hz].
    """
    h, one = 1.0 / rate, np.eye(len(mobility))
    spring, damper = product(mobility, stiffness), product(mobility, damping)
    step = np.block([[one - 0.5 * h * h * spring, h * (one - 0.5 * h * damper)], [-h * spring, one - h * damper]])
    return float(kernels.spectral_radius(step))
