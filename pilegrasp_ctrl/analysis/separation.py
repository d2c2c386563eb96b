"""Which object separates from the pile, known before the grasp begins."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .push_motion import PushMotion

AT_REST = 0.5
"""An object is stable in the hand below this share of |v_hand| relative to it: nearer to moving with the hand (0) than
to standing still while the hand slides beneath it (1)."""

INSIDE = 0.5
"""An object whose centre lies this share of its radius behind the leading edge is as good as enclosed."""

OUTSIDE = 1.5
"""What it lacks of that counts so many times as much as a distance from the middle."""

RECEDING = 0.5
"""Before a slanted wall a distance from the middle counts for this share more where the wall recedes, and less where it
is nearer."""


@dataclass(frozen=True, slots=True)
class Separation:
    """The object that the hand is about to keep.

    A rigid hand, which tilts back, keeps the one that it has caught deepest. A hand that closes keeps the one nearest
    to its middle: it is open at its sides, so that of two objects that came in side by side, the one nearer to the
    middle is enclosed and the other pushed out. One that the fingertips touch before the middle is scooped up when
    they curl; the farther before the edge it still lies, the likelier it rolls off. A wall that the hand meets at an
    angle holds what lies where it is nearer; where it recedes there is room to roll out. How much each of these counts
    was chosen by the outcome of grasps (docs/motion-pattern.md).

    Attributes:
        object: its name.
        time: since when it has been caught without a break [s]: with its centre behind the leading edge, or touched
            right before it.
        stabilised: since when it has kept still relative to the hand until the push ended [s]; None where it had not.
    """

    object: str
    time: float
    stabilised: float | None

    @classmethod
    def of(cls, push: PushMotion, caught: NDArray[np.bool_]) -> Separation | None:
        """Look at the frames of the push alone; None where the hand has caught nothing.

        Args:
            push: F frames of n objects.
            caught: (F, n) which of them are in the hand or at its edge.
        """
        if not caught[-1].any():
            return None
        ahead, y = np.moveaxis(push.relative[-1], -1, 0)
        aside = np.abs(y) - RECEDING * push.nearer_side * y
        distance = ahead if push.rigid else aside + OUTSIDE * np.maximum(ahead + INSIDE * push.radius, 0.0)
        chosen = int(np.argmin(np.where(caught[-1], distance, np.inf)))
        speed = np.linalg.norm(push.relative_velocity[:, chosen], axis=1)
        still = _since(speed < AT_REST * push.hand_speed)
        return cls(
            object=push.objects[chosen],
            time=float(push.time[_since(caught[:, chosen])]),
            stabilised=float(push.time[still]) if still < speed.size else None,
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as plain JSON values."""
        return {"object": self.object, "time": self.time, "stabilised": self.stabilised}


def _since(flags: np.ndarray) -> int:
    """Return the first index of the run of true values at the end; the length where the last is false."""
    false = np.flatnonzero(~flags)
    return int(false[-1]) + 1 if false.size else 0
