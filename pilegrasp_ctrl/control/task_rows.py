"""The rows of all tasks of a controller, gathered for one period."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arm.fitting import check_same_arm
from ..arm.model import ArmModel
from ..arm.state import ArmState
from ..exceptions import ConfigurationError
from ..kernels.algebra import add_multiplied_transposed
from ..tasks.task import Objective, Task
from ..types import Array


class CheckedTasks:
    """The tasks of a controller, whose gains are checked against its rate when it is made and when they change."""

    def __init__(self, tasks: Sequence[Task], arm: ArmModel, rate: float) -> None:
        """Check the tasks of an arm under control at `rate` [Hz].

        Raises:
            ConfigurationError: An object is no task or one of another arm, there is none, or gains diverge.
        """
        for task in tasks:
            if isinstance(task, type) or not callable(getattr(task, "rows", None)):
                raise ConfigurationError(f"{task!r:.80} is no task; a task has the method rows(state) -> Objective")
            check_same_arm(task, arm)
        if not tasks:
            raise ConfigurationError("a controller needs a task, such as FrameTask(arm) or PostureTask(arm, q)")
        self.tasks = tuple(tasks)
        self._rate = rate
        self._seen: list[Any] = [_UNSEEN] * len(self.tasks)
        self._watched: Sequence[tuple[int, Any]] = tuple(enumerate(self.tasks))
        self._check_gains()
        self._watched = tuple((index, task) for index, task in self._watched if hasattr(task, "gains"))

    def checked(self) -> tuple[Any, ...]:
        """Return the tasks, after a check of gains that have changed."""
        self._check_gains()
        return self.tasks

    def _check_gains(self) -> None:
        for index, task in self._watched:
            gains = getattr(task, "gains", None)
            if self._seen[index] is not gains:
                check = getattr(task, "check", None)
                if check is not None:
                    check(self._rate)
                self._seen[index] = gains

    def rows(self, state: ArmState) -> list[Objective]:
        """Return the rows of each task.

        Raises:
            ConfigurationError: A shape is wrong, or gains that have changed diverge.
        """
        return [self.rows_of(task, state) for task in self.checked()]

    def rows_of(self, task: Task, state: ArmState) -> Objective:
        """Return the rows of one task."""
        return checked(task.rows(state), task, state.arm.nv)

    def velocity_of(self, task: Task, b: Array, error_rate: float) -> Array:
        """Return (m,) the velocity that a task asks of its rows, of which it has as many as `b`; see `Task`."""
        velocity = getattr(task, "velocity", None)
        found: Array = np.zeros(len(b)) if velocity is None else velocity(error_rate)
        return found

    def velocities(self, rows: Sequence[Objective], error_rate: float) -> list[Array]:
        """Return (m,) the velocity that each task asks of its rows; zeros where it does not say. See `Task`."""
        return [self.velocity_of(task, b, error_rate) for task, (_, b) in zip(self.tasks, rows, strict=True)]

    def velocity(self, rows: Sequence[Objective], error_rate: float) -> Array:
        """Return (nv,) the sum of Aᵀ u, u the velocity that each task asks of its rows."""
        total = np.zeros(rows[0].A.shape[1])
        for objective, velocity in zip(rows, self.velocities(rows, error_rate), strict=True):
            add_multiplied_transposed(objective.A, velocity, total)
        return total

    def torque(self, state: ArmState) -> Array | None:
        """Return (nv,) the torques that tasks add to that of the accelerations [N·m], None where none does."""
        total: Array | None = None
        for task in self.tasks:
            torque = getattr(task, "torque", None)
            more = None if torque is None else torque(state)
            if more is not None:
                total = more if total is None else total + more
        return total


_UNSEEN = object()


def checked(objective: Objective, task: Task, n: int) -> Objective:
    """Return the rows of a task as arrays of floats.

    Raises:
        ConfigurationError: A shape is wrong.
    """
    try:
        A, b = objective
        A, b = np.asarray(A, dtype=np.float64), np.asarray(b, dtype=np.float64)
        good = A.ndim == 2 and A.shape[1] == n and b.shape == A.shape[:1]
    except (TypeError, ValueError):
        good = False
    if not good:
        raise ConfigurationError(f"{type(task).__name__}.rows must return Objective(A (m, {n}), b (m,)) for {n} joints")
    return Objective(A, b)
