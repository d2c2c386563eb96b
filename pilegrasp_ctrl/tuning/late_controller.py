"""A controller whose torques arrive late, as over a bus or after a slow sensor."""

from __future__ import annotations

from collections import deque

from ..plant.tracking import Controller
from ..types import ControllerOutput, Observation, Reference


class LateController:
    """Gives the answer to the observation of some control periods ago; until there is one, the first.

    It remembers answers, so that one instance serves one run.
    """

    def __init__(self, controller: Controller, periods: int) -> None:
        """Take a controller and by how many periods it is late."""
        self._controller = controller
        self._waiting: deque[ControllerOutput] = deque(maxlen=periods + 1)

    def step(self, observation: Observation, reference: Reference, /) -> ControllerOutput:
        """Return the torques for one control period."""
        self._waiting.append(self._controller.step(observation, reference))
        return self._waiting[0]
