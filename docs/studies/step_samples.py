"""What each physics step of a run cost, and how far it was from the exact solution."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from pilegrasp_ctrl.types import Array


@dataclass(frozen=True, slots=True, eq=False)
class StepSamples:
    """One value for each of n steps.

    Attributes:
        time: (n,) at the end of the step [s].
        seconds: (n,) that the step took on the wall clock [s].
        contacts: (n,) number of contacts.
        iterations: (n,) of the solver, in the one of the first 20 islands (MuJoCo counts no others) that took most.
        finger_error: (n,) of the hand's joint speed that is farthest from the exact solution [rad/s].
        object_error: (n,) of the velocity of the object that is farthest from it [m/s].
    """

    time: Array
    seconds: Array
    contacts: Array
    iterations: Array
    finger_error: Array
    object_error: Array

    def after(self, begin: float, end: float = np.inf) -> StepSamples:
        """Return the steps that began at `begin` or later and ended by `end` [s]."""
        wanted = (self.time > begin + 1e-9) & (self.time <= end + 1e-9)
        return StepSamples(*(getattr(self, field.name)[wanted] for field in fields(self)))

    @classmethod
    def joined(cls, parts: list[StepSamples]) -> StepSamples:
        """Return the steps of several runs as one."""
        return cls(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(cls)))
