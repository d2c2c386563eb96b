"""Monitor of torque limits that bind, and of a solver that fails, for too long."""

from __future__ import annotations

from ..types import ControllerOutput

SATURATION_TIME = 1.0
"""Longest time for which a torque limit may bind, or a solver may fail, without a break [s]; chosen."""


class SaturationMonitor:
    """Counts the time for which each torque limit has been active without a break.

    Limits may bind for a moment. If a limit binds for a second, the arm cannot make the motion that its reference asks
    for.

    Attributes:
        time: Longest time for which a limit may be active without a break [s].
    """

    def __init__(self, period: float, time: float = SATURATION_TIME) -> None:
        """Start with no active limit; `period` is the control period [s]."""
        self.time, self._period = time, period
        self._since: dict[str, float] = {}

    def update(self, output: ControllerOutput) -> str | None:
        """Count one control period; return the limit or failure that has lasted for too long, or None."""
        if not output.active_limits and not output.fallback:
            self._since.clear()
            return None
        names = [name for name in output.active_limits if name.startswith(("torque", "motor"))]
        if output.fallback:
            names.append("solver")
        self._since = {name: self._since.get(name, 0.0) + self._period for name in names}
        for name, lasted in self._since.items():
            if lasted > self.time:
                return f"{output.fallback if name == 'solver' else f'{name} limit'} for {self.time:g} s"
        return None
