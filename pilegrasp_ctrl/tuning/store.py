"""The store of a search: one SQLite file with its definition, the trials and their reports."""

from __future__ import annotations

import hashlib
import json
import os
import sqlite3
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import optuna
from optuna.distributions import FloatDistribution
from optuna.trial import FrozenTrial, TrialState

from ..exceptions import ConfigurationError, ExportError, PilegraspError
from ..study.origins import difference
from ..study.spread import even_shares
from .objectives import Measured
from .trial import TrialReport

SAMPLER_SEED = 20200312
"""Seed of the sampler for trial 0; trial n has this plus n (chosen)."""
BATCH = 4
"""Number of trials that are proposed together, before any of them runs (chosen). The proposals therefore depend neither
on the number of workers nor on their speed."""
SPREAD = 12
"""Number of trials that cover the space evenly before the sampler proposes, including the start (chosen)."""
FAILED = 100.0
"""Violation of the constraint that the sampler gets for a trial that was not completed (chosen)."""

_SEARCH, _NOTES = "search", "sensitivity"


@dataclass(frozen=True, slots=True)
class TrialRecord:
    """A finished trial.

    Attributes:
        number: Number of the trial; 0 is the start.
        values: Numbers that were proposed, unrounded.
        report: Report of the worker.
    """

    number: int
    values: Mapping[str, float]
    report: TrialReport


class TuningStore:
    """The store of a search over gains, which survives the process.

    Every trial is proposed from its own seed and from the trials of earlier batches. A search that was killed therefore
    goes on with the same proposals.
    """

    def __init__(
        self,
        path: Path,
        configuration: Mapping[str, Any],
        bounds: Mapping[str, tuple[float, float]],
        start: Mapping[str, float],
        scores: Callable[[Measured], tuple[float, ...]],
        objectives: int,
    ) -> None:
        """Open a store, or make one.

        Args:
            path: SQLite file in a folder that exists.
            configuration: JSON values on which every result depends.
            bounds: Lowest and highest value of each number.
            start: Numbers of the first trial.
            scores: Function from measurements to the scores that the sampler minimises.
            objectives: Number of scores.

        Raises:
            ConfigurationError: The store holds another search.
            ExportError: The file is not a store, or cannot be written.
        """
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self.path, self._start, self._scores = path, dict(start), scores
        self._distributions = {name: FloatDistribution(low, high, log=True) for name, (low, high) in bounds.items()}
        with self._explained():
            _check_file(path)
            # The name of a file may hold characters that mean something in an address.
            connect = partial(sqlite3.connect, os.fspath(path.resolve()), check_same_thread=False)
            self._storage = optuna.storages.RDBStorage("sqlite:///tuning.db", engine_kwargs={"creator": connect})
            self._search = optuna.create_study(
                study_name=_SEARCH,
                storage=self._storage,
                directions=["minimize"] * objectives,
                load_if_exists=True,
            )
            self._notes = optuna.create_study(study_name=_NOTES, storage=self._storage, load_if_exists=True)
            self._check(json.loads(json.dumps(configuration)))

    @contextmanager
    def _explained(self) -> Iterator[None]:
        """Turn the errors of a file that is damaged or no store, which are of many types, into a sentence."""
        try:
            yield
        except PilegraspError:
            raise
        except Exception as error:
            reason = str(error).partition("\n")[0]
            raise ExportError(
                f"{self.path}: is not the store of a search, is damaged, or cannot be written: {reason}"
            ) from error

    @property
    def study(self) -> optuna.Study:
        """Search as a study of optuna."""
        return self._search

    def _check(self, configuration: dict[str, Any]) -> None:
        known = self._search.user_attrs.get("configuration")
        if known is None:
            self._search.set_user_attr("configuration", configuration)
        elif known != configuration:
            raise ConfigurationError(
                f"{self.path} holds another search: {difference(known, configuration)}; choose another --out, or "
                "repeat the command that began it"
            )

    def records(self) -> list[TrialRecord]:
        """Return the finished trials, sorted by number.

        Raises:
            ExportError: The file is damaged.
        """
        states = (TrialState.COMPLETE, TrialState.PRUNED)
        with self._explained():
            return [self._record(trial) for trial in self._search.get_trials(deepcopy=False, states=states)]

    def _record(self, trial: FrozenTrial) -> TrialRecord:
        content = trial.user_attrs.get("report")
        if trial.user_attrs.get("digest") != _digest(trial.number, trial.params, content):
            raise ExportError(f"{self.path}: trial {trial.number} is damaged; choose another --out")
        table = dict(content)
        measured = table.pop("measured")
        ringing = tuple(table.pop("ringing"))
        report = TrialReport(measured=Measured(**measured) if measured else None, ringing=ringing, **table)
        if report.measured is not None and tuple(trial.values or ()) != self._scores(report.measured):
            raise ExportError(f"{self.path}: the scores of trial {trial.number} are damaged; choose another --out")
        return TrialRecord(trial.number, trial.params, report)

    def propose(self, total: int) -> list[tuple[int, dict[str, float]]]:
        """Return number and values of the trials that run next; none if `total` are finished.

        Raises:
            ExportError: The file is damaged or cannot be written.
        """
        with self._explained():
            return self._propose(total)

    def _propose(self, total: int) -> list[tuple[int, dict[str, float]]]:
        begun = self._search.get_trials(deepcopy=False)
        count = len(begun)
        # A batch may be incomplete, after an interrupt or because of a smaller `total` in an earlier run.
        whole = count % BATCH == 0 and all(trial.state.is_finished() for trial in begun)
        end = min(total, count + BATCH if whole else -(-count // BATCH) * BATCH)
        if any(trial.state == TrialState.WAITING for trial in begun):
            self._ask(count - 1)
        for trial in begun:
            if trial.state == TrialState.RUNNING and trial.params.keys() != self._distributions.keys():
                self._complete(trial)
        for number in range(count, end):
            self._ask(number)
        running = self._search.get_trials(deepcopy=False, states=(TrialState.RUNNING,))
        return [(trial.number, dict(trial.params)) for trial in running]

    def _complete(self, begun: FrozenTrial) -> None:
        """Add the numbers that a trial lacks because the process was killed while it wrote them; they are the same."""
        self._prepare_sampler(begun.number)
        trial = self._trial(begun.number)
        for name, bound in self._distributions.items():
            trial.suggest_float(name, bound.low, bound.high, log=True)

    def _trial(self, number: int) -> optuna.trial.Trial:
        return optuna.trial.Trial(self._search, self._search.get_trials(deepcopy=False)[number]._trial_id)

    def _prepare_sampler(self, number: int) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            self._search.sampler = optuna.samplers.TPESampler(
                seed=SAMPLER_SEED + number, n_startup_trials=SPREAD, multivariate=True, constant_liar=True
            )

    def _ask(self, number: int) -> None:
        self._prepare_sampler(number)
        fixed = self._start if number == 0 else self._spread(number) if number < SPREAD else None
        waiting = self._search.get_trials(deepcopy=False, states=(TrialState.WAITING,))
        if fixed is not None and not waiting:
            self._search.enqueue_trial(fixed)
        self._search.ask(self._distributions)

    def _spread(self, number: int) -> dict[str, float]:
        """Return a point that covers the space evenly, on the logarithmic scale of the search."""
        shares = even_shares(number, len(self._distributions))
        return {
            name: float(bound.low * (bound.high / bound.low) ** share)
            for name, bound, share in zip(self._distributions, self._distributions.values(), shares, strict=True)
        }

    def tell(self, report: TrialReport) -> None:
        """Write the report of a trial; when this returns, it is kept.

        Raises:
            ExportError: The file is damaged or cannot be written.
        """
        with self._explained():
            self._tell(report)

    def _tell(self, report: TrialReport) -> None:
        trial = self._trial(report.number)
        with warnings.catch_warnings():
            # If the process was killed while it wrote, the trial has its constraint already, with the same value.
            warnings.simplefilter("ignore")
            worst = max(report.ringing) - 1.0 if report.measured is not None else FAILED
            trial.set_constraint("ringing", min(worst, FAILED))
        content = json.loads(json.dumps(asdict(report)))
        trial.set_user_attr("report", content)
        trial.set_user_attr("digest", _digest(report.number, trial.params, content))
        if report.measured is None:
            self._search.tell(trial, state=TrialState.PRUNED)
        else:
            self._search.tell(trial, self._scores(report.measured))

    def noted(self, key: str) -> Any:
        """Return the value that was noted under a key; None if there is none, or if it is damaged."""
        with self._explained():
            note = self._notes.user_attrs.get(key)
        whole = isinstance(note, dict) and note.get("digest") == _digest(key, note.get("value"))
        return note["value"] if whole else None

    def note(self, key: str, value: Any) -> None:
        """Note a JSON value that takes long to compute.

        Raises:
            ExportError: The file is damaged or cannot be written.
        """
        with self._explained():
            self._notes.set_user_attr(key, {"value": value, "digest": _digest(key, value)})


def _check_file(path: Path) -> None:
    """Refuse a file whose pages are damaged; SQLite itself finds that only when it reads them."""
    if not os.path.lexists(path):
        return
    if not path.is_file():
        raise ExportError(f"{path}: is not a regular file; choose another --out")
    with closing(sqlite3.connect(path)) as connection:
        ((verdict,),) = connection.execute("PRAGMA quick_check(1)").fetchall()
    if verdict != "ok":
        raise ExportError(f"{path}: is damaged: {verdict}; choose another --out")


def _digest(*content: Any) -> str:
    """Return a digest of JSON values, which tells whether they are as they were written."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
