"""What a task is: rows that ask for joint accelerations, in least squares."""

from __future__ import annotations

from typing import NamedTuple, Protocol, runtime_checkable

from ..arm.state import ArmState
from ..types import Array


class Objective(NamedTuple):
    """The wish A a = b for the joint accelerations a [rad/s²], in least squares: the cost |A a - b|².

    A task's weight enters its rows as a square root. A task gives rows rather than H = Aᵀ A. All tasks then share one
    product, and a weight stays visible.

    Attributes:
        A: (m, nv) Rows.
        b: (m,) Values that the rows should have.
    """

    A: Array
    b: Array


@runtime_checkable
class Task(Protocol):
    """A wish of a controller. Any object with this method may stand in a controller's list of tasks.

    A task may offer more. Its methods are called after `rows` in the same control period.

    - `regular`, an attribute, is True if its rows leave no motion of the joints free.
    - `velocity(error_rate)` returns (m,) the values that its weighted rows should have for the joint velocities. They
      are the reference's velocity plus `error_rate` [1/s] times the error. The friction feed-forward uses it.
    - `torque(state)` returns (nv,) a torque to add to that of the accelerations [N·m], or None.
    - `check(rate)` raises a `ConfigurationError` if its gains cannot be held at a control rate [Hz]. A controller
      calls it when it is made, and when the attribute `gains` of the task has changed.
    """

    def rows(self, state: ArmState) -> Objective:
        """Return the rows at a state."""
