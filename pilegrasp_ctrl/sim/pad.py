"""The soft skin of a hand: contacts that give way by millimetres and stiffen, like rubber that is flattened."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from .contact import PairParameters

PAD_LOAD = 5.0
"""Load at which the give of a pad is stated [N]; chosen, about the force of a fingertip that is blocked."""

PAD_IMPEDANCE = (0.9, 0.99)
"""d in MuJoCo's solimp at first touch and at twice the give [-]; chosen. A pad then carries some twelve times its load
at twice the give, so that no push closes it, and friction yields no faster than that of a hard skin."""


@dataclass(frozen=True, slots=True)
class Pad:
    """The soft skin of one geom of a hand.

    Attributes:
        give: Depth of a contact under `PAD_LOAD` at rest [m].
        inverse_mass: Inverse of the mass with which the geom resists a push, as MuJoCo's `invweight0` has it [1/kg].
    """

    give: float
    inverse_mass: float


def soften(hard: PairParameters, pad: Pad, other_inverse_mass: float) -> PairParameters:
    """Return the contact of a pad with something hard.

    At rest MuJoCo's contact carries `F = k r (d / d_max)² / ((1 - d) (w + w'))` at the depth r. Here k is its
    stiffness, d its impedance at r, and w, w' the inverse masses of the two bodies. The impedance grows from the first
    value of `PAD_IMPEDANCE` to the second at twice the give, and is halfway at the give; k follows from `PAD_LOAD`. The
    damping is critical. Friction stays that of the hard contact.

    Args:
        hard: Contact without the pad.
        pad: Pad.
        other_inverse_mass: Inverse mass of what it touches [1/kg]; 0 for table and walls.
    """
    first, last = PAD_IMPEDANCE
    middle = 0.5 * (first + last)
    share = (middle / last) * (middle / last) / (1.0 - middle)
    stiffness = PAD_LOAD * (pad.inverse_mass + other_inverse_mass) / (pad.give * share)
    return replace(
        hard,
        solref=(-stiffness, -2.0 * math.sqrt(stiffness)),
        solimp=(first, last, 2.0 * pad.give, 0.5, 2.0),
        solreffriction=hard.solref,
    )
