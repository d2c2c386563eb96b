"""One attempt of a study, as a worker carries it out and reports it."""

from __future__ import annotations

import json
import os
import socket
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..config import Scenario
from ..exceptions import ConfigurationError, PilegraspError
from .origins import check_origins

if TYPE_CHECKING:
    from ..episode import EpisodeResult
    from ..recording import Recording

Measure = Callable[["Recording"], Mapping[str, Any]]

CLOCKED = ("wall_time", "realtime_factor")
"""Entries of a result that no two runs share; beside them the control tick's `median_us` and `p99_us`."""


@dataclass(frozen=True, slots=True)
class WorkItem:
    """What a worker is told.

    Attributes:
        scenario: of the attempt.
        config_hash: of the scenario where the study was planned.
        seed: of pile and sensor noise.
        record: "no", "yes", or "failures" for a recording of what does not succeed.
        measure: dotted name of a function of the recording, or None.
        origins: what the result depends on where the study was planned, by name.
    """

    scenario: Scenario
    config_hash: str
    seed: int
    record: str
    measure: str | None
    origins: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class AttemptReport:
    """What a worker answers.

    Attributes:
        config_hash: of the scenario.
        seed: of the attempt.
        result: JSON text without anything that a clock told, or None where the attempt raised.
        error: the sentence that it raised, or None.
        success: whether the attempt succeeded.
        recording: bytes of the `.npz`, or None.
        processor_time: of the thread that ran the attempt [s].
        wall_time: likewise, on the wall clock [s].
        host: name of the machine.
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
    """One row of `attempts`.

    Attributes:
        config_hash: of the scenario.
        seed: of the attempt.
        condition: the scenario's name under "scenario", and what was varied.
        result: as `pilegrasp run --json` without what a clock told, and `measures` where there was a measure; None
            where the attempt raised.
        error: the sentence that it raised, or None.
    """

    config_hash: str
    seed: int
    condition: Mapping[str, Any]
    result: Mapping[str, Any] | None
    error: str | None

    @property
    def success(self) -> bool:
        """Whether the attempt succeeded; one that raised did not."""
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


def run_work_item(task: WorkItem) -> AttemptReport:
    """Run one attempt; whatever it raises becomes part of the report.

    Raises:
        ConfigurationError: where this process would not get the result that was asked for: other versions, other files.
        MemoryError: where there was too little; the attempt may be repeated.
    """
    if task.scenario.config_hash() != task.config_hash:
        raise ConfigurationError(
            "a file that the scenario names differs from what it was when the study began; choose another folder"
        )
    check_origins(task.origins, task.scenario, task.measure)
    wall, processor = time.perf_counter(), time.thread_time()
    result = error = recording = None
    success = False
    try:
        result, success, recording = _result(task)
    except MemoryError:
        raise
    except PilegraspError as problem:
        error = str(problem)
    except Exception as problem:
        error = f"{type(problem).__name__}: {problem}"
    return AttemptReport(
        task.config_hash,
        task.seed,
        result,
        error,
        success,
        recording,
        time.thread_time() - processor,
        time.perf_counter() - wall,
        socket.gethostname(),
    )


def _result(task: WorkItem) -> tuple[str, bool, bytes | None]:
    from ..episode import run

    episode = run(task.scenario, seed=task.seed, record=task.record != "no" or task.measure is not None)
    document = repeatable(episode)
    if task.measure is not None:
        assert episode.recording is not None
        document["measures"] = dict(load_measure(task.measure)(episode.recording))
    wanted = task.record == "yes" or (task.record == "failures" and not episode.success)
    recording = _bytes(episode.recording) if wanted and episode.recording is not None else None
    return json.dumps(document, allow_nan=False), episode.success, recording


def repeatable(episode: EpisodeResult) -> dict[str, Any]:
    """Return the result as JSON values, without those that a clock told."""
    document = {key: value for key, value in episode.as_dict().items() if key not in CLOCKED}
    controller = document["controller"]
    return document | {"controller": {key: value for key, value in controller.items() if not key.endswith("_us")}}


def load_measure(name: str) -> Measure:
    """Return the function that a dotted name means.

    Raises:
        ConfigurationError: where there is no such function.
    """
    module, _, function = name.rpartition(".")
    try:
        found = getattr(import_module(module), function)
    except (ImportError, ValueError, AttributeError) as error:
        raise ConfigurationError(
            f"measure = {name!r} cannot be imported ({error}); give package.module.function"
        ) from None
    if not callable(found):
        raise ConfigurationError(f"measure = {name!r} is no function; give package.module.function")
    return found  # type: ignore[no-any-return]


def _bytes(recording: Recording) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{os.getpid()}.npz"
        recording.save(file)
        return file.read_bytes()
