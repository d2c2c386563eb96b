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

CENTRAL = 1.0 / 3.0
"""A wedged object stays before the hand's middle where its centre is off by less than this share of its radius; farther
aside, what lies nearer to the middle inside stays instead (docs/motion-pattern.md)."""


@dataclass(frozen=True, slots=True)
class Separation:
    """The object that the hand is about to keep.

    A rigid hand, which tilts back, keeps the one that it has caught deepest. A hand that closes keeps the one nearest
    to its middle, and first of all one that it has wedged against a wall right before its middle.

    Such a hand is open at its sides and closes on its middle: of two objects that came in side by side, the one nearer
    to the middle is enclosed and the other pushed out. One right before the middle that a wall stops cannot give way
    when the fingertips curl beneath it, so it comes in over them and takes the place of what was there. One that only
    other objects stop stays out, because those give way.

    Attributes:
        object: its name.
        time: since when it has been caught without a break [s]: wedged, or with its centre behind the leading edge.
        stabilised: since when it has kept still relative to the hand until the push ended [s]; None where it had not.
    """

    object: str
    time: float
    stabilised: float | None

    @classmethod
    def of(cls, push: PushMotion, wedged: NDArray[np.bool_]) -> Separation | None:
        """Look at the frames of the push alone; None where the hand has caught nothing.

        Args:
            push: F frames of n objects.
            wedged: (F, n) which of them are pushed against a support, see `wedged`.
        """
        caught = push.in_hand | wedged
        if not caught[-1].any():
            return None
        ahead, aside = push.relative[-1, :, 0], np.abs(push.relative[-1, :, 1])
        central = wedged[-1] & (aside <= CENTRAL * push.radius) & (not push.rigid)
        among = central if central.any() else caught[-1]
        chosen = int(np.argmin(np.where(among, ahead if push.rigid else aside, np.inf)))
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
