"""The paper's rule for how well an object bounces."""

from __future__ import annotations

import numpy as np


def restitution_for_mass(mass: float) -> float:
    """Return the restitution [-] of an object of that mass [kg].

    The paper's line through COR(60 g) = 0.72 and COR(180 g) = 0.37 (V-A), clipped to [0, 1]: it would be negative above
    307 g, and the paper's Fig. 11 goes to 720 g.
    """
    return float(np.clip(0.72 + (mass - 0.060) * (0.37 - 0.72) / (0.180 - 0.060), 0.0, 1.0))
