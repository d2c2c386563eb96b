"""Events besides F_grasp that end a push: a small registry, to which a further event is added as a class."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from .primitive import Ending, PrimitiveInput

TOUCHES = 2
"""Number of objects that must touch the fingers [-]; a sensorized hand could then have closed (V-E)."""

TOUCH_TIME = 0.1
"""Time for which they must touch [s]; chosen, so that a bounce is no touch."""

BREAK = 0.02
"""Longest break of a touch behind the fingertips that does not end it [s]; chosen.

A ball that rolls along a finger loses contact for single physics steps."""


class PushEnding(Protocol):
    """An event that ends a push."""

    def begin(self) -> ActivePushEnding:
        """Begin to watch, at the start of a push."""


class ActivePushEnding(Protocol):
    """An event that is watched."""

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """Return how the push ends, or None while it goes on. The push calls this once per control period."""


@dataclass(frozen=True, slots=True)
class TouchEnding:
    """Some objects have touched the fingers for a while.

    Attributes:
        count: Number of objects.
        inside: Whether only touches behind the fingertips count.
        pause: Longest break of the touch [s].
        duration: Time [s].
    """

    count: int = TOUCHES
    inside: bool = False
    pause: float = 0.0
    duration: float = TOUCH_TIME

    def begin(self) -> ActiveTouchEnding:
        """Begin without a touch."""
        return ActiveTouchEnding(self)

    @property
    def words(self) -> str:
        """Trigger of the push."""
        who = "an object" if self.count == 1 else f"{self.count} objects"
        return f"{who} touched {'a finger behind its tip' if self.inside else 'the fingers'}"


@dataclass(slots=True, eq=False)
class ActiveTouchEnding:
    """A `TouchEnding` that is watched. It remembers since when, and until when, there were enough touches."""

    plan: TouchEnding
    _since: float | None = None
    _last: float = 0.0

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End when there have been enough touches for long enough."""
        plan = self.plan
        if (inputs.inside if plan.inside else inputs.touched) >= plan.count:
            self._since = inputs.time if self._since is None else self._since
            self._last = inputs.time
        elif inputs.time - self._last > plan.pause:
            self._since = None
        if self._since is None or self._last - self._since < plan.duration:
            return None
        return Ending(plan.words)


PUSH_ENDINGS: dict[str, tuple[PushEnding, ...]] = {
    "force": (),
    "touches": (TouchEnding(),),
    "inside": (TouchEnding(1, inside=True, pause=BREAK),),
}
"""Events by the value of `strategy.close_on`. F_grasp ends every push."""
