"""Events besides F_grasp that end a push: a small registry, to which a further event is added as a class."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from .primitive import Ending, PrimitiveInput

TOUCHES = 2
"""Number of objects that must touch the fingers [-]; a sensorized hand could then have closed (V-E)."""

TOUCH_TIME = 0.1
"""Time for which they must touch [s]; chosen, so that a bounce is no touch."""


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
        duration: Time [s].
    """

    count: int = TOUCHES
    duration: float = TOUCH_TIME

    def begin(self) -> ActiveTouchEnding:
        """Begin without a touch."""
        return ActiveTouchEnding(self)


@dataclass(slots=True, eq=False)
class ActiveTouchEnding:
    """A `TouchEnding` that is watched. It remembers since when there are enough touches."""

    plan: TouchEnding
    _since: float | None = None

    def ending(self, inputs: PrimitiveInput) -> Ending | None:
        """End when there have been enough touches without a break."""
        if inputs.touched < self.plan.count:
            self._since = None
        elif self._since is None:
            self._since = inputs.time
        if self._since is None or inputs.time - self._since < self.plan.duration:
            return None
        return Ending(f"{self.plan.count} objects touched the fingers")


PUSH_ENDINGS: dict[str, tuple[PushEnding, ...]] = {"force": (), "touches": (TouchEnding(),)}
"""Events by the value of `strategy.close_on`. F_grasp ends every push."""
