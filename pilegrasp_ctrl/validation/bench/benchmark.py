"""The run of `pilegrasp bench`: the control tick, its peers, the closed loop, and imports."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin

from .clock import Work, garbage_kept, time_imports, time_in_turns
from .judgement import judge
from .loop import loop_rows, time_loop
from .motion import ARMS, BenchArm, RecordedLine, record_line, tighten
from .peers import PEERS
from .result import BenchResult, Memory, Row, installed_versions, settings_of, timed_row
from .ticks import TickParts, allocations, impedance, operational_space, with_python_task

Progress = Callable[[float, str], None]
"""Callback that gets the finished share and the name of the running measurement."""

YARDSTICK = "yardstick"
"""Key of the fixed work to which the project's own ticks are compared."""


@dataclass(frozen=True, slots=True)
class Size:
    """The size of a benchmark run.

    Attributes:
        blocks: Number of rounds; every tick runs once in each.
        block_time: Time of each tick in a round [s].
        allocation_ticks: Number of ticks over which memory is watched.
        import_rounds: Number of interpreters started for each line, beside a first one that does not count.
        scenario: Scenario of the closed loop.
        seeds: Seeds of its attempts.
        overrides: Dotted keys of that scenario.
        arms: Names of the arms.
        quick: Whether these are few samples.
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
"""Size of `pilegrasp bench`, which takes about a minute; chosen."""

QUICK = Size(blocks=12, block_time=0.005, import_rounds=1, seeds=(0,), quick=True)
"""Size of `pilegrasp bench --quick`, which takes about 12 s; chosen."""


def run_benchmark(size: Size = FULL, progress: Progress = lambda fraction, what: None) -> BenchResult:
    """Measure everything that `size` asks for.

    Args:
        size: Size of the run.
        progress: Callback that gets the finished share and the name of the running measurement.

    Raises:
        PilegraspError: The scenario or an arm cannot be used.
    """
    settings = settings_of(size.scenario, size.seeds, size.quick)
    arms = [arm for arm in ARMS if arm.name in size.arms]
    work = _WorkDone(progress, len(arms) * (size.blocks + 10) + 25 * len(size.seeds) + 10 * (1 + size.import_rounds))
    rows: list[Row] = []
    memory: list[Memory] = []
    for arm in arms:
        arm_rows, arm_memory = _ticks(arm, size, work)
        rows += arm_rows
        memory += arm_memory
    work.say("closed loop")
    timing = time_loop(size.scenario, size.seeds, size.overrides, lambda: work.done(25))
    work.say("imports")
    if size.import_rounds:
        imports = time_imports(size.import_rounds, lambda: work.done(10))
        rows += _ratios((timed_row(key, "import", value) for key, value in imports.items()), "import numpy")
    loop = tuple(loop_rows(timing))
    return BenchResult(
        settings=settings,
        versions=installed_versions(),
        rows=tuple(rows),
        memory=tuple(memory),
        loop=loop,
        replay_exact=all(chunk.same for chunk in timing.chunks),
        targets=judge(rows, loop),
    )


class _WorkDone:
    """A counter of finished work for the progress bar."""

    def __init__(self, progress: Progress, total: int) -> None:
        self._progress, self._total, self._count, self._what = progress, total, 0, ""

    def say(self, what: str) -> None:
        self._what = what
        self.done(0)

    def done(self, count: int = 1) -> None:
        self._count += count
        self._progress(min(1.0, self._count / self._total), self._what)


def _ticks(source: BenchArm, size: Size, work: _WorkDone) -> tuple[list[Row], list[Memory]]:
    name = source.name
    work.say(f"{name}: recording a line")
    line = record_line(source, source.load())
    tight = record_line(source, tighten(line))
    parts = {solver: TickParts(line, solver) for solver in ("daqp", "osqp")}
    limited = operational_space(tight)
    share = np.mean([bool(limited(index).active_limits) for index in range(len(tight.observations))])
    own: dict[str, tuple[Callable[[int], Any], str]] = {
        YARDSTICK: (_yardstick(line), "fixed work in Pinocchio and numpy, none of it the project's"),
        "operational space": (operational_space(line), "state to torque, every limit, friction feed-forward"),
        "operational space, limits active": (limited, f"speeds limited below the line's; they bind in {share:.0%}"),
        "operational space, Python task": (with_python_task(line), "the same with a user's task in plain Python"),
        "operational space, osqp": (operational_space(line, "osqp"), "the same with the other solver"),
        "impedance": (impedance(line), "state to torque, every limit, friction feed-forward"),
    }
    peers = {f"{name} {peer.key}": (peer.tick(line), peer.does) for peer in PEERS}
    pieces = [Work(f"{name} {key}", call) for key, (call, _) in own.items()]
    pieces += [tick.work(f"{name} parts {solver}") for solver, tick in parts.items()]
    pieces += [Work(key, call) for key, (call, _) in peers.items() if not isinstance(call, str)]
    work.done(10)
    work.say(f"{name}: ticks")

    def round_done() -> None:
        for tick in parts.values():
            tick.block_done()
        work.done()

    with garbage_kept():
        timings = time_in_turns(pieces, size.blocks, size.block_time, round_done)
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
    return rows + _part_rows(name, parts, ticks[0]), memory


def _part_rows(name: str, parts: Mapping[str, TickParts], yardstick: Row) -> list[Row]:
    rows = [timed_row(f"{name} {part}", "stage", timing) for part, timing in parts["daqp"].timings().items()]
    rows.append(timed_row(f"{name} QP, osqp", "stage", parts["osqp"].timings()["QP"]))
    return [_with_ratio(row, yardstick) for row in rows]


def _ratios(rows: Iterable[Row], against: str, peers_against: str = "") -> list[Row]:
    """Return the rows with their ratios to the row `against`, those of peers with ratios to `peers_against`."""
    rows = list(rows)
    named = {row.key: row for row in rows}
    return [_with_ratio(row, named[peers_against if row.table == "peer" else against]) for row in rows]


def _with_ratio(row: Row, other: Row) -> Row:
    if not row.count or row.key == other.key:
        return row
    # The two blocks of one round ran under the same load of the machine.
    ratios = np.array(row.blocks_us) / np.array(other.blocks_us)
    low, middle, high = np.percentile(ratios, [10.0, 50.0, 90.0]).tolist()
    spread = 0.5 * (high - low) / middle
    return row.model_copy(update={"ratio": middle, "spread": spread, "against": other.key})


def _yardstick(line: RecordedLine) -> Callable[[int], object]:
    """Return work of a tick's type and size, whose time does not depend on the project's code."""
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
