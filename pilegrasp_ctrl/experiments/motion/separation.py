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
    """The object that has come deepest into the hand by the end of the push.

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
        chosen = int(np.argmin(np.where(inside[-1], push.relative[-1, :, 0], np.inf)))
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
