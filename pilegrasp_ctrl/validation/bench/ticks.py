"""The project's own control tick as pieces of work: state to torque, whole and in parts, and its memory."""

from __future__ import annotations

import sys
import tracemalloc
from collections.abc import Callable, Sequence
from time import perf_counter
from typing import NamedTuple

import numpy as np

from ...arm.state import ArmState
from ...control.impedance import ImpedanceController
from ...control.operational_space import OperationalSpaceController
from ...tasks.gains import Impedance
from ...tasks.task import Objective
from ...types import Array, ControllerOutput
from .clock import LEAD_IN, WARM_UP, Timing, Work
from .motion import RATE, RecordedLine

SPRINGS = Impedance(stiffness=[800.0, 800.0, 800.0, 30.0, 30.0, 30.0])
"""Impedance of the impedance tick [N/m, N·m/rad]; chosen near the shipped ones."""

FREE_LIST = 3000
"""Ticks before memory is watched [-]: the interpreter keeps up to 2000 small tuples of each size for later use."""

TICK_PARTS = ("arm.update", "tasks, friction, limits", "QP", "torque")
"""Parts of the operational-space tick, in their order."""


class Allocation(NamedTuple):
    """The memory of a tick, by tracemalloc, less the result of the same measurement of an empty function.

    Attributes:
        peak_bytes: Largest number of additional bytes held at any moment of a tick (median over ticks).
        kept_blocks: Number of Python objects that the answer of a tick keeps while it is held (median).
        kept_bytes: Size of these objects (median).
        growth_blocks: Number of additional Python objects after `ticks` further ticks whose answers were dropped.
        growth_bytes: Size of these objects.
        ticks: Number of these ticks.
    """

    peak_bytes: float
    kept_blocks: float
    kept_bytes: float
    growth_blocks: int
    growth_bytes: int
    ticks: int


def operational_space(line: RecordedLine, solver: str = "daqp") -> Callable[[int], ControllerOutput]:
    """Return the tick of `OperationalSpaceController` with every limit and friction feed-forward."""
    return _tick(line, _controller(line, solver))


def _controller(line: RecordedLine, solver: str) -> OperationalSpaceController:
    return OperationalSpaceController(line.arm, posture=line.source.posture, solver=solver, rate=RATE)


class PythonTask:
    """A task as a user writes it, in plain Python: one joint stays at rest, with a small weight."""

    def __init__(self, nv: int, joint: int = 2, damping: float = 20.0, weight: float = 1e-3) -> None:
        """Damp `joint` of an arm with `nv` joints [1/s]."""
        self._joint, self._damping, self._root = joint, damping, weight**0.5
        self._row = self._root * np.eye(nv)[[joint]]

    def rows(self, state: ArmState) -> Objective:
        """Return the one row at a state."""
        return Objective(self._row, np.array([-self._root * self._damping * state.v[self._joint]]))


def with_python_task(line: RecordedLine) -> Callable[[int], ControllerOutput]:
    """Return the tick of `OperationalSpaceController` with a `PythonTask` beside its own tasks."""
    task = PythonTask(line.arm.nv)
    return _tick(line, OperationalSpaceController(line.arm, posture=line.source.posture, tasks=[task], rate=RATE))


def impedance(line: RecordedLine) -> Callable[[int], ControllerOutput]:
    """Return the tick of `ImpedanceController` with every limit and friction feed-forward."""
    return _tick(line, ImpedanceController(line.arm, SPRINGS, line.source.posture, rate=RATE))


def _tick(
    line: RecordedLine, controller: OperationalSpaceController | ImpedanceController
) -> Callable[[int], ControllerOutput]:
    observations, references, count = line.observations, line.references, len(line.observations)

    def tick(index: int) -> ControllerOutput:
        index %= count
        return controller.step(observations[index], references[index])

    return tick


class TickParts:
    """The operational-space tick with a clock read between its parts.

    The same calls as in `OperationalSpaceController.step`, made one by one, so that the parts exceed the tick by the
    clock's own time only. "QP" is the `solve_time` of the controller: the solver, and the check of the
    bounds at its answer. "torque" is the rest of the last call.
    """

    def __init__(self, line: RecordedLine, solver: str = "daqp") -> None:
        """Set up the program as the controller does."""
        self._line, self._controller = line, _controller(line, solver)
        self._durations: list[tuple[float, ...]] = []
        self._skip = LEAD_IN + WARM_UP + LEAD_IN
        self._blocks: list[Array] = []

    def work(self, key: str) -> Work:
        """Return the tick as a piece of work; the times of its parts are kept aside."""
        return Work(key, self._tick)

    def _tick(self, index: int) -> None:
        line = self._line
        index %= len(line.observations)
        observation, reference = line.observations[index], line.references[index]
        controller = self._controller
        start = perf_counter()
        state = line.arm.update(observation.q, observation.v)
        updated = perf_counter()
        controller.tool.set_target(reference)
        assembly = controller.assemble(observation, state)
        assembled = perf_counter()
        output = controller.solve(assembly)
        end = perf_counter()
        solving = output.solve_time
        self._durations.append((updated - start, assembled - updated, solving, end - assembled - solving))

    def block_done(self) -> None:
        """Close a block; call this after each round."""
        self._blocks.append(np.array(self._durations[self._skip :]))
        self._durations, self._skip = [], LEAD_IN

    def timings(self) -> dict[str, Timing]:
        """Return the durations of each part."""
        return {name: Timing.of([block[:, column] for block in self._blocks]) for column, name in enumerate(TICK_PARTS)}


def allocations(tick: Callable[[int], object], ticks: int) -> Allocation:
    """Trace the memory of a tick in a separate pass, because tracing makes it several times slower.

    Args:
        tick: Tick to trace.
        ticks: Number of ticks over which growth is watched.
    """
    for index in range(FREE_LIST):
        tick(index)
    tracemalloc.start()
    try:
        nothing, answer = _trace(lambda index: None, ticks), _trace(tick, ticks)
    finally:
        tracemalloc.stop()
    peak, kept_blocks, kept, grown_blocks, grown = (own - idle for own, idle in zip(answer, nothing, strict=True))
    return Allocation(peak, kept_blocks, kept, int(grown_blocks), int(grown), ticks)


def _trace(tick: Callable[[int], object], ticks: int) -> list[float]:
    """Return the numbers of an `Allocation` except the last."""
    samples = [_one(tick, index) for index in range(min(ticks, 50))]
    blocks, size = sys.getallocatedblocks(), tracemalloc.get_traced_memory()[0]
    for index in range(ticks):
        tick(index)
    grown_size, grown_blocks = tracemalloc.get_traced_memory()[0] - size, sys.getallocatedblocks() - blocks
    return [*np.median(samples, axis=0).tolist(), grown_blocks, grown_size]


def _one(tick: Callable[[int], object], index: int) -> Sequence[float]:
    """Return peak bytes, blocks kept and bytes kept of one tick whose answer is held."""
    tracemalloc.reset_peak()
    before, blocks = tracemalloc.get_traced_memory()[0], sys.getallocatedblocks()
    answer = tick(index)
    after, peak = tracemalloc.get_traced_memory()
    kept = sys.getallocatedblocks() - blocks
    del answer
    return peak - before, kept, after - before
