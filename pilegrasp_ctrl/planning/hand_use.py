"""The numbers of a hand that planning and primitives use: slope, forces, closing or scooping, and outline."""

from __future__ import annotations

from dataclasses import dataclass

from ..types import Array


@dataclass(frozen=True, slots=True, eq=False)
class HandUse:
    """Use of a hand.

    Attributes:
        theta: Slope of fingers or scoop against the table [rad].
        press_depth: Depth of the push's reference below touch-down [m].
        normal_force: Desired force on the support [N].
        preshape: Closure before the grasp, in [0, 1].
        closing_time: Time that the hand takes to close [s].
        advance: Longest distance that the reference advances along the push while the hand closes [m].
        scoop_angle: Angle by which the hand tilts back to grasp [rad]; zero for a hand that closes.
        heel: Distance from the leading edge to the heel [m].
        outline: (n, 4) balls that span sensor and hand at rest: centre in the tool frame, and radius [m].
        half_width: Half the width in which the hand meets objects [m].
        aim_half_width: Half the width in which objects count when push lines in a bin are compared [m].
        closes: Whether the hand closes on objects at the end of the push.
    """

    theta: float
    press_depth: float
    normal_force: float
    preshape: float
    closing_time: float
    advance: float
    scoop_angle: float
    heel: float
    outline: Array
    half_width: float
    aim_half_width: float
    closes: bool
