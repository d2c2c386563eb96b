"""The result of the benchmark as a document: what `pilegrasp bench --save` writes and `--compare` reads."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ...exceptions import ConfigurationError
from .clock import Timing


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)


class Row(_Part):
    """One line of a table; times in microseconds.

    Attributes:
        key: names the line, such as "wam7 operational space".
        table: "tick", "stage", "peer" or "import".
        count: number of calls that were timed; 0 where it could not be.
        median_us: of all calls, None where there are none; likewise the next two.
        p99_us: 99th percentile.
        worst_us: the longest.
        tail: p99 over median within a block, the median over the blocks; other programs hardly count in it.
        blocks_us: median of each block.
        ratio: to the line that `against` names, the median over the blocks.
        spread: half the distance from the 10th to the 90th percentile of the blocks' ratios, over `ratio`.
        against: key of a line of the same run.
        note: what is timed, or why it is not.
    """

    key: str
    table: Literal["tick", "stage", "peer", "import"]
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


class Memory(_Part):
    """What a tick allocates; `ticks.Allocation` has the meaning of each number."""

    key: str
    peak_bytes: float
    kept_blocks: float
    kept_bytes: float
    growth_blocks: int
    growth_bytes: int
    ticks: int


class LoopRow(_Part):
    """Closed loop against bare physics, per control period, by processor time.

    Attributes:
        phase: "push" or "attempt", with ", compiled" where the controller was.
        chunks: number of comparisons.
        ratio: loop over bare, the median over the chunks.
        ratio_p10: 10th percentile.
        ratio_p90: 90th percentile.
        period_us: median time of the loop.
        bare_us: thereof the engine's steps, as timed without the loop.
        control_us: thereof from the observation to the command.
        glue_us: the rest: sensor, watchdog, and what cold caches cost the engine.
        realtime_factor: simulated time over processor time of the loop.
    """

    phase: str
    chunks: int
    ratio: float
    ratio_p10: float
    ratio_p90: float
    period_us: float
    bare_us: float
    control_us: float
    glue_us: float
    realtime_factor: float


class Target(_Part):
    """What the project set out to reach.

    Attributes:
        name: a sentence.
        value: what was measured, None where it could not be.
        relation: how it shall compare with `bound`.
        bound: the target.
        met: whether it is reached, None where it could not be measured.
    """

    name: str
    value: float | None
    relation: Literal[">=", "<="]
    bound: float
    met: bool | None


class Settings(_Part):
    """How the run was made.

    Attributes:
        quick: whether with few samples.
        threads: OMP_NUM_THREADS as the interpreter saw it, or "".
        processors: that this process may use.
        load: load average of the last minute when the run began.
        processor: its name.
        scenario: of the closed loop.
        seeds: its attempts.
    """

    quick: bool
    threads: str
    processors: int
    load: float
    processor: str
    scenario: str
    seeds: tuple[int, ...]


class BenchResult(_Part):
    """Everything that one run measured."""

    form: Literal["pilegrasp-bench-1"] = "pilegrasp-bench-1"
    settings: Settings
    versions: dict[str, str]
    rows: tuple[Row, ...]
    memory: tuple[Memory, ...]
    loop: tuple[LoopRow, ...]
    replay_exact: bool
    targets: tuple[Target, ...]

    def row(self, key: str) -> Row | None:
        """Return the line of that name, None where there is none."""
        return next((row for row in self.rows if row.key == key), None)


def load_result(path: Path) -> BenchResult:
    """Read what `pilegrasp bench --save` wrote.

    Raises:
        ConfigurationError: where the file cannot be read or has another form.
    """
    try:
        text = path.read_bytes()
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be read: {error.strerror}") from None
    try:
        return BenchResult.model_validate_json(text, strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"]) or "the document"
        raise ConfigurationError(
            f"{path}: is not a result of `pilegrasp bench --save` ({place}: {first['msg']}); save one with this version"
        ) from None


def timed_row(key: str, table: Literal["tick", "stage", "peer", "import"], timing: Timing, note: str = "") -> Row:
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
