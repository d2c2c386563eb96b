"""A motion controller together with the observer whose estimate it cancels."""

from __future__ import annotations

from ..types import ControllerOutput, Observation, Reference
from .disturbance_observer import DisturbanceObserver
from .operational_space import OperationalSpaceController


class ObservedController:
    """Asks the observer, hands its estimate to the controller, and remembers the torque for the next period.

    One instance serves one run.
    """

    def __init__(self, controller: OperationalSpaceController, observer: DisturbanceObserver) -> None:
        """Take a controller and an observer of the same arm."""
        self._controller, self._observer = controller, observer
        self._torque = observer.estimate

    def step(self, observation: Observation, reference: Reference, /) -> ControllerOutput:
        """Return the torques for one control period."""
        estimate = self._observer.update(observation, self._torque)
        output = self._controller.step(observation, reference, disturbance=estimate)
        self._torque = output.command.torque
        return output
