"""One attempt of a study: the work item of a worker, its report, and the row in the store."""

from __future__ import annotations

import json
import socket
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..config import Scenario
from ..exceptions import ConfigurationError, PilegraspError, SimulationError, environment_fault, shortened
from ..plugins import Plugin, explain, load_plugin, use_plugins
from .origins import check_origins

if TYPE_CHECKING:
    from ..programs.result import EpisodeResult
    from ..recording import Recording

CLOCKED = ("wall_time", "realtime_factor")
"""Entries of a result that differ from run to run, like the control tick's `median_us` and `p99_us`."""


@dataclass(frozen=True, slots=True)
class WorkItem:
    """One attempt, as a worker gets it.

    Attributes:
        scenario: Scenario of the attempt.
        config_hash: Hash of the scenario in the process that planned the study.
        seed: Seed of pile and sensor noise.
        record: Whether to record: "no", "yes", or "failures" for attempts without success only.
        measure: Name `module:function` of a function of the recording, or None.
        origins: Versions and digests that the result depends on, as in the process that planned the study.
        plugins: Folders of the user's functions.
    """

    scenario: Scenario
    config_hash: str
    seed: int
    record: str
    measure: str | None
    origins: Mapping[str, str]
    plugins: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class AttemptReport:
    """The result of one attempt, as a worker reports it.

    Attributes:
        config_hash: Hash of the scenario.
        seed: Seed of the attempt.
        result: JSON text without times of a clock; None if the attempt raised.
        error: Sentence of the error that was raised, or None.
        success: Whether the attempt succeeded.
        recording: Bytes of the `.npz`, or None.
        processor_time: Processor time of the thread that ran the attempt [s].
        wall_time: Time of the attempt on the wall clock [s].
        host: Name of the machine.
    """

    config_hash: str
    seed: int
    result: str | None
    error: str | None
    success: bool = False
    recording: bytes | None = None
    processor_time: float = 0.0
    wall_time: float = 0.0
    host: str = ""


@dataclass(frozen=True, slots=True)
class AttemptRow:
    """One row of the table `attempts`.

    Attributes:
        config_hash: Hash of the scenario.
        seed: Seed of the attempt.
        condition: Scenario's name under "scenario", and the varied values.
        result: Values of `pilegrasp run --json` without times of a clock, and `measures` if there was a measure; None
            if the attempt raised.
        error: Sentence of the error that was raised, or None.
    """

    config_hash: str
    seed: int
    condition: Mapping[str, Any]
    result: Mapping[str, Any] | None
    error: str | None

    @property
    def success(self) -> bool:
        """Whether the attempt succeeded; False if it raised."""
        return self.result is not None and bool(self.result["success"])

    @property
    def grasped(self) -> int:
        """Number of objects held at the end."""
        return 0 if self.result is None else int(self.result["grasped"])

    @property
    def triggered(self) -> bool:
        """Whether the push ended because the wrist sensor felt F_grasp."""
        outcomes = () if self.result is None else self.result["outcomes"]
        return any(outcome["trigger"] == "grasp force" for outcome in outcomes)


def run_work_item(item: WorkItem) -> AttemptReport:
    """Run one attempt; an error that it raises becomes part of the report.

    Raises:
        ConfigurationError: Versions or files of this process differ from those of the study, so its result would too.
        MemoryError: The memory is too small; the attempt may be repeated.
        SimulationError: The environment has refused something, such as space on a disk. That is no result.
    """
    use_plugins(item.plugins)
    if item.scenario.config_hash() != item.config_hash:
        raise ConfigurationError(
            "a file that the scenario names has changed since the study began; restore it, or choose another folder"
        )
    check_origins(item.origins, item.scenario, item.measure)
    wall, processor = time.perf_counter(), time.thread_time()
    result = error = recording = None
    success = False
    try:
        result, success, recording = _run(item)
    except MemoryError:
        raise
    except Exception as problem:
        error = _sentence(problem, item.seed)
    return AttemptReport(
        item.config_hash,
        item.seed,
        result,
        error,
        success,
        recording,
        time.thread_time() - processor,
        time.perf_counter() - wall,
        socket.gethostname(),
    )


def _sentence(problem: Exception, seed: int) -> str:
    """Return the sentence of an attempt that raised, the same each time.

    Raises:
        SimulationError: The environment is the cause.
    """
    if fault := environment_fault(problem):
        raise SimulationError(
            f"seed {seed} could not run on {socket.gethostname()}: {fault}; that is no result, so the study stops; "
            "finished attempts are kept, and the same command runs the rest"
        ) from problem
    if isinstance(problem, SimulationError):
        problem.forget_states()
        text = shortened(problem.reason)
    else:
        text = str(problem) if isinstance(problem, PilegraspError) else f"{type(problem).__name__}: {problem}"
    # The name of a file may not be Unicode, but the store's text is.
    return shortened(text).encode("utf-8", errors="backslashreplace").decode()


def _run(item: WorkItem) -> tuple[str, bool, bytes | None]:
    from ..episode import run

    episode = run(item.scenario, seed=item.seed, record=item.record != "no" or item.measure is not None)
    document = repeatable(episode)
    if item.measure is not None and episode.recording is not None:
        document["measures"] = measured(item.measure, episode.recording)
    wanted = item.record == "yes" or (item.record == "failures" and not episode.success)
    recording = episode.recording.to_bytes() if wanted and episode.recording is not None else None
    return json.dumps(document, allow_nan=False), episode.success, recording


def repeatable(episode: EpisodeResult) -> dict[str, Any]:
    """Return the result as JSON values, without times of a clock."""
    document = {key: value for key, value in episode.as_dict().items() if key not in CLOCKED}
    controller = document["controller"]
    return document | {"controller": {key: value for key, value in controller.items() if not key.endswith("_us")}}


def measured(name: str, recording: Recording) -> dict[str, Any]:
    """Return what a measure says of a recording, as JSON values.

    Raises:
        ConfigurationError: There is no such measure, it raises, or it returns something else.
    """
    function = load_measure(name).function
    try:
        values = function(recording)
    except PilegraspError:
        raise
    except Exception as error:
        raise ConfigurationError(f"measure = {name!r} raised {explain(error)}") from error
    try:
        # numpy's numbers and arrays become plain values.
        plain = json.loads(json.dumps(dict(values), default=lambda value: value.tolist(), allow_nan=False))
    except (TypeError, ValueError, AttributeError) as error:
        raise ConfigurationError(
            f"measure = {name!r} returned {values!r:.120}, which is no dict of finite numbers: {error}"
        ) from None
    return dict(plain)


def load_measure(name: str) -> Plugin:
    """Return the measure with a name `module:function`.

    Raises:
        ConfigurationError: The module cannot be imported, or has no such function.
    """
    return load_plugin(name, "measure", ("recording",))
