"""Notices a controller that has had no authority left for long."""

from __future__ import annotations

from ..types import ControllerOutput

SATURATION_TIME = 1.0
"""A torque may sit at its limit for this long, and a solver may fail for this long [s]."""


class SaturationMonitor:
    """Counts for how long each torque limit has been active without a break.

    A limit that binds for a moment is what limits are for. One that binds for a second means that the arm does not do
    what it is asked to, and will not.

    Attributes:
        time: that is too long [s].
    """

    def __init__(self, period: float, time: float = SATURATION_TIME) -> None:
        """Take the control period [s]."""
        self.time, self._period = time, period
        self._since: dict[str, float] = {}

    def update(self, output: ControllerOutput) -> str:
        """Return what has lasted for too long, after one more control period, or ""."""
        if not output.active_limits and not output.fallback:
            self._since.clear()
            return ""
        names = [name for name in output.active_limits if name.startswith(("torque", "motor"))]
        if output.fallback:
            names.append("solver")
        self._since = {name: self._since.get(name, 0.0) + self._period for name in names}
        for name, lasted in self._since.items():
            if lasted > self.time:
                return f"{output.fallback if name == 'solver' else f'{name} limit'} for {self.time:g} s"
        return ""
