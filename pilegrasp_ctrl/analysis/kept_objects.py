"""The objects that the hand keeps: the one that separates from the pile in the push, and those held at the end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..recording import Recording
from ..types import Array
from .push_motion import PushMotion
from .reading import signal_at, strategy_number

HELD_DISTANCE = 0.20
"""Largest distance of a held object's centre from the tool frame's origin [m]; the hand is 0.18 m long."""

RISEN_SHARE = 0.5
"""Share of the lift by which an object must have risen to count as held [-]; chosen."""

DEFAULT_LIFT = 0.2
"""Height of the lift if the recording does not state it [m]: the default of `strategy.lift_height`."""

AT_REST_SHARE = 0.5
"""Share of |v_hand| below which an object's relative speed counts as stable in the hand [-]; chosen. At 0 the object
moves with the hand; at 1 it rests while the hand slides beneath it."""

ENCLOSED_SHARE = 0.5
"""Share of its radius by which an enclosed object's centre is behind the leading edge [-]; chosen."""

AHEAD_WEIGHT = 1.5
"""Weight of an object's distance to being enclosed, compared with its distance from the hand's middle [-]; chosen by
the outcome of grasps (docs/motion-pattern.md)."""

RECEDING_SHARE = 0.5
"""Share by which a distance from the middle counts more on the receding side of a slanted wall, and less on the other
side [-]. Chosen by the outcome of grasps (docs/motion-pattern.md)."""

NOTHING_HELD = "nothing was in the hand after the lift"
"""Reason of an attempt that holds no object after the lift."""


def are_held(position: Array, tool_position: Array, rest_height: Array, lift: float) -> NDArray[np.bool_]:
    """Return which of n objects hang in the hand (n,). This rule decides "held"; the strategy does not use it.

    Args:
        position: (n, 3) centres of the objects after the lift and the hold [m].
        tool_position: (3,) origin of the tool frame [m].
        rest_height: (n,) heights of the object centres before the attempt [m].
        lift: Height of the lift [m].
    """
    risen = position[:, 2] > rest_height + RISEN_SHARE * lift
    near = np.linalg.norm(position - tool_position, axis=1) < HELD_DISTANCE
    return np.asarray(risen & near)


def held_names(recording: Recording) -> list[str]:
    """Return the names of the objects in the hand at the end, by the rule that judges an attempt."""
    chosen = [index for index, body in enumerate(recording.bodies) if body.role == "object"]
    tool = signal_at(recording, "tool_position", recording.frame_time[-1:])
    if not chosen or not recording.meta.get("grasped") or tool is None:
        return []
    lift = strategy_number(recording, "lift_height", DEFAULT_LIFT)
    place = recording.body_position[:, chosen].astype(float)
    held = are_held(place[-1], tool[0], place[0, :, 2], lift)
    return [recording.bodies[chosen[index]].name for index in np.flatnonzero(held)]


@dataclass(frozen=True, slots=True)
class Separation:
    """The object that the hand is about to keep.

    A rigid hand tilts back and keeps the object that it has caught deepest. A hand that closes keeps the object nearest
    to its middle. Such a hand is open at its sides: of two objects side by side, it encloses the one nearer to the
    middle and pushes the other out. The fingertips scoop up an object that they touch ahead of the middle. The farther
    it is ahead of the edge, the likelier it rolls off. A slanted wall holds an object on its nearer side; on the other
    side an object can roll out. The weights of these effects were chosen by the outcome of grasps
    (docs/motion-pattern.md).

    Attributes:
        object: Name of the object.
        time: Start of the time in which it was caught without a break until the push ended [s]. A caught object is
            behind the leading edge, or the hand touches it right ahead of the edge.
        stabilised: Start of the time in which it did not move relative to the hand until the push ended [s]; None if
            it moved.
    """

    object: str
    time: float
    stabilised: float | None

    @classmethod
    def of(cls, push: PushMotion, caught: NDArray[np.bool_]) -> Separation | None:
        """Return the object that separated, from the frames of the push alone; None if the hand caught nothing.

        Args:
            push: Motion in F frames of n objects.
            caught: (F, n) flags of the objects in the hand or at its edge.
        """
        if not caught[-1].any():
            return None
        ahead, y = np.moveaxis(push.relative[-1], -1, 0)
        aside = np.abs(y) - RECEDING_SHARE * push.nearer_side * y
        missing = np.maximum(ahead + ENCLOSED_SHARE * push.radius, 0.0)
        distance = ahead if push.rigid else aside + AHEAD_WEIGHT * missing
        chosen = int(np.argmin(np.where(caught[-1], distance, np.inf)))
        speed = np.linalg.norm(push.relative_velocity[:, chosen], axis=1)
        still = _start_of_last_run(speed < AT_REST_SHARE * push.hand_speed)
        return cls(
            object=push.objects[chosen],
            time=float(push.time[_start_of_last_run(caught[:, chosen])]),
            stabilised=float(push.time[still]) if still < speed.size else None,
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the fields as plain JSON values."""
        return {"object": self.object, "time": self.time, "stabilised": self.stabilised}


def _start_of_last_run(flags: np.ndarray) -> int:
    """Return the first index of the run of true values at the end; the length if the last value is false."""
    false = np.flatnonzero(~flags)
    return int(false[-1]) + 1 if false.size else 0
