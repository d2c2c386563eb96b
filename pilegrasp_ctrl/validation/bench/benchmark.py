"""What `pilegrasp bench` measures, all in one run: the control tick, its peers, the closed loop, and imports."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import Any

import numpy as np
import pinocchio as pin

from .clock import Work, garbage_kept, time_in_turns
from .imports import time_imports
from .loop import loop_rows, time_loop
from .machine import settings_of, versions
from .motion import ARMS, BenchArm, RecordedLine, record_line, tighten
from .peers import PEERS
from .result import BenchResult, Memory, Row, timed_row
from .targets import judge
from .ticks import StagedTick, allocations, impedance, operational_space

Progress = Callable[[float, str], None]

YARDSTICK = "yardstick"
COMPILED = "operational space, compiled"


@dataclass(frozen=True, slots=True)
class Size:
    """How much to measure.

    Attributes:
        blocks: rounds in which every tick has its turn.
        block_time: of each in a round [s].
        allocation_ticks: over how many ticks to watch the memory.
        import_rounds: interpreters started for each line, beside one that does not count.
        scenario: of the closed loop.
        seeds: of its attempts.
        overrides: dotted keys of that scenario.
        arms: names of the arms.
        quick: whether that is little.
    """

    blocks: int = 80
    block_time: float = 0.01
    allocation_ticks: int = 1000
    import_rounds: int = 6
    scenario: str = "spheres_wall"
    seeds: tuple[int, ...] = (0, 1, 2)
    overrides: Mapping[str, Any] = field(default_factory=dict)
    arms: tuple[str, ...] = ("wam7", "panda")
    quick: bool = False


FULL = Size()
QUICK = Size(blocks=12, block_time=0.005, import_rounds=1, seeds=(0,), quick=True)


def run_benchmark(size: Size = FULL, progress: Progress = lambda fraction, what: None) -> BenchResult:
    """Measure everything that `size` asks for.

    Args:
        size: how much.
        progress: called with the share that is done and what is being measured.

    Raises:
        PilegraspError: where the scenario or an arm cannot be used.
    """
    settings = settings_of(size.scenario, size.seeds, size.quick)
    arms = [arm for arm in ARMS if arm.name in size.arms]
    parts = _Parts(progress, len(arms) * (size.blocks + 10) + 50 * len(size.seeds) + 10 * (1 + size.import_rounds))
    rows: list[Row] = []
    memory: list[Memory] = []
    for arm in arms:
        arm_rows, arm_memory = _ticks(arm, size, parts)
        rows += arm_rows
        memory += arm_memory
    parts.say("closed loop")
    timings = {"": time_loop(size.scenario, size.seeds, size.overrides, lambda: parts.done(25))}
    if _can_compile():
        overrides = {**size.overrides, "controller.compiled": True}
        timings[", compiled"] = time_loop(size.scenario, size.seeds, overrides, lambda: parts.done(25))
    parts.say("imports")
    if size.import_rounds:
        imports = time_imports(size.import_rounds, lambda: parts.done(10))
        rows += _ratios((timed_row(key, "import", value) for key, value in imports.items()), "import numpy")
    loop = tuple(row for suffix, timing in timings.items() for row in loop_rows(timing, suffix))
    return BenchResult(
        settings=settings,
        versions=versions(),
        rows=tuple(rows),
        memory=tuple(memory),
        loop=loop,
        replay_exact=all(chunk.same for timing in timings.values() for chunk in timing.chunks),
        targets=judge(rows, loop),
    )


class _Parts:
    """Counts what is done for the progress bar."""

    def __init__(self, progress: Progress, total: int) -> None:
        self._progress, self._total, self._count, self._what = progress, total, 0, ""

    def say(self, what: str) -> None:
        self._what = what
        self.done(0)

    def done(self, count: int = 1) -> None:
        self._count += count
        self._progress(min(1.0, self._count / self._total), self._what)


def _ticks(source: BenchArm, size: Size, parts: _Parts) -> tuple[list[Row], list[Memory]]:
    name = source.name
    parts.say(f"{name}: recording a line")
    line = record_line(source, source.load())
    tight = record_line(source, tighten(line))
    staged = {solver: StagedTick(line, solver) for solver in ("daqp", "osqp")}
    limited = operational_space(tight)
    share = np.mean([bool(limited(index).active_limits) for index in range(len(tight.observations))])
    own: dict[str, tuple[Callable[[int], Any], str]] = {
        YARDSTICK: (_yardstick(line), "fixed work in Pinocchio and numpy, none of it the project's"),
        "operational space": (operational_space(line), "state to torque, every limit, friction feed-forward"),
        "operational space, limits active": (limited, f"speeds limited below the line's; they bind in {share:.0%}"),
        "operational space, osqp": (operational_space(line, "osqp"), "the same with the other solver"),
        "impedance": (impedance(line), "state to torque, every limit, friction feed-forward"),
    }
    if _can_compile():
        own[COMPILED] = operational_space(line, compiled=True), "the same in numba between Pinocchio and daqp"
    peers = {f"{name} {peer.key}": (peer.tick(line), peer.does) for peer in PEERS}
    works = [Work(f"{name} {key}", call) for key, (call, _) in own.items()]
    works += [tick.work(f"{name} stages {solver}") for solver, tick in staged.items()]
    works += [Work(key, call) for key, (call, _) in peers.items() if not isinstance(call, str)]
    parts.done(10)
    parts.say(f"{name}: ticks")

    def round_done() -> None:
        for tick in staged.values():
            tick.block_done()
        parts.done()

    with garbage_kept():
        timings = time_in_turns(works, size.blocks, size.block_time, round_done)
        memory = [
            Memory(key=f"{name} {key}", **allocations(own[key][0], size.allocation_ticks)._asdict())
            for key in ("operational space", "impedance")
        ]
    ticks = [timed_row(f"{name} {key}", "tick", timings[f"{name} {key}"], note) for key, (_, note) in own.items()]
    for key, (call, does) in peers.items():
        absent = isinstance(call, str)
        ticks.append(
            Row(key=key, table="peer", count=0, note=str(call))
            if absent
            else timed_row(key, "peer", timings[key], does)
        )
    rows = _ratios(ticks, f"{name} {YARDSTICK}", f"{name} operational space")
    return rows + _stage_rows(name, staged, ticks[0]), memory


def _can_compile() -> bool:
    return find_spec("numba") is not None


def _stage_rows(name: str, staged: Mapping[str, StagedTick], yardstick: Row) -> list[Row]:
    rows = [timed_row(f"{name} {stage}", "stage", timing) for stage, timing in staged["daqp"].timings().items()]
    rows.append(timed_row(f"{name} QP, osqp", "stage", staged["osqp"].timings()["QP"]))
    return [_with_ratio(row, yardstick) for row in rows]


def _ratios(rows: Iterable[Row], against: str, peers_against: str = "") -> list[Row]:
    """Return the rows with their ratios to the row called `against`; for peers to another."""
    rows = list(rows)
    named = {row.key: row for row in rows}
    return [_with_ratio(row, named[peers_against if row.table == "peer" else against]) for row in rows]


def _with_ratio(row: Row, other: Row) -> Row:
    if not row.count or row.key == other.key:
        return row
    # Both blocks of one round met the machine in the same mood.
    ratios = np.array(row.blocks_us) / np.array(other.blocks_us)
    low, middle, high = np.percentile(ratios, [10.0, 50.0, 90.0]).tolist()
    spread = 0.5 * (high - low) / middle
    return row.model_copy(update={"ratio": middle, "spread": spread, "against": other.key})


def _yardstick(line: RecordedLine) -> Callable[[int], object]:
    """Return work of a tick's kind and size that no change of the project makes faster or slower."""
    model = line.arm.pinocchio_model
    data, observations, count = model.createData(), line.observations, len(line.observations)
    matrix, out = np.eye(model.nv), np.empty(model.nv)

    def work(index: int) -> object:
        observation = observations[index % count]
        pin.computeAllTerms(model, data, observation.q, observation.v)
        vector = observation.v
        for _ in range(10):
            vector = matrix.dot(vector)
            np.add(vector, observation.q, out=out)
            vector = np.maximum(vector, out)
        return vector

    return work
