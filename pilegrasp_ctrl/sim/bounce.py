"""How much of its speed a contact of spring and damper gives back, and which damper gives back as much as is asked."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

PHASES = 32
"""At how many moments between two steps an impact is tried."""


def restitution_of(damping_ratio: float, step: float) -> float:
    """Return the restitution of a contact that cannot pull, as steps of finite length give it.

    The contact is integrated as the engine does it, by semi-implicit Euler; the mean is over the moments between two
    steps at which the impact may fall, which is what a pile sees. As `step` goes to zero the mean goes to the law of
    Schwager & Pöschel (2007, eq. 18), whose contact ends when the force, not the penetration, returns to zero.

    Args:
        damping_ratio: of spring and damper, not negative.
        step: of the integration times the contact's natural frequency [-].
    """
    position = -step * (np.arange(PHASES) + 0.5) / PHASES
    velocity = np.full(PHASES, -1.0)
    touching = np.ones(PHASES, dtype=bool)
    while touching.any():
        force = np.maximum(-position - 2.0 * damping_ratio * velocity, 0.0)
        velocity += touching * step * force
        position += touching * step * velocity
        touching = position < 0.0
    return float(velocity.mean())


@lru_cache(maxsize=256)
def damping_ratio_for(restitution: float, step: float) -> float:
    """Return the damping ratio whose `restitution_of` is `restitution`.

    At most that of critical damping, and less where it would turn the velocity around within a step: what asks for less
    restitution than that gives (0.11 at the shipped step) gets as little as there is.

    Raises:
        ValueError: for a restitution outside [0, 1].
    """
    if not 0.0 <= restitution <= 1.0:
        raise ValueError(f"restitution is {restitution}; it must lie in [0, 1]")
    low, high = 0.0, min(1.0, 0.5 / step)
    for _ in range(math.ceil(math.log2(1e12))):
        middle = 0.5 * (low + high)
        if restitution_of(middle, step) > restitution:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
