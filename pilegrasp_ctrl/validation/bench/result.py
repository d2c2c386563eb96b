"""The result of the benchmark as a document, which `pilegrasp bench --save` writes and `--compare` reads."""

from __future__ import annotations

import os
import platform
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ...exceptions import ConfigurationError
from ...files import read_file
from ...provenance import ABSENT, versions
from .clock import Timing

MAX_SIZE = 1 << 24
"""Largest file of a result that is read [bytes]; chosen, a thousand times the usual size."""

OTHER_PACKAGES = ("osqp", "qpsolvers", "pin-pink", "tsid")
"""Packages whose versions a result contains, beside those that decide an attempt."""

Table = Literal["tick", "stage", "peer", "import"]
"""Table of a line; "stage" holds the parts of the operational-space tick."""


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


class Row(_Document):
    """One line of a table; times in microseconds.

    Attributes:
        key: Name of the line, such as "wam7 operational space".
        table: Table to which the line belongs.
        count: Number of timed calls; 0 if the work could not be timed.
        median_us: Median of all calls; None without calls, like the next two.
        p99_us: 99th percentile.
        worst_us: Longest call.
        tail: Ratio of p99 to median within a block, the median over the blocks; other programs hardly affect it.
        blocks_us: Median of each block.
        ratio: Ratio to the line that `against` names, the median over the blocks.
        spread: Half the distance from the 10th to the 90th percentile of the blocks' ratios, over `ratio`.
        against: Key of another line of the same run.
        note: Description of the work, or the reason why it is not timed.
    """

    key: str
    table: Table
    count: int = Field(ge=0)
    median_us: float | None = Field(default=None, gt=0.0)
    p99_us: float | None = Field(default=None, gt=0.0)
    worst_us: float | None = Field(default=None, gt=0.0)
    tail: float | None = Field(default=None, ge=1.0)
    blocks_us: tuple[float, ...] = ()
    ratio: float | None = Field(default=None, gt=0.0)
    spread: float | None = Field(default=None, ge=0.0)
    against: str = ""
    note: str = ""


class Memory(_Document):
    """The memory that a tick allocates; `ticks.Allocation` explains each number."""

    key: str
    peak_bytes: float
    kept_blocks: float
    kept_bytes: float
    growth_blocks: int
    growth_bytes: int
    ticks: int


class LoopRow(_Document):
    """Closed loop against bare physics, per control period, by processor time.

    Attributes:
        phase: "push" or "attempt".
        chunks: Number of comparisons.
        ratio: Loop over bare physics, the median over the chunks.
        ratio_p10: 10th percentile of that ratio.
        ratio_p90: 90th percentile of that ratio.
        period_us: Median time of the loop.
        bare_us: Part of it in the engine's steps, as timed without the loop.
        control_us: Part of it from the observation to the command.
        glue_us: Remaining part: sensor, watchdog, and what cold caches cost the engine.
        realtime_factor: Simulated time over processor time of the loop.
    """

    phase: str
    chunks: int = Field(ge=1)
    ratio: float = Field(gt=0.0)
    ratio_p10: float
    ratio_p90: float
    period_us: float
    bare_us: float
    control_us: float
    glue_us: float
    realtime_factor: float


class Target(_Document):
    """One target of the project.

    Attributes:
        name: Description of the measured number.
        value: Measured value; None if nothing was measured.
        relation: Required relation of the value to `bound`.
        bound: Bound of the value.
        met: Whether the target is met; None if nothing was measured.
    """

    name: str
    value: float | None
    relation: Literal[">=", "<="]
    bound: float
    met: bool | None


class Settings(_Document):
    """The settings and the machine of a run; its times mean little without them.

    Attributes:
        quick: Whether the run took few samples.
        threads: Value of OMP_NUM_THREADS, or "" if it was not set.
        processors: Number of processors that this process may use.
        load: Load average of the last minute when the run began.
        processor: Name of the processor.
        scenario: Scenario of the closed loop.
        seeds: Seeds of its attempts.
    """

    quick: bool
    threads: str
    processors: int
    load: float
    processor: str
    scenario: str
    seeds: tuple[int, ...]


class BenchResult(_Document):
    """All measurements of one run."""

    form: Literal["pilegrasp-bench-1"] = "pilegrasp-bench-1"
    settings: Settings
    versions: dict[str, str]
    rows: tuple[Row, ...]
    memory: tuple[Memory, ...]
    loop: tuple[LoopRow, ...]
    replay_exact: bool
    targets: tuple[Target, ...]

    def row(self, key: str) -> Row | None:
        """Return the line with that key, or None."""
        return next((row for row in self.rows if row.key == key), None)


def load_result(path: Path) -> BenchResult:
    """Read a file that `pilegrasp bench --save` wrote.

    Raises:
        ConfigurationError: The file cannot be read or has another form.
    """
    text = read_file(path, MAX_SIZE, "of a result")
    try:
        return BenchResult.model_validate_json(text, strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"]) or "the document"
        raise ConfigurationError(
            f"{path}: is not a result of `pilegrasp bench --save` ({place}: {first['msg']}); save one with this version"
        ) from None


def timed_row(key: str, table: Table, timing: Timing, note: str = "") -> Row:
    """Return a line without a ratio."""
    return Row(
        key=key,
        table=table,
        count=timing.calls,
        median_us=1e6 * timing.median,
        p99_us=1e6 * timing.p99,
        worst_us=1e6 * timing.worst,
        tail=timing.tail if table != "import" else None,
        blocks_us=tuple(1e6 * value for value in timing.blocks),
        note=note,
    )


def settings_of(scenario: str, seeds: tuple[int, ...], quick: bool) -> Settings:
    """Return the settings of a run on this machine."""
    return Settings(
        quick=quick,
        threads=os.environ.get("OMP_NUM_THREADS", ""),
        processors=len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1,
        load=os.getloadavg()[0],
        processor=_processor(),
        scenario=scenario,
        seeds=seeds,
    )


def _processor() -> str:
    """Return the processor's name if the system gives it, else the architecture."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())


def installed_versions() -> dict[str, str]:
    """Return the versions of Python and of those packages of a run that are installed."""
    found = {"python": platform.python_version()} | versions(*OTHER_PACKAGES)
    return {name: version for name, version in found.items() if version != ABSENT}
