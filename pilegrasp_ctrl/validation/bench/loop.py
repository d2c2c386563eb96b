"""The closed loop of an attempt, compared with bare physics of the same scene along the same trajectory."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from time import perf_counter, thread_time
from typing import Any, NamedTuple

import mujoco
import numpy as np

from ...config import load_scenario
from ...episode import run_attempt
from ...programs.attempt import Attempt, prepare
from ...sim.stepper import Stepper
from ...types import Array
from .result import LoopRow

CHUNK = 50
"""Control periods between two replays [-]; chosen."""


class Chunk(NamedTuple):
    """`CHUNK` control periods of the loop, and the same physics steps alone.

    Attributes:
        start: Simulated time at the start [s].
        loop: Processor time of the loop [s].
        bare: Processor time of the engine's steps alone, when the same commands are replayed from the same state [s].
        control: Time from an observation to its command: the arm's state, the primitive and the controller; the median
            of the chunk [s].
        same: Whether the replay ended in exactly the same state.
    """

    start: float
    loop: float
    bare: float
    control: float
    same: bool


class LoopMeter:
    """An observer of the loop that times it, and replays every chunk of commands without the loop.

    The replay starts from the state at the chunk's start and has its own data, so it does not disturb the loop. The
    time of the replay and of the bookkeeping is not counted. Loop and replay are timed by the processor time of the
    thread, in which other programs do not count.
    """

    def __init__(self, attempt: Attempt) -> None:
        """Begin at the present state of a prepared attempt."""
        self._data, self._model = attempt.simulation.data, attempt.simulation.scene.model
        self._steps = round(attempt.period / self._model.opt.timestep)
        self._twin, self._stepper = mujoco.MjData(self._model), attempt.simulation.stepper
        # The replay computes suspicious contacts again, as the loop does.
        self._twin_stepper = Stepper(self._model, self._twin)
        self._signature = mujoco.mjtState.mjSTATE_INTEGRATION
        self._state, self._after = (np.empty(mujoco.mj_stateSize(self._model, self._signature)) for _ in range(2))
        self.chunks: list[Chunk] = []
        self._commands: list[Array] = []
        self._controls: list[float] = []
        self._observed = perf_counter()
        self._open()

    def __call__(self, part: str) -> None:
        """Note a finished part of a control period."""
        if part == "observe":
            self._observed = perf_counter()
        elif part == "control":
            self._controls.append(perf_counter() - self._observed)
        elif part == "step":
            start = thread_time()
            self._commands.append(self._data.ctrl.copy())
            self._bookkeeping += thread_time() - start
        elif part == "check" and len(self._commands) == CHUNK:
            self._close()

    def _open(self) -> None:
        mujoco.mj_getState(self._model, self._data, self._state, self._signature)
        self._start, self._bookkeeping = float(self._data.time), 0.0
        self._twin_stepper.depth = self._stepper.depth
        self._commands.clear()
        self._controls.clear()
        self._begun = thread_time()

    def _close(self) -> None:
        loop = thread_time() - self._begun - self._bookkeeping
        control = float(np.median(self._controls))
        bare, same = self._replay()
        self.chunks.append(Chunk(self._start, loop, bare, control, same))
        self._open()

    def _replay(self) -> tuple[float, bool]:
        """Return the processor time of the engine's steps, and whether they end in the state of the loop."""
        model, twin, step, steps = self._model, self._twin, self._twin_stepper.step, range(self._steps)
        mujoco.mj_setState(model, twin, self._state, self._signature)
        begun = thread_time()
        for command in self._commands:
            twin.ctrl[:] = command
            for _ in steps:
                step()
        bare = thread_time() - begun
        mujoco.mj_getState(model, self._data, self._state, self._signature)
        mujoco.mj_getState(model, twin, self._after, self._signature)
        return bare, bool(np.array_equal(self._state, self._after))


class LoopTiming(NamedTuple):
    """The timed loops of all attempts.

    Attributes:
        scenario: Name of the scenario.
        period: Control period [s].
        chunks: Chunks of all attempts, in order.
        push: Whether each chunk lies within the push.
    """

    scenario: str
    period: float
    chunks: tuple[Chunk, ...]
    push: tuple[bool, ...]


def time_loop(
    scenario: str,
    seeds: Sequence[int],
    overrides: Mapping[str, Any] | None = None,
    done: Callable[[], None] = lambda: None,
) -> LoopTiming:
    """Run one attempt for each seed.

    Args:
        scenario: Name of a scenario.
        seeds: Seeds of piles and sensor noise.
        overrides: Dotted keys and values.
        done: Function that is called after each attempt.

    Raises:
        PilegraspError: The scenario cannot be run.
    """
    chosen = load_scenario(scenario, overrides)
    chunks: list[Chunk] = []
    push: list[bool] = []
    period = np.nan
    for seed in seeds:
        attempt = prepare(chosen, seed)
        meter, period = LoopMeter(attempt), attempt.period
        result = run_attempt(attempt, on_part=meter)
        pushes = [(outcome.start, outcome.end) for outcome in result.outcomes if outcome.name == "push"]
        length = CHUNK * period
        for chunk in meter.chunks:
            chunks.append(chunk)
            push.append(any(start <= chunk.start and chunk.start + length <= end for start, end in pushes))
        done()
    return LoopTiming(scenario, period, tuple(chunks), tuple(push))


def loop_rows(timing: LoopTiming, suffix: str = "") -> tuple[LoopRow, ...]:
    """Return the statistics of the push, if the attempts have one, and of whole attempts.

    Args:
        timing: Timing of the attempts.
        suffix: Text that is appended to the names of both.
    """
    phases = {
        "push": [index for index, inside in enumerate(timing.push) if inside],
        "attempt": list(range(len(timing.chunks))),
    }
    return tuple(_loop_row(phase + suffix, timing, indices) for phase, indices in phases.items() if indices)


def _loop_row(phase: str, timing: LoopTiming, indices: list[int]) -> LoopRow:
    chunks = [timing.chunks[index] for index in indices]
    seconds = np.array([(chunk.loop, chunk.bare, CHUNK * chunk.control) for chunk in chunks])
    low, ratio, high = np.percentile(seconds[:, 0] / seconds[:, 1], [10.0, 50.0, 90.0]).tolist()
    period, bare, control = (1e6 / CHUNK * np.median(seconds, axis=0)).tolist()
    return LoopRow(
        phase=phase,
        chunks=len(chunks),
        ratio=ratio,
        ratio_p10=low,
        ratio_p90=high,
        period_us=period,
        bare_us=bare,
        control_us=control,
        glue_us=period - bare - control,
        realtime_factor=len(chunks) * CHUNK * timing.period / float(seconds[:, 0].sum()),
    )
