"""Which object separates from the pile, known before the grasp begins."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .push_motion import PushMotion

AT_REST = 0.5
"""An object is stable in the hand below this share of |v_hand| relative to it: nearer to moving with the hand (0) than
to standing still while the hand slides beneath it (1)."""


@dataclass(frozen=True, slots=True)
class Separation:
    """Of the objects in the hand at the end of the push, the one that has been farthest inside for longest.

    How far an object is inside is the way from its centre to the nearest border over which it could leave: the leading
    edge, or one of the hand's two sides. The largest integral of that way over the push decides, because an object is
    as easily lost at a side as at the edge, and one that has only just come in may still roll out.

    Attributes:
        object: its name.
        time: since when its centre has been behind the leading edge without a break [s].
        stabilised: since when it has kept still relative to the hand until the push ended [s]; None where it had not.
    """

    object: str
    time: float
    stabilised: float | None

    @classmethod
    def of(cls, push: PushMotion) -> Separation | None:
        """Look at the frames of the push alone; None where no object has come into the hand."""
        inside = push.in_hand
        if not inside[-1].any():
            return None
        x, y = np.moveaxis(push.relative, -1, 0)
        depth = np.where(inside, np.minimum(-x, push.half_width - np.abs(y)), 0.0)
        chosen = int(np.argmax(np.where(inside[-1], np.trapezoid(depth, push.time, axis=0), -1.0)))
        speed = np.linalg.norm(push.relative_velocity[:, chosen], axis=1)
        still = _since(speed < AT_REST * push.hand_speed)
        return cls(
            object=push.objects[chosen],
            time=float(push.time[_since(inside[:, chosen])]),
            stabilised=float(push.time[still]) if still < speed.size else None,
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as plain JSON values."""
        return {"object": self.object, "time": self.time, "stabilised": self.stabilised}


def _since(flags: np.ndarray) -> int:
    """Return the first index of the run of true values at the end; the length where the last is false."""
    false = np.flatnonzero(~flags)
    return int(false[-1]) + 1 if false.size else 0
